"""Saved column mappings: listed, edited, deleted."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.importing import HEAD, ColumnChoice
from fieldkit.importing.recognize import table_of
from fieldkit.importing.tables.column_choice import guessed
from fieldkit.importing.tables.flight_headings import role_of, shape, table_names
from fieldkit.importing.tables.layout import layout_of
from fieldkit.importing.tables.mapping import choice_for, edit, forget, is_of_flights, read_choice, remembered
from fieldkit.importing.tables.text import decode, first_names, first_row, no_column, rows
from fieldkit.services.imports.gather import read_file

__all__ = ["TableColumns", "edit", "forget", "in_words", "list_mappings", "table_columns"]


@dataclass(frozen=True, slots=True)
class TableColumns:
    """The columns of a table: their names, the first cell of each, and their current meaning.

    `of` is the kind of its rows, `samples` or `flights`; `read_as` maps channels or fields to columns, in the syntax of
    `--map`.
    """

    of: str
    names: tuple[str, ...]
    first: tuple[str, ...]
    read_as: Mapping[str, str]

    def checked(self, channel: str, text: str) -> str:
        """A column as typed for a channel. Raises BadValue if the table has no such column."""
        if not text:
            return ""
        read_choice([f"{channel}={text}"])
        bare = text.partition(" [")[0].strip()
        known = {name.casefold() for name in self.names} | {f"#{n}" for n in range(1, len(self.names) + 1)}
        if not {text.casefold(), bare.casefold()} & known:
            raise BadValue(no_column(text, self.names))
        return text


def table_columns(path: Path, of: str = "") -> TableColumns:
    """The columns of the table in a file; `of` overrides the detected kind of its rows. Raises FieldkitError for a file
    without a table."""

    head = table_of(read_file(path), path.name)[:HEAD]
    if of != "flights":
        try:
            return _of_samples(head, certain=of == "samples")
        except DamagedLog:
            if of == "samples":
                raise
    return _of_flights(head)


def _of_samples(head: bytes, *, certain: bool) -> TableColumns:
    """The columns of a table of samples. Raises DamagedLog if it is certainly not one."""

    layout = layout_of(head)
    picks = guessed(layout)
    if not certain and layout.named and "time" not in {pick.channel for pick in picks} and _looks_of_flights(head):
        raise DamagedLog("found columns of flights")
    choice = choice_for(layout.headers, remembered())
    read_as = {pick.channel.rstrip("?"): layout.headers[pick.place] for pick in reversed(picks)}
    return TableColumns("samples", layout.headers, layout.first, choice.channels if choice else read_as)


def _of_flights(head: bytes) -> TableColumns:
    """The columns of a table of flights."""

    names, first = table_names(head), first_names(head)
    if not shape(first):
        text = decode(head)
        separator = max((",", ";", "\t"), key=lambda one: len(first_row(text, one)[1]))
        below = (cells for row, cells in rows(text, separator) if row > first_row(text, separator)[0])
        cells = next((one for one in below if not isinstance(one, DamagedLog) and any(one)), [])
        first = tuple(cell.strip() for cell in cells)
    choice = choice_for(names, [one for one in remembered() if is_of_flights(one)])
    roles = ((role_of(name, strict=False).field, name) for name in reversed(names))
    return TableColumns("flights", names, first, choice.channels if choice else {f: name for f, name in roles if f})


def _looks_of_flights(head: bytes) -> bool:
    """Whether a column of a table belongs to flights."""

    return any(role_of(name, strict=False).field for name in table_names(head))


def list_mappings() -> Sequence[ColumnChoice]:
    """The saved column mappings, newest first: `forget` and `edit` count them from 1. Raises FieldkitError."""
    return remembered()


def in_words(choice: ColumnChoice) -> tuple[str, str, str]:
    """The kind of a mapping (`flights` or `samples`), the headers of its tables, and its columns."""
    columns = "; ".join(f"{name}={column}" for name, column in choice.channels.items())
    return "flights" if is_of_flights(choice) else "samples", ", ".join(choice.headers), columns
