"""Tables of the manual in the terminal: as wide as their words need, or row by row if that is too wide or too tall."""

from collections.abc import Sequence
from math import ceil
from typing import ClassVar

from rich import box
from rich.console import Console, ConsoleOptions, RenderResult
from rich.markdown import Markdown, TableElement
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

MOST_LINES = 6
"""Lines of a row up to which a table stays one. [1]"""


class ManualTable(TableElement):
    """A table whose words are never cut."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        header = self.header.row if self.header else None
        heads = [cell.content for cell in header.cells] if header else []
        rows = [[cell.content for cell in row.cells] for row in (self.body.rows if self.body else ())]
        widths = column_widths([[one.plain for one in row] for row in [heads, *rows]], options.max_width)
        if widths is None:
            yield from _row_by_row(heads, rows)
            return
        named = any(head.plain for head in heads)
        table = Table(
            box=box.SIMPLE, pad_edge=False, collapse_padding=True, show_header=named, style="markdown.table.border"
        )
        for head, width in zip(heads, widths, strict=True):
            table.add_column(Text(head.plain, "markdown.table.header"), width=width)
        for row in rows:
            table.add_row(*row)
        yield table


class Manual(Markdown):
    """A page of the manual."""

    elements: ClassVar = {**Markdown.elements, "table_open": ManualTable}


def column_widths(rows: Sequence[Sequence[str]], most: int) -> list[int] | None:
    """The widths of columns in a table of at most this width [character], those of their longest words and the rest for
    the tallest columns; None if the words do not fit, or a row is taller than `MOST_LINES`."""
    columns = list(zip(*rows, strict=True))
    full = [max(map(len, column)) for column in columns]
    widths = [max(len(word) for cell in column for word in (cell.split() or [""])) for column in columns]

    def lines(place: int) -> int:
        return max(ceil(len(cell) / max(widths[place], 1)) for cell in columns[place])

    free = most - 2 * len(columns) - sum(widths)
    while free > 0 and (growing := [place for place in range(len(columns)) if widths[place] < full[place]]):
        widths[max(growing, key=lambda place: (lines(place), full[place] / widths[place]))] += 1
        free -= 1
    return None if free < 0 or max(map(lines, range(len(columns)))) > MOST_LINES else widths


def _row_by_row(heads: Sequence[Text], rows: Sequence[Sequence[Text]]) -> RenderResult:
    """Each row as its first cell, and below it the others with their headings."""
    for first, *others in rows:
        yield Text.assemble("\n", (first.plain, "bold"))
        named = [
            Text.assemble(f"{head.plain}: " if head.plain else "", cell)
            for head, cell in zip(heads[1:], others, strict=True)
            if cell.plain
        ]
        yield Padding(Text("; ").join(named), (0, 0, 0, 2))
