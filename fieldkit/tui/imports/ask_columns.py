"""Asking for the meaning of a table's columns, for rows of the kind detected or chosen."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from fieldkit.importing import ColumnChoice
from fieldkit.importing.tables.mapping import is_of_flights
from fieldkit.services.imports.mappings import TableColumns, table_columns
from fieldkit.tui.asking import or_why
from fieldkit.tui.imports.mapping_form import OTHER_ROWS, MappingForm
from fieldkit.tui.page import PageScreen


def ask_columns(
    page: PageScreen,
    path: Path,
    answer: Callable[[Sequence[str]], None],
    earlier: Sequence[str] = (),
    of: str = "",
) -> None:
    """Ask for the meaning of a file's columns; its rows are `of` samples or flights, or of the kind detected if it is
    empty. `answer` gets a text NAME=COLUMN for each column; the form shows the `earlier` ones of this table, so that a
    mistake in them can be corrected."""

    def show(columns: TableColumns | str) -> None:
        if isinstance(columns, str):
            page.complain(columns)
        else:
            page.app.push_screen(MappingForm(_with(columns, earlier)), partial(answered, columns))

    def answered(columns: TableColumns, values: dict[str, object] | None) -> None:
        if values is not None and OTHER_ROWS in values:
            ask_columns(page, path, answer, earlier, "flights" if columns.of == "samples" else "samples")
        elif values is not None:
            answer([f"{name}={column}" for name, column in values.items() if column])

    page.ask(or_why(partial(table_columns, path, of)), show, "columns")


def _with(columns: TableColumns, earlier: Sequence[str]) -> TableColumns:
    """The columns of a table with their meaning as typed earlier, if it was for this table and this kind of rows."""
    typed = dict(text.split("=", 1) for text in earlier)
    named = all(columns.place(column) is not None for column in typed.values())
    same_kind = bool(typed) and is_of_flights(ColumnChoice(typed)) == (columns.of == "flights")
    return replace(columns, read_as=typed) if named and same_kind else columns
