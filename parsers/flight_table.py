"""The flight table: one row per flight, from a spreadsheet, an editor or fieldkit itself.

Columns are those of `fieldkit.flight`, in any order and case; a unit other than the default is named in the header
(`apogee_ft`, `Apogee (ft)`) or in the cell (`923ft`). If the header has no unit, every cell needs one. A readout may
have columns for its standard deviation (`apogee_sd_m`, `apogee_sd_ft`) and its source (`apogee_source`). Unknown
columns are kept unchanged.

Other names for these columns are in `fieldkit/data/flight_columns.toml`. An empty cell, `-`, `?`, `n/a`, `na`, `none`,
`null` or `unknown` in a column of numbers means "not recorded"; `NaN` is the result of failed arithmetic in a program,
and is rejected. Tags are separated by `;`, `|` or `,`.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from functools import lru_cache, partial

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME, READOUTS, read_tags
from fieldkit.flight.readout import ReadoutColumn
from fieldkit.importing import HEAD, ColumnChoice, Mapped, Note, Parsed, Parser, Reading
from fieldkit.importing.manual_entry import check_judged
from fieldkit.importing.tables import headings
from fieldkit.importing.tables.decimal_marks import (
    NOT_RECORDED,
    check_number,
    decimal_mark,
    mass_in,
    number_of,
    precision,
)
from fieldkit.importing.tables.flight_dates import add_time_of_day, date_of, is_day_first, is_own_date
from fieldkit.importing.tables.flight_headings import (
    OWN_COLUMNS,
    ColumnRole,
    beside_a_motor,
    headings_of,
    is_mass,
    judged_name,
    mass_column,
    mass_names,
    plain,
    renamed,
    role_of,
    shape,
    synonyms,
    table_names,
)
from fieldkit.importing.tables.flight_rows import (
    RowsBelow,
    TableRow,
    are_mere_numbers,
    cells_of,
    left_out,
    units_in,
    unread_cells,
)
from fieldkit.importing.tables.header import SEPARATORS
from fieldkit.importing.tables.layout import runs_like_a_log
from fieldkit.importing.tables.mapping import LIFTOFF_MASS, MOTOR_MASS, choice_for, is_of_flights
from fieldkit.importing.tables.text import decode, decode_whole, first_row, shown
from fieldkit.quantities import counted
from fieldkit.safe_text import from_cell
from fieldkit.units import is_unit

MAX_COLUMNS = 500
"""Largest number of columns; fieldkit writes fewer than a hundred. [1]"""
OF_SIMULATIONS = ("velocity off rod", "optimum delay", "ground hit velocity", "velocity at deployment")
"""Columns of OpenRocket's table of the simulations of a design."""
MAX_REPEATED = 500
"""Number of different cells of a column whose values are kept, in case they repeat. [1]"""
_NOTHING_BESIDE: Mapping[str, str] = {}
READOUT_NAMES = frozenset(column.name for column in READOUTS)


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
    if not fields & {"flight_id", "rocket", "motor"} and runs_like_a_log(head):
        return False
    ours = [place for place, name in enumerate(spelled) if _is_ours(name)]
    named = {role_of(name, strict=False, taken=fields).field for name in spelled}
    if not ours and named & set(OWN_COLUMNS) and named & {column.name for column in READOUTS}:
        ours = [place for place, name in enumerate(spelled) if role_of(name, strict=False).field in named - {""}]
    return bool(ours) and not all(map(_is_number, ("".join(spelled[place + 1 : place + 2]) for place in ours)))


def _is_number(cell: str) -> bool:
    """Whether a cell is a bare number, as after each label in a row of labels and values."""
    return re.fullmatch(r"\s*[+-]?\d+([.,]\d+)?\s*", cell) is not None


def read(log: bytes) -> list[Parsed]:
    return read_mapped(log, ())


def read_mapped(log: bytes, choices: Sequence[ColumnChoice]) -> list[Parsed]:
    """The flights of a table, with columns assigned by the first matching choice, otherwise by their names.

    Raises DamagedLog.
    """
    text = decode_whole(log)
    _check_columns(text)
    _refuse_simulations(first_row(text, _separator(text))[1])
    choice = choice_for(table_names(log[:HEAD]), [one for one in choices if is_of_flights(one)])
    separator = _separator(text) if choice is None else _widest(text)
    header_row, spelled = first_row(text, separator)
    names = [from_cell(name) for name in spelled]
    if choice is not None and (bare := shape(names)):  # a table without headers
        header_row, names = header_row - 1, list(bare)
    if choice is not None:
        names = renamed(names, choice, header_row)
    last_header = header_row
    row, cells = next(iter(RowsBelow(text, separator, header_row)), (header_row, []))
    if not isinstance(cells, DamagedLog) and (with_units := units_in(names, cells)):
        names, last_header = with_units, row
    table = RowsBelow(text, separator, last_header, width=len(names))
    headings = _headings(names, header_row, table, named=choice is not None)
    layout = _Layout(headings, decimal_mark(_numbers(headings, table), separator), separator)
    found: list[Parsed] = [_row(row, cells, layout) for row, cells in table]
    found = [*unread_cells(headings, found), *found] or [Note("found a header and no flights", header_row)]
    if choice is None:
        return found
    line = ", ".join(f"{name} = {shown(column)}" for name, column in choice.channels.items())
    kept = ColumnChoice(choice.channels, table_names(log[:HEAD]))
    return [Mapped(f"columns as chosen: {line}", header_row or None, kept, chosen=not choice.headers), *found]


