"""Asking for the meaning of a table's columns, for rows of the kind detected or chosen."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from fieldkit.services.imports.mappings import TableColumns, table_columns
from fieldkit.tui.asking import or_why
from fieldkit.tui.imports.mapping_form import OTHER_ROWS, MappingForm
from fieldkit.tui.page import PageScreen


def ask_columns(page: PageScreen, path: Path, answer: Callable[[Sequence[str]], None], of: str = "") -> None:
    """Ask for the meaning of a file's columns; its rows are `of` samples or flights, or of the kind detected if it is
    empty. `answer` gets a text NAME=COLUMN for each column."""

    def show(columns: TableColumns | str) -> None:
        if isinstance(columns, str):
            page.complain(columns)
        else:
            page.app.push_screen(MappingForm(columns), partial(answered, columns))

    def answered(columns: TableColumns, values: dict[str, object] | None) -> None:
        if values is not None and OTHER_ROWS in values:
            ask_columns(page, path, answer, "flights" if columns.of == "samples" else "samples")
        elif values is not None:
            answer([f"{name}={column}" for name, column in values.items() if column])

    page.ask(or_why(partial(table_columns, path, of)), show, "columns")
