"""The base of every page: a screen between the bars, with help, copying, and work that blocks no key."""

import asyncio
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pkgutil import iter_modules, resolve_name
from typing import Any, ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Container
from textual.reactive import Reactive
from textual.screen import ModalScreen
from textual.widget import Widget
from textual.widgets import Input, Static

from fieldkit.tui import screens
from fieldkit.tui.asking import AskingScreen
from fieldkit.tui.help import Help
from fieldkit.tui.resources import IMPORTING
from fieldkit.tui.widgets.bars import KeyBar, NoticeBar, TopBar
from fieldkit.tui.widgets.table import Table

LEAVE_LINE = Binding(
    "enter", "leave_line", "Done", key_display="Enter", priority=True, tooltip="Go from the words typed to the list"
)
"""Enter in a search moves the focus to the table; Textual's input would only send a message."""


ANNOUNCED_END = " ..."
"""The end of a text that announces an answer."""
NO_ANSWER = "not available because of an error"
"""The text in its place if there is an error."""


@dataclass(frozen=True, slots=True)
class Page:
    """A page: its number, its title, and its screen by name, as `module:Class`.

    A screen is imported when its page is first opened or prepared, with everything that it needs: 0.7 s of processor
    time for the first one, 0.6 s for all seven after Home has read the launch day.
    """

    number: int
    title: str
    name: str

    @property
    def screen(self) -> type["PageScreen"]:
        """The screen. Raises ImportError or AttributeError if there is none with this name."""
        with IMPORTING:
            found: type[PageScreen] = resolve_name(self.name)
        return found

    async def imported(self) -> None:
        """Import the screen in a thread, while keys are handled."""
        await asyncio.to_thread(lambda: self.screen)


@cache
def pages() -> dict[str, Page]:
    """Every page by the name of its module, in the order of their numbers."""
    found: dict[str, Page] = {}
    for module in iter_modules(screens.__path__):
        page = getattr(import_module(f"{screens.__name__}.{module.name}"), "PAGE", None)
        if page is not None:
            found[module.name] = page
    return dict(sorted(found.items(), key=lambda item: item[1].number))