def _headings(names: Sequence[str], header_row: int, table: Iterable[TableRow], *, named: bool) -> list[ColumnRole]:
    """The columns of a table, whose names are fieldkit's own if they were `named` by the flyer, a date's perhaps with
    its order. Raises DamagedLog."""
    orders = [DATE_ORDERS[name] for name in names if name in DATE_ORDERS]
    names = ["date_time" if name in DATE_ORDERS else name for name in names]
    known_columns = beside_a_motor(names)
    headings = [
        role if own == name else replace(role, spelled=name.strip(), loose=True)
        for role, own, name in zip(headings_of(known_columns, header_row), known_columns, names, strict=True)
    ]
    day_first = orders[0] if orders else is_day_first(cells_of("date_time", headings, table))
    if day_first is None and any(one.field == "temperature" and one.unit == "f" for one in headings):
        day_first = False  # those who measure in °F write the month first
    if not named and are_mere_numbers(headings, table):
        headings = [replace(one, field="") if one.field == "flight_id" else one for one in headings]
    headings = [one if one.field or one.beside else _judged(one) for one in headings]
    return [
        replace(one, day_first=day_first, loose=not is_own_date(one.spelled)) if one.field == "date_time" else one
        for one in headings
    ]


def _judged(one: ColumnRole) -> ColumnRole:
    """A column that is no field of a flight: under fieldkit's own name, if it says how a contest flight was judged."""
    name = judged_name(one.spelled)
    return replace(one, kept_as=name, loose=one.loose or (bool(name) and name != plain(one.spelled)))


def _refuse_simulations(names: Sequence[str]) -> None:
    """Raise DamagedLog for a table of simulations: their figures were forecast, not flown."""
    words = (" ".join(headings.heading(name).words) for name in names)
    computed = [name for name in words if any(name.startswith(one) for one in OF_SIMULATIONS)]
    if len(computed) > 1:
        raise DamagedLog(
            f"found a table of simulations, with {shown(computed[0])} and {shown(computed[1])}, expected flown flights",
            row=1,
        )


def _check_columns(text: str) -> None:
    """Raise DamagedLog for a table of more columns than are read: each is compared with the others."""
    if (columns := len(first_row(text, _widest(text))[1])) > MAX_COLUMNS:
        raise DamagedLog(f"found {counted(columns, 'column')} in a table of flights, expected at most {MAX_COLUMNS}")


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


def _numbers(headings: Sequence[ColumnRole], table: Iterable[TableRow]) -> Iterator[str]:
    """All cells of the columns with numbers."""
    places = [place for place, heading in enumerate(headings) if _holds_numbers(heading)]
    for _, cells in table:
        if not isinstance(cells, DamagedLog):
            yield from (cells[place] for place in places if place < len(cells))


def _holds_numbers(heading: ColumnRole) -> bool:
    masses = (mass_names(name) for name in (LIFTOFF_MASS, MOTOR_MASS))
    beside = heading.beside is not None and heading.beside.part == "sd"
    return heading.field in BY_NAME or beside or any(is_mass(heading, words) for words in masses)


def _columns(headings: Sequence[ColumnRole]) -> dict[str, str]:
    """The table's name of each field of a flight, and of the masses that are none."""
    fields = [(heading.field or heading.kept_as, heading.spelled) for heading in reversed(headings)]
    named = {field: spelled for field, spelled in fields if field}
    return named | {name: spelled for name in (LIFTOFF_MASS, MOTOR_MASS) if (spelled := mass_column(headings, name))}


DATE_ORDERS = {"date_time_day/month": True, "date_time_month/day": False}
"""Names of a date that the flyer has chosen with its order, and whether the day comes first."""


class _Layout:
    """What the rows of a table share: its columns, and the values of the cells that repeat, which are kept once."""

    def __init__(self, headings: Sequence[ColumnRole], mark: str, separator: str) -> None:
        self.headings, self.mark, self.separator = headings, mark, separator
        self.columns = _columns(headings)
        self.values = [lru_cache(MAX_REPEATED)(partial(_value, heading=one, mark=mark)) for one in headings]


def _row(row: int, cells: list[str] | DamagedLog, layout: _Layout) -> Parsed:
    """The flight of one row, the error in the row, or a note if it is no flight."""
    note = None if isinstance(cells, DamagedLog) else left_out(row, cells, layout.headings)
    return note or _reading(row, cells, layout)


