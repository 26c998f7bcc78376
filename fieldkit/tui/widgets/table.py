"""A table of any length: only visible lines are drawn, so that five thousand flights respond immediately."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from rich.cells import cell_len, set_cell_size
from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import Binding, BindingType
from textual.geometry import Region, Size
from textual.message import Message
from textual.reactive import reactive
from textual.scroll_view import ScrollView
from textual.strip import Strip

from fieldkit.safe_text import printable
from fieldkit.tui.asking import AskingScreen
from fieldkit.tui.widgets.states import BAD_COLOR, CAUTION_COLOR, GOOD_COLOR, MARK_COLOR, runs


@dataclass(frozen=True, slots=True)
class Head:
    """A column: its heading, its width in cells (0 for the rest), and whether numbers are right-aligned; long texts
    show their start, or their `tail`, or both ends without their `middle`."""

    title: str
    width: int
    right: bool = False
    tail: bool = False
    middle: bool = False


Cells = Callable[[Any], Sequence[str]]
"""The cells of a row by its key, as text, which may come from files."""

MARK, NO_MARK = "▸", " "
"""Prefix of the current row and of the others, for displays without colors."""


class Table(ScrollView, can_focus=True, inherit_bindings=False):
    """Rows with a cursor. Sends `Moved` when the cursor moves, `Chosen` on Enter or a second click."""

    DEFAULT_CSS = """
    Table { height: 1fr; background: $surface; color: $foreground; scrollbar-size-vertical: 1; overflow-x: hidden; }
    Table > .table--head { text-style: bold; color: $primary; background: $panel; }
    Table > .table--cursor { color: $block-cursor-foreground; background: $block-cursor-background;
        text-style: $block-cursor-text-style; }
    Table > .table--success { color: $success; }
    Table > .table--warning { color: $warning; }
    Table > .table--error { color: $error; }
    Table > .table--accent { color: $accent; }
    Table > .table--blurred { color: $block-cursor-blurred-foreground; background: $block-cursor-blurred-background;
        text-style: bold; }
    """
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        *("table--head", "table--cursor", "table--blurred"),
        *(f"table--{color}" for color in (GOOD_COLOR, CAUTION_COLOR, BAD_COLOR, MARK_COLOR)),
    }
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "choose", "Open", key_display="Enter"),
        Binding("up", "move(-1)", "Up", show=False),
        Binding("down", "move(1)", "Down", show=False),
        Binding("pageup", "page(-1)", "Page up", show=False),
        Binding("pagedown", "page(1)", "Page down", show=False),
        Binding("home", "end(False)", "First", show=False),
        Binding("end", "end(True)", "Last", show=False),
    ]

    @dataclass
    class Moved(Message):
        """The cursor has moved to another row."""

        table: "Table"
        key: Any

        @property
        def control(self) -> "Table":
            """The table that sent it."""
            return self.table

    class Chosen(Moved):
        """A row was chosen."""

    @dataclass
    class HeadClicked(Message):
        """The heading of a column was clicked."""

        table: "Table"
        column: int

        @property
        def control(self) -> "Table":
            """The table that sent it."""
            return self.table

    @dataclass
    class Sized(Message):
        """The width of the table has changed, so other columns may fit."""

        table: "Table"

        @property
        def control(self) -> "Table":
            """The table that sent it."""
            return self.table

    cursor: reactive[int] = reactive(0, repaint=False)

    def __init__(self, *, empty: str = "", enter: str = "Open", **rest: Any) -> None:
        super().__init__(**rest)
        self.on_enter = enter
        """The action of Enter on a row, as a word for the key bar."""
        self.heads: Sequence[Head] = ()
        self.keys: Sequence[Any] = ()
        self.cells: Cells = lambda _: ()
        self.empty = empty
        self.by_hand = False
        """Whether the flyer has moved the cursor since the table was last reset."""

    @property
    def enter(self) -> str:
        """What Enter does, for the key bar; empty without rows."""
        return self.on_enter if self.keys else ""

    def show(
        self,
        heads: Sequence[Head],
        keys: Sequence[Any],
        cells: Cells,
        *,
        keep: bool = True,
        name: Callable[[Any], Hashable] = lambda key: key,
    ) -> None:
        """Show a row for each key. With `keep`, if the user chose a row, the cursor stays on it, or takes the place of
        a row that is gone; otherwise it is on the first row. `name` identifies a row whose key has changed."""
        before = self.current
        row = _place(self.cursor, list(map(name, self.keys)), list(map(name, keys))) if keep and self.by_hand else 0
        if bool(keys) != bool(self.keys):
            self.screen.refresh_bindings()  # Enter does nothing without rows
        self.heads, self.keys, self.cells = heads, keys, cells
        self.set_reactive(Table.cursor, row)
        self.virtual_size = Size(self.size.width, len(keys) + 1)
        self._in_sight()
        self.refresh()
        if self.current != before:
            self.post_message(self.Moved(self, self.current))

    @property
    def current(self) -> Any:
        """The key of the row under the cursor; None without rows."""
        return self.keys[self.cursor] if self.cursor < len(self.keys) else None

    def move_to(self, key: Any) -> None:
        """Put the cursor on the row with a key."""
        if key in self.keys:
            self._go(self.keys.index(key))

    def current_text(self) -> str:
        """The row under the cursor as text, headings and all, to be copied."""
        if self.current is None:
            return ""
        pairs = zip(self.heads, self.cells(self.current), strict=True)
        return "  ".join(f"{head.title.strip(' ▲▼')} {cell}" for head, cell in pairs if cell)

    def validate_cursor(self, row: int) -> int:
        """Keep the cursor within the rows."""
        return max(0, min(row, len(self.keys) - 1))

    def watch_cursor(self, before: int, after: int) -> None:
        """Scroll to the cursor and report its row."""
        if before != after:
            self._in_sight()
            for row in (before, after):
                self.refresh_line(row + 1)
            self.post_message(self.Moved(self, self.current))

    def _in_sight(self) -> None:
        room = max(1, self.size.height - 1)
        top = round(self.scroll_y)
        if self.cursor < top:
            top = self.cursor
        elif self.cursor >= top + room:
            top = self.cursor - room + 1
        self.scroll_to(y=top, animate=False, immediate=True)

    def on_resize(self, _event: events.Resize) -> None:
        """Fit the columns again."""
        if self.virtual_size.width != self.size.width:
            self.post_message(self.Sized(self))
        self.virtual_size = Size(self.size.width, len(self.keys) + 1)
        self._in_sight()

    def widths(self) -> list[int]:
        """Widths of the columns in cells; columns without a width share the rest."""
        room = self.size.width - 1 - len(self.heads) - sum(head.width for head in self.heads)
        loose = sum(not head.width for head in self.heads)
        return [head.width or max(4, room // max(loose, 1)) for head in self.heads]

    def render_line(self, y: int) -> Strip:
        """Draw a line: the heading on the first, rows below it."""
        base = self.rich_style
        if y == 0:
            style = base + self.get_component_rich_style("table--head")
            return self._strip(NO_MARK, [head.title for head in self.heads], style)
        row = round(self.scroll_y) + y - 1
        if row >= len(self.keys):
            lines = self.empty.splitlines() if not self.keys else []
            text = f" {lines[y - 1]}" if y <= len(lines) else ""
            return Strip([Segment(set_cell_size(text, self.size.width), base)])
        style = base
        if row == self.cursor:
            style = base + self.get_component_rich_style("table--cursor" if self.has_focus else "table--blurred")
        cells = self.cells(self.keys[row])
        return self._strip(MARK, cells, style) if row == self.cursor else self._colored(cells, style)

    def _fitted(self, cells: Sequence[str]) -> list[str]:
        """The cells as wide as their columns, with a space after each."""
        columns = zip(self.heads, self.widths(), cells, strict=True)
        return [fitted(printable(cell), width, head) + " " for head, width, cell in columns]

    def _strip(self, mark: str, cells: Sequence[str], style: Style) -> Strip:
        text = set_cell_size("".join([mark, *self._fitted(cells)]), self.size.width)
        return Strip([Segment(text, style)], self.size.width)

    def _colored(self, cells: Sequence[str], style: Style) -> Strip:
        """A row without the cursor, its states in their colors."""
        parts = [(NO_MARK, ""), *(part for cell in self._fitted(cells) for part in runs(cell, aims=True))]
        colors = {
            color: style + self.get_component_rich_style(f"table--{color}") for color in {c for _, c in parts if c}
        }
        segments = [Segment(text, colors.get(color, style)) for text, color in parts if text]
        return Strip(segments).adjust_cell_length(self.size.width, style)

    async def action_move(self, by: int) -> None:
        """Move one row up or down."""
        await self._rows_read()
        self._go(self.cursor + by)

    def _go(self, row: int) -> None:
        self.by_hand, self.cursor = True, row

    async def action_page(self, by: int) -> None:
        """Move one screen up or down."""
        await self._rows_read()
        self._go(self.cursor + by * max(1, self.size.height - 2))

    async def action_end(self, last: bool) -> None:
        """Move to the first or the last row."""
        await self._rows_read()
        self._go(len(self.keys) - 1 if last else 0)

    async def action_choose(self) -> None:
        """Choose the row under the cursor."""
        await self._rows_read()
        if self.current is not None:
            self.post_message(self.Chosen(self, self.current))

    async def _rows_read(self) -> None:
        """Wait until the rows are read: the key may be typed ahead."""
        if self.current is None and isinstance(self.screen, AskingScreen):
            await self.screen.settled(*self.screen.ROW_REQUESTS)

    async def on_click(self, event: events.Click) -> None:
        """A click moves the cursor; on the cursor's row it chooses the row, on the heading it reports the column."""
        if event.y == 0:
            self._head_clicked(event.x)
            return
        row = round(self.scroll_y) + event.y - 1
        if row < len(self.keys):
            again = row == self.cursor
            self._go(row)
            if again:
                await self.action_choose()

    def _head_clicked(self, x: int) -> None:
        edge = 1
        for number, width in enumerate(self.widths()):
            edge += width + 1
            if x < edge:
                self.post_message(self.HeadClicked(self, number))
                return

    def watch_scroll_y(self, old_value: float, new_value: float) -> None:
        """Redraw all visible lines, because the heading does not scroll."""
        super().watch_scroll_y(old_value, new_value)
        self.refresh(Region(0, 0, *self.size))


def _place(cursor: int, old: Sequence[Hashable], new: Sequence[Hashable]) -> int:
    """The place of the cursor when other rows are shown: that of its row; the same place if its row is gone and the
    number of rows is the same; else that of the next row that is still there, or of the one before it."""
    places = {name: place for place, name in enumerate(new)}
    if old[cursor : cursor + 1] and old[cursor] not in places and len(old) == len(new):
        return cursor
    around = (*old[cursor:], *reversed(old[:cursor]))
    return next((places[name] for name in around if name in places), 0)


def fitted(text: str, width: int, head: Head) -> str:
    """A text in a width, with an ellipsis instead of what its column leaves out if it is too long."""
    if cell_len(text) > width:
        start = (width - 1) // 3 if head.middle else 0 if head.tail else width - 1
        end = width - 1 - start
        text = f"{set_cell_size(text, start)}…{set_cell_size(text[::-1], end)[::-1]}"
    blank = " " * (width - cell_len(text))
    return blank + text if head.right else text + blank