class PageScreen(AskingScreen):
    """A screen between the bars. `body` composes it, `reload` fills it when the ledger has changed, and `redraw` shows
    the same data in other units or with another target. `ABOUT` is its help, `NAME` the page marked in the top bar."""

    ABOUT: ClassVar[Help] = Help("")
    ON_ENTER: ClassVar[tuple[str, str]] = ("", "")
    """The word for Enter on a row of the first table, and what it does."""
    NAME: ClassVar[str] = ""
    focused: Reactive[Widget | None] = Reactive(
        None, repaint=False
    )  # widgets that gain or lose focus repaint themselves
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (76, "-normal"), (120, "-wide")]  # noqa: RUF012  # as Textual has it
    VERTICAL_BREAKPOINTS = [(0, "-short"), (40, "-tall")]  # noqa: RUF012
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("question_mark", "help", "Help", key_display="?", tooltip="Explain this page and its keys"),
        Binding("f1", "help", "Help", show=False),
        Binding("y", "copy", "Copy", tooltip="Copy the row or the figure as text"),
        Binding("u", "app.undo", "Undo", tooltip="Take back the last change, as often as you like"),
        Binding("a", "app.page('add')", "Add", show=False, tooltip="Enter a flight by hand"),
        Binding("f", "app.fly", "Fly", show=False, tooltip="Choose a motor and save its forecast"),
        Binding("escape", "back", "Back", show=False, priority=True),
    ]
    DEFAULT_CSS = """
    PageScreen { layout: vertical; background: $background; color: $foreground; }
    PageScreen > #body { height: 1fr; }
    PageScreen.-wide .framed:focus, PageScreen.-wide .framed:focus-within { border: heavy $border !important; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._seen = (-1, -1)
        self._theme = ""
        self._due: list[Callable[[], None]] = []
        self._later: list[Callable[[], object]] = []

    @property
    def ready(self) -> bool:
        """Whether the page has been in front, is mounted and painted, and has the right focus."""
        return self._seen != (-1, -1)

    def compose(self) -> ComposeResult:
        """The bars, and the body between them, styled once: for the colors and the size of the terminal."""
        self._theme = self.app.theme
        breakpoints = (self.HORIZONTAL_BREAKPOINTS, self.VERTICAL_BREAKPOINTS)
        for size, names in zip(self.app.size, breakpoints, strict=True):
            self.add_class([name for least, name in names if size >= least][-1])
        yield TopBar([(name, page.number, page.title) for name, page in pages().items()], self.NAME)
        with Container(id="body"):
            yield from self.body()
        yield NoticeBar()
        yield KeyBar()

    def follow_keys(self) -> None:
        """Show what the keys do now, on a page that is not being opened or closed."""
        for bar in self.query(KeyBar):
            bar.follow()

    def body(self) -> Iterable[Widget]:
        """The widgets of the page."""
        return ()

    def keep_typed(self) -> None:
        """Save the input as it stands; called while the app closes without waiting for messages about keys."""

    def finish(self) -> None:
        """Save pending input; called before the ledger is closed."""

    def reload(self) -> None:
        """Fill the page again; called when it is shown and the ledger has changed since it was last filled."""

    def unanswered(self) -> None:
        """Replace every text that announces an answer, such as `computing ...`."""
        for table in self.query(Table):
            if table.empty.endswith(ANNOUNCED_END):
                table.empty = NO_ANSWER
                table.refresh()
        for text in self.query("#body Static").results(Static):
            if str(text.content).endswith(ANNOUNCED_END):
                text.update(NO_ANSWER)

    def redraw(self) -> None:
        """Show the same data in other units or colors or with another target, immediately if nothing has to be read."""
        self.reload()

    def came(self) -> None:
        """Called when a key, a click or the palette has opened the page, and it is ready."""

    def copied(self) -> str:
        """What `y` copies: a line or a figure as text."""
        return ""

    def on_screen_resume(self, event: events.ScreenResume) -> None:
        """Show pending notices, and changes since another page was in front."""
        event.refresh_styles = self._theme != self.app.theme  # restyling a page takes half the time of a key
        self._theme = self.app.theme
        if not self.is_current or self.field_app.unseen:
            return  # prepared in the background
        self.query_one(NoticeBar).show_notice(self.field_app.notices)
        self.call_after_refresh(self.refresh_if_changed)  # first the page, then its content
        later, self._later = self._later, []
        for show in later:
            self.call_after_refresh(show)

    def show_in_front(self, show: Callable[[], object], otherwise: str) -> None:
        """Show something over this page; if another page is in front, show a notice there, and the rest when this one
        returns."""
        if self.is_current:
            show()
        else:
            self._later.append(show)
            self.show_notice(otherwise)

    def above(self) -> Iterable["PageScreen"]:
        """Screens that are often opened from this page and should be prepared."""
        return ()

    def reload_on_resume(self) -> None:
        """Reload when the screen next comes to the front."""
        self._seen = (-1, -1)

    def refresh_if_changed(self) -> None:
        """Reload if the ledger has changed since the last time; redraw if only the settings have changed."""
        before, self._seen = self._seen, (self.field_app.revision, self.field_app.look)
        if before[0] != self._seen[0]:
            self.reload()
        elif before != self._seen:
            self.redraw()

    def soon(self, show: Callable[[], None]) -> None:
        """Show something after the current key is answered, once even if it is requested several times before that."""
        if show not in self._due:
            self._due.append(show)
            self.call_after_refresh(self._show_due)

    def _show_due(self) -> None:
        due, self._due = self._due, []
        for show in due:
            show()

    def ask_form(
        self, form: ModalScreen[dict[str, object] | None], answered: Callable[[dict[str, Any]], object]
    ) -> None:
        """Open a form over this page; `answered` gets its values unless it is left without them."""

        def pass_on(values: dict[str, object] | None) -> None:
            if values is not None:
                answered(values)

        self.app.push_screen(form, pass_on)

    def show_change(self, notice: str) -> None:
        """The ledger has changed: show this notice, and reload the pages."""
        self.show_notice(notice)
        self.field_app.changed()

    def changed_for_others(self) -> None:
        """Note a change of the ledger that only other pages have to show; one may be in front by now."""
        self.field_app.count_change()
        self._seen = (self.field_app.revision, self.field_app.look)
        if isinstance(self.app.screen, PageScreen):
            self.app.screen.refresh_if_changed()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Enter leaves a line only while an input has the focus, in which N is a letter."""
        if action in ("leave_line", "next_units"):
            return isinstance(self.focused, Input) == (action == "leave_line")
        return super().check_action(action, parameters)

    def action_next_units(self) -> None:
        """Switch to the next system of units."""
        self.field_app.action_next_units()

    def action_help(self) -> None:
        """Explain the screen and its fields."""
        from fieldkit.tui.widgets.dialogs import HelpScreen, key_list  # takes 6 ms to import

        self.app.push_screen(HelpScreen(f"Help: {self.TITLE}", self.ABOUT, key_list(self)))

    def action_copy(self) -> None:
        """Copy the line or the figure."""
        text = self.copied()
        if text:
            self.app.copy_to_clipboard(text)
            self.show_notice("Copied: " + (text.splitlines()[0] + (" …" if "\n" in text else "")))
        else:
            self.show_notice("Nothing to copy")

    def action_back(self) -> None:
        """Dismiss an error, or else leave a field, or else leave the screen if it is above a page, or else dismiss a
        notice of success."""
        notices, over = self.field_app.notices, len(self.app.screen_stack) > 1
        if notices and (notices[0].error or not (over or isinstance(self.focused, Input))):
            self.field_app.action_read()
        elif isinstance(self.focused, Input) and (rest := self.resting_place()) is not None:
            self.set_focus(rest)
        elif len(self.app.screen_stack) > 1:
            self.dismiss()

    def action_leave_line(self) -> None:
        """Move from a line to the first table."""
        self.set_focus(self.resting_place())

    def row(self) -> Any:
        """The row under the cursor of the first table; None if there is none."""
        return getattr(self.resting_place(), "current", None)

    def go_to_row(self, key: Any) -> None:
        """Put the cursor of the first table on a row, if there is such a row."""
        if key is not None and (move := getattr(self.resting_place(), "move_to", None)):
            move(key)

    def resting_place(self) -> Widget | None:
        """Where the focus goes when a field is left: the first table, if there is one."""
        return next(iter(self.query(Table)), None)