def _reading(row: int, cells: list[str] | DamagedLog, layout: _Layout) -> Reading | DamagedLog:
    """The flight of one row, without its empty cells, or the error in the row."""
    if isinstance(cells, DamagedLog):
        return cells
    headings, mark = layout.headings, layout.mark
    if any(cell.strip() for cell in cells[len(headings) :]):
        found = f"found {counted(len(cells), 'cell')}, expected at most {len(headings)}, one for each header"
        hint = " (a decimal comma needs quotes around its number)" if layout.separator == "," else ""
        return DamagedLog(found + hint, row=row)
    stated: dict[str, object] = {}
    extra: dict[str, str] = {}
    known: dict[ReadoutColumn, object] = {}
    unread: list[DamagedLog] = []
    remarks: list[str] = []
    for heading, cell, value_of in zip(headings, cells, layout.values, strict=False):
        try:
            if heading.repeats:
                earlier = ((c, h) for h, c in zip(headings, cells, strict=False) if h.spelled == heading.repeats)
                first = next(earlier, ("", heading))
                _repeat(cell, heading, first, stated, mark)
            elif heading.field:
                stated[heading.field] = value_of(cell)
            elif heading.beside:
                known[heading.beside] = _value_beside(cell, heading, heading.beside, mark)
            elif not heading.spelled and _is_remark(cell):
                remarks.append(from_cell(cell).strip())
            elif cell.strip():
                extra[heading.kept_as or heading.spelled] = _known_header(cell, heading)
        except BadValue as error:
            problem = DamagedLog(str(error), row=row, column=heading.spelled or None)
            if not heading.loose:
                return problem
            extra[heading.spelled] = from_cell(cell)  # matched by a name that may mean something else
            unread += [problem] if heading.field in READOUT_NAMES else []
    if unread and not any(stated.get(name) is not None for name in READOUT_NAMES):
        return unread[0]
    add_time_of_day(stated, extra)
    if remarks:
        stated["notes"] = "; ".join(filter(None, [str(stated.get("notes") or ""), *remarks]))
    known = {place: value for place, value in known.items() if value is not None}
    for heading in headings:
        if heading.beside in known and stated.get(heading.beside.readout) is None:
            found = f"found a value beside an empty {BY_NAME[heading.beside.readout].header}, expected none"
            return DamagedLog(found, row=row, column=heading.spelled)
    for place, value in known.items():
        stated[place.part] = {**stated.get(place.part, {}), place.readout: value}  # type: ignore[dict-item]
    try:
        liftoff, motor = (mass_in(cells, headings, mass_names(name), mark) for name in (LIFTOFF_MASS, MOTOR_MASS))
    except BadValue as error:
        return DamagedLog(str(error), row=row)
    if liftoff is not None and motor is not None and stated.get("dry_mass") is None:
        stated["dry_mass"], liftoff = liftoff - motor, None
    stated = {name: value for name, value in stated.items() if value not in (None, "", ())}
    return Reading(stated, extra or _NOTHING_BESIDE, layout.columns, row, liftoff_mass=liftoff)


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


def _value_beside(cell: str, heading: ColumnRole, place: ReadoutColumn, mark: str) -> object:
    """The standard deviation or source of a readout in a cell. Raises BadValue. [SI]"""
    cell = cell.strip()
    if cell.lower() in NOT_RECORDED:
        return None
    if place.part == "sd":
        check_number(cell, BY_NAME[place.readout], heading.unit, mark, heading.spelled)
    return place.read(from_cell(cell))


def _known_header(cell: str, heading: ColumnRole) -> str:
    if not heading.spelled:
        raise BadValue(f"found {shown(cell)} under an empty header, expected a name for the column")
    text = from_cell(cell)
    check_judged(heading.kept_as, text)
    return text


def _is_remark(cell: str) -> bool:
    """Whether a cell under an empty header is words about a flight: no number that needs a name, and no unit of one."""
    return re.match(r"\s*[^\W\d_]{2}", cell) is not None and not is_unit(cell.strip(" ."))


def _date(cell: str, heading: ColumnRole) -> datetime | None:
    """A date in any unambiguous spelling. Raises BadValue."""
    if not cell:
        return None
    if (moment := date_of(cell, heading.day_first)) is None:
        raise BadValue(f"found {shown(cell)}, expected a date such as 2026-05-01 or 2026-05-01T10:30")
    return moment


def _value(cell: str, heading: ColumnRole, mark: str) -> object:
    """The value of a cell: SI, a date, tags or text. Raises BadValue. [SI]"""
    if heading.field not in BY_NAME:
        cell = from_cell(cell)
    if heading.field == "notes":
        return cell
    if heading.field == "date_time":
        return _date(cell.strip(), heading)
    if heading.field == "tags":
        return read_tags(cell)
    if heading.field in BY_NAME:
        return (
            None
            if cell.strip().lower() in NOT_RECORDED
            else number_of(cell.strip(), BY_NAME[heading.field], heading.unit, mark, heading.spelled)
        )
    return cell.strip()


PARSER = Parser(
    "Flight table",
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
