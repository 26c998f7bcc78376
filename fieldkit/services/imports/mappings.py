"""Saved column mappings: listed, edited, deleted."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME
from fieldkit.importing import HEAD, ColumnChoice
from fieldkit.importing.recognize import shown_damage, table_of
from fieldkit.importing.tables.column_choice import guessed
from fieldkit.importing.tables.flight_headings import role_of, shape, table_names
from fieldkit.importing.tables.headings import QUANTITIES, heading
from fieldkit.importing.tables.layout import Layout, layout_of, split
from fieldkit.importing.tables.mapping import (
    LIFTOFF_MASS,
    MOTOR_MASS,
    choice_for,
    forget,
    is_of_flights,
    read_choice,
    remembered,
)
from fieldkit.importing.tables.mapping import edit as replace_columns
from fieldkit.importing.tables.text import decode, first_names, first_row, no_column, rows
from fieldkit.services.imports.gather import read_file
from fieldkit.units import UNITS, Unit, typed_unit

__all__ = ["TableColumns", "columns_of", "edit", "forget", "in_words", "table_columns"]
MAX_ROWS = 3
"""Number of first rows of a table that are shown. [1]"""


@dataclass(frozen=True, slots=True)
class TableColumns:
    """The columns of a table: their names, the cells of its first rows, and their current meaning.

    `of` is the kind of its rows, `samples` or `flights`; `read_as` maps channels or fields to columns, in the syntax of
    `--map`.
    """

    of: str
    names: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    read_as: Mapping[str, str]

    def cells(self, column: str) -> tuple[str, ...]:
        """The cells of a column in the first rows; a unit in brackets may follow its name."""
        place = self.place(column)
        return () if place is None else tuple(row[place] for row in self.rows if place < len(row))

    def place(self, column: str) -> int | None:
        """The index of a column, None if the table has no such column."""
        bare = column.partition(" [")[0].strip()
        folded = [name.casefold() for name in self.names]
        numbered = [f"#{number}" for number in range(1, len(folded) + 1)]
        for names in (folded, numbered):
            for spelled in (column.strip().casefold(), bare.casefold()):
                if spelled in names:
                    return names.index(spelled)
        return None

    def units(self, channel: str, column: str) -> tuple[str, ...]:
        """The units that a column can have in a channel; none if its name, its cells or the text states one, or if the
        channel has no unit."""
        place, known = self.place(column), UNITS.get(_quantity(channel, self.of), {})
        if place is None or " [" in column or heading(self.names[place]).unit:
            return ()
        if any(name.endswith(f"_{unit}") for name in (self.names[place],) for unit in known):
            return ()
        if any(":" in cell or typed_unit(cell, "") in known for cell in self.cells(column)):
            return ()
        distinct: dict[Unit, str] = {}
        for name, unit in known.items():
            distinct.setdefault(unit, name)
        return tuple(distinct.values())

    def checked(self, channel: str, text: str) -> str:
        """A column as typed for a channel. Raises BadValue if the table has no such column."""
        if not text:
            return ""
        read_choice([f"{channel}={text}"])
        if self.place(text) is None:
            raise BadValue(no_column(text, self.names))
        return text


def _quantity(channel: str, of: str) -> str:
    """The quantity of a channel of samples or of a field of flights, empty for a text."""
    if of == "samples":
        return QUANTITIES.get(channel, "")
    column = BY_NAME.get(channel)
    return column.quantity if column else "mass" if channel in (LIFTOFF_MASS, MOTOR_MASS) else ""


def columns_of(choice: ColumnChoice) -> TableColumns:
    """The columns of the tables of a saved mapping, whose rows are not known."""
    if is_of_flights(choice):
        return TableColumns("flights", choice.headers, (), choice.channels)
    names = (f"#{n}" if name.startswith(f"#{n} ") else name for n, name in enumerate(choice.headers, start=1))
    return TableColumns("samples", tuple(names), (), choice.channels)


def edit(number: int, texts: Iterable[str]) -> ColumnChoice:
    """Replace the columns of a saved mapping, for the same headers. Raises BadValue for a column that these lack,
    FieldkitError if it cannot be saved."""
    typed, known = list(texts), remembered()
    if 1 <= number <= len(known) and known[number - 1].headers:
        columns = columns_of(known[number - 1])
        for channel, column in read_choice(typed).channels.items():
            columns.checked(channel, column)
    return replace_columns(number, typed)


def table_columns(path: Path, of: str = "") -> TableColumns:
    """The columns of the table in a file; `of` overrides the detected kind of its rows. Raises FieldkitError for a file
    without a table."""
    head = table_of(read_file(path), path.name)[:HEAD]
    try:
        if of != "flights":
            try:
                return _of_samples(head, certain=of == "samples")
            except DamagedLog:
                if of == "samples":
                    raise
        return _of_flights(head)
    except DamagedLog as error:
        raise shown_damage(error, path.name) from error


def _of_samples(head: bytes, *, certain: bool) -> TableColumns:
    """The columns of a table of samples. Raises DamagedLog if it is certainly not one."""
    layout = layout_of(head)
    picks = guessed(layout)
    if not certain and layout.named and "time" not in {pick.channel for pick in picks} and _looks_of_flights(head):
        raise DamagedLog("found columns of flights")
    choice = choice_for(layout.saved_names, remembered())
    read_as = {pick.channel.rstrip("?"): layout.headers[pick.place] for pick in reversed(picks)}
    return TableColumns("samples", layout.headers, _first_rows(head, layout), choice.channels if choice else read_as)


def _first_rows(head: bytes, layout: Layout) -> tuple[tuple[str, ...], ...]:
    """The cells of the first rows of a table of samples."""
    text = decode(head)
    lines = (text if "\n" in text else text.replace("\r", "\n")).split("\n")[layout.above :]
    rows = (split(line.rstrip("\r"), layout.separator) for line in lines if line.strip())
    return tuple(tuple(cell.strip() for cell in row) for row in islice(rows, MAX_ROWS))


def _of_flights(head: bytes) -> TableColumns:
    """The columns of a table of flights."""
    names, text = table_names(head), decode(head)
    separator = max((",", ";", "\t"), key=lambda one: len(first_row(text, one)[1]))
    top = 0 if shape(first_names(head)) else first_row(text, separator)[0]
    below = (cells for row, cells in rows(text, separator) if row > top)
    filled = (cells for cells in below if not isinstance(cells, DamagedLog) and any(cells))
    first = tuple(tuple(cell.strip() for cell in cells) for cells in islice(filled, MAX_ROWS))
    choice = choice_for(names, [one for one in remembered() if is_of_flights(one)])
    roles = ((role_of(name, strict=False).field, name) for name in reversed(names))
    return TableColumns("flights", names, first, choice.channels if choice else {f: name for f, name in roles if f})


def _looks_of_flights(head: bytes) -> bool:
    """Whether a column of a table belongs to flights."""
    return any(role_of(name, strict=False).field for name in table_names(head))


def in_words(choice: ColumnChoice) -> tuple[str, str, str]:
    """The kind of a mapping (`flights` or `samples`), the headers of its tables, and its columns."""
    columns = "; ".join(f"{name}={column}" for name, column in choice.channels.items())
    return "flights" if is_of_flights(choice) else "samples", ", ".join(choice.headers), columns
