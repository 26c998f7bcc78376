"""The flight table: one row per flight, from a spreadsheet, an editor or fieldkit itself.

Columns are those of `fieldkit.flight`, in any order and case; a unit other than the default is named in the header
(`apogee_ft`, `Apogee (ft)`) or in the cell (`923ft`). If the header has no unit, every cell needs one. A readout may
have columns for its standard deviation (`apogee_sd_m`, `apogee_sd_ft`) and its source (`apogee_source`). Unknown
columns are kept unchanged.

Other names for these columns are in `fieldkit/data/flight_columns.toml`.

An empty cell, `-`, `n/a` or `none` in a column of numbers means "not recorded"; `NaN` is the result of failed
arithmetic in a program, and is rejected. Tags are separated by `;`, `|` or `,`.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME, READOUTS, Column, read_date, read_tags
from fieldkit.flight.readout import ReadoutColumn
from fieldkit.importing import HEAD, ColumnChoice, Found, Mapped, Note, Parser, Reading
from fieldkit.importing.tables.decimal_marks import THOUSANDS, decimal_mark, precision
from fieldkit.importing.tables.flight_headings import (
    OWN_COLUMNS,
    ColumnRole,
    beside_a_motor,
    headings_of,
    is_mass,
    iso_date,
    mass_column,
    mass_names,
    plain,
    renamed,
    role_of,
    shape,
    synonyms,
    table_names,
)
from fieldkit.importing.tables.mapping import LIFTOFF_MASS, MOTOR_MASS, choice_for, is_of_flights
from fieldkit.importing.tables.text import decode, decode_whole, first_row, rows, shown
from fieldkit.quantities import counted
from fieldkit.safe_text import from_cell

SEPARATORS = (",", ";", "\t")
NOT_RECORDED = ("", "-", "–", "—", "n/a", "na", "none")


def recognises(head: bytes) -> bool:
    text = decode(head)
    names = first_row(text, _separator(text))[1]
    spelled = beside_a_motor(names)
    fields = {role_of(name, strict=False, taken=synonyms().values()).field for name in spelled}
    if (
        spelled == names
        and {"date_time"} == fields & set(OWN_COLUMNS)
        and not fields & {column.name for column in READOUTS}
    ):
        return False  # a log of samples may have a date and time in every row too
    ours = [place for place, name in enumerate(spelled) if _is_ours(name)]
    named = {role_of(name, strict=False, taken=fields).field for name in spelled}
    if not ours and named & set(OWN_COLUMNS) and named & {column.name for column in READOUTS}:
        ours = [place for place, name in enumerate(spelled) if role_of(name, strict=False).field in named - {""}]
    return bool(ours) and not all(map(_is_number, ("".join(spelled[place + 1 : place + 2]) for place in ours)))


def _is_number(cell: str) -> bool:
    """Whether a cell is a bare number, as after each label in a row of labels and values."""
    return re.fullmatch(r"\s*[+-]?\d+([.,]\d+)?\s*", cell) is not None


def read(log: bytes) -> list[Found]:
    return read_mapped(log, ())


def read_mapped(log: bytes, choices: Sequence[ColumnChoice]) -> list[Found]:
    """The flights of a table, with columns assigned by the first matching choice, otherwise by their names.

    Raises DamagedLog.
    """
    text = decode_whole(log)
    choice = choice_for(table_names(log[:HEAD]), [one for one in choices if is_of_flights(one)])
    separator = _separator(text) if choice is None else _widest(text)
    header_row, spelled = first_row(text, separator)
    names = [from_cell(name) for name in spelled]
    if choice is not None and (bare := shape(names)):  # a table without headers
        header_row, names = header_row - 1, list(bare)
    if choice is not None:
        names = renamed(names, choice, header_row)
    told = beside_a_motor(names) if choice is None else names
    headings = [
        role if own == name else replace(role, spelled=name.strip(), loose=True)
        for role, own, name in zip(headings_of(told, header_row), told, names, strict=True)
    ]
    table = [(row, cells) for row, cells in rows(text, separator) if row > header_row]
    if table and not text.endswith(("\n", "\r")):
        table[-1] = _last(*table[-1], len(headings))
    mark = decimal_mark(_numbers(headings, table), separator)
    found: list[Found] = [_reading(row, cells, headings, mark, separator) for row, cells in table if not _blank(cells)]
    found = found or [Note("found a header and no flights", header_row)]
    if choice is None:
        return found
    line = ", ".join(f"{name} = {shown(column)}" for name, column in choice.channels.items())
    kept = ColumnChoice(choice.channels, table_names(log[:HEAD]))
    return [Mapped(f"columns as chosen: {line}", header_row or None, kept, chosen=not choice.headers), *found]


def _widest(text: str) -> str:
    """The separator that splits the header into the most cells."""
    return max(SEPARATORS, key=lambda separator: len(first_row(text, separator)[1]))


def _separator(text: str) -> str:
    """The separator that splits the header into the most known columns."""
    return max(SEPARATORS, key=lambda separator: sum(map(_is_known, first_row(text, separator)[1])))


def _is_known(spelled: str) -> bool:
    try:
        heading = role_of(spelled, strict=True)
        return bool(heading.field or heading.beside)
    except BadValue:
        return True


def _is_ours(spelled: str) -> bool:
    heading = role_of(spelled, strict=False, taken=synonyms().values())
    return heading.field in OWN_COLUMNS or (bool(heading.unit) and heading.field in {c.name for c in READOUTS})


def _blank(cells: list[str] | DamagedLog) -> bool:
    return not isinstance(cells, DamagedLog) and not any(cell.strip() for cell in cells)


def _last(row: int, cells: list[str] | DamagedLog, width: int) -> tuple[int, list[str] | DamagedLog]:
    """The last row of a file that ends within a line: an error if cells are missing."""
    if isinstance(cells, DamagedLog) or len(cells) >= width:
        return row, cells
    return row, DamagedLog(
        f"found {len(cells)} of {counted(width, 'cell')} where the file ends, expected a whole row", row=row
    )


def _numbers(headings: Sequence[ColumnRole], table: Iterable[tuple[int, list[str] | DamagedLog]]) -> Iterator[str]:
    """All cells of the columns with numbers."""
    for _, cells in table:
        if not isinstance(cells, DamagedLog):
            yield from (c for h, c in zip(headings, cells, strict=False) if _holds_numbers(h))


def _holds_numbers(heading: ColumnRole) -> bool:
    return heading.field in BY_NAME or (heading.beside is not None and heading.beside.part == "sd")


def _reading(
    row: int, cells: list[str] | DamagedLog, headings: Sequence[ColumnRole], mark: str, separator: str
) -> Reading | DamagedLog:
    """The flight of one row, or the error in the row."""
    if isinstance(cells, DamagedLog):
        return cells
    if any(cell.strip() for cell in cells[len(headings) :]):
        found = f"found {counted(len(cells), 'cell')} under {counted(len(headings), 'header')}, expected no more"
        hint = " (a decimal comma needs quotes around its number)" if separator == "," else ""
        return DamagedLog(found + hint, row=row)
    stated: dict[str, object] = {}
    extra: dict[str, str] = {}
    known: dict[ReadoutColumn, object] = {}
    for heading, cell in zip(headings, cells, strict=False):
        try:
            if heading.repeats:
                earlier = ((c, h) for h, c in zip(headings, cells, strict=False) if h.spelled == heading.repeats)
                first = next(earlier, ("", heading))
                _repeat(cell, heading, first, stated, mark)
            elif heading.field:
                stated[heading.field] = _value(cell, heading, mark)
            elif heading.beside:
                known[heading.beside] = _value_beside(cell, heading, heading.beside, mark)
            elif cell.strip():
                extra[heading.spelled] = _known_header(cell, heading)
        except BadValue as error:
            if heading.loose:  # matched by a name that may mean something else
                extra[heading.spelled] = from_cell(cell)
                continue
            return DamagedLog(str(error), row=row, column=heading.spelled or None)
    known = {place: value for place, value in known.items() if value is not None}
    for heading in headings:
        if heading.beside in known and stated.get(heading.beside.readout) is None:
            found = f"found a value beside an empty {BY_NAME[heading.beside.readout].header}, expected none"
            return DamagedLog(found, row=row, column=heading.spelled)
    for place, value in known.items():
        stated[place.part] = {**stated.get(place.part, {}), place.readout: value}  # type: ignore[dict-item]
    columns = {heading.field: heading.spelled for heading in reversed(headings) if heading.field}
    try:
        liftoff, motor = (_mass(cells, headings, mass_names(name), mark) for name in (LIFTOFF_MASS, MOTOR_MASS))
    except BadValue as error:
        return DamagedLog(str(error), row=row)
    columns |= {name: spelled for name in (LIFTOFF_MASS, MOTOR_MASS) if (spelled := mass_column(headings, name))}
    if liftoff is not None and motor is not None and stated.get("dry_mass") is None:
        stated["dry_mass"], liftoff = liftoff - motor, None
    return Reading(stated, extra, columns, row, liftoff_mass=liftoff)


def _repeat(
    cell: str, heading: ColumnRole, first: tuple[str, ColumnRole], stated: dict[str, object], mark: str
) -> None:
    """Read a cell of a second column of the same meaning as that of the `first`. Raises BadValue if they differ."""
    value: object = _value(cell, heading, mark) if heading.field else cell.strip()
    before: object = stated.get(heading.field) if heading.field else first[0].strip()
    if heading.field and before in (None, "", ()):
        stated[heading.field] = value
    elif value not in (None, "", (), before):
        column = BY_NAME.get(heading.field)
        rounded = sum(precision(one, column, role.unit) for one, role in ((cell, heading), first)) if column else 0.0
        if column is None or abs(value - before) > rounded:  # type: ignore[operator]
            raise BadValue(f"found {shown(cell)}, expected the value in the column {shown(heading.repeats)}")


def _mass(cells: Sequence[str], headings: Sequence[ColumnRole], words: Collection[str], mark: str) -> float | None:
    """A mass that is not a field of a flight, from the column named with one of these words and a unit. Raises
    BadValue. [kg]"""
    for heading, cell in zip(headings, cells, strict=False):
        if is_mass(heading, words) and cell.strip().lower() not in NOT_RECORDED:
            unit = plain(heading.spelled).rpartition("_")[2]
            return _number(cell.strip(), ColumnRole(heading.spelled, "dry_mass", unit), mark)
    return None


def _value_beside(cell: str, heading: ColumnRole, place: ReadoutColumn, mark: str) -> object:
    """The standard deviation or source of a readout in a cell. Raises BadValue. [SI]"""
    cell = cell.strip()
    if cell.lower() in NOT_RECORDED:
        return None
    if place.part == "sd":
        _check_number(cell, BY_NAME[place.readout], heading, mark)
    return place.read(from_cell(cell))


def _known_header(cell: str, heading: ColumnRole) -> str:
    if not heading.spelled:
        raise BadValue(f"found {shown(cell)} under an empty header, expected a name for the column")
    return from_cell(cell)


def _value(cell: str, heading: ColumnRole, mark: str) -> object:
    """The value of a cell: SI, a date, tags or text. Raises BadValue. [SI]"""
    if heading.field not in BY_NAME:
        cell = from_cell(cell)
    if heading.field == "notes":
        return cell
    if heading.field == "date_time":
        return read_date(iso_date(cell.strip()) if heading.loose else cell.strip())
    if heading.field == "tags":
        return read_tags(cell)
    if heading.field in BY_NAME:
        return None if cell.strip().lower() in NOT_RECORDED else _number(cell.strip(), heading, mark)
    return cell.strip()


def _check_number(cell: str, column: Column, heading: ColumnRole, mark: str) -> None:
    """Raise BadValue for a cell with an ambiguous number or unit."""
    thousands = THOUSANDS.match(cell)
    if thousands and thousands[1] != mark:
        one, other = cell.replace(",", "").replace(".", ""), cell.replace(",", ".")
        raise BadValue(f"found {shown(cell)}, which may be {one} or {other}, expected an unambiguous number")
    if len(cell) > 40:
        raise BadValue(f"found {shown(cell)}, expected a number of at most 40 characters")
    if not heading.unit and cell[-1].isdigit():
        raise BadValue(f"found {shown(cell)} without a unit, expected one as in {cell} {column.unit}")


def _number(cell: str, heading: ColumnRole, mark: str) -> float:
    column = BY_NAME[heading.field]
    _check_number(cell, column, heading, mark)
    try:
        return units.parse(cell, column.quantity, heading.unit)
    except BadValue:
        known = f"{heading.unit}, or with a unit of {column.quantity}" if heading.unit else column.unit
        raise BadValue(f"found {shown(cell)}, expected a number in {known}") from None


PARSER = Parser(
    "Flight table (CSV)",
    recognises,
    read,
    mapped=read_mapped,
    maps="flights",
    signs=(
        "flight_id|rocket|config",
        "motor",
        "date_time|dry_mass_g|diameter_mm",
        "apogee_m|apogee_ft|apogee (m)|apogee (ft)|apogee",
    ),
)
