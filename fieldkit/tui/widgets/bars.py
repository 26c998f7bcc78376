"""The lines at the edges of every page: the pages above, notices and keys below."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import ceil

from textual.content import Content
from textual.style import Style
from textual.widgets import Static

from fieldkit.safe_text import printable


@dataclass(frozen=True, slots=True)
class Notice:
    """A notice; an error stays until it is dismissed."""

    text: str
    error: bool = False


def shortened(text: str) -> str:
    """A text with paths shortened to file names; ports such as `/dev/ttyUSB0` do not change."""
    root = r"(?!/dev/)(?:/|[A-Za-z]:[/\\]|\\\\)"
    text = re.sub(rf"^{root}[^:\n]*[/\\]", "", text)  # error messages start with the path of the file
    return re.sub(rf"(?<=[\s'(]){root}(?:[^\s:,;'()/\\]+[/\\])+", "", text)


class TopBar(Static):
    """The pages by number; the current one is marked by brackets and by color."""

    DEFAULT_CSS = """
    TopBar { height: 1; background: $panel; color: $foreground; padding: 0 1; text-wrap: nowrap;
        link-style: none; link-color: $foreground; link-background: $panel; }
    """

    def __init__(self, titles: Sequence[tuple[str, int, str]], current: str) -> None:
        super().__init__()
        self._titles, self._current = titles, current

    def render(self) -> Content:
        """The pages in one line; a narrower terminal drops first the program's name, then spaces."""
        gap = "  " if self.size.width >= 78 else " "
        parts: list[str | Content | tuple[str, str | Style]] = []
        if self.size.width >= 92:
            parts = [("fieldkit", "b $accent"), " "]
        for name, number, title in self._titles:
            text = f"{number} {title}" if self.size.width >= 70 else f"{number}{title}"
            here = name == self._current
            parts += [(f" {text} ", "b reverse") if here else (text, clicked(f"app.page('{name}')")), gap]
        return Content.assemble(*parts)


class NoticeBar(Static):
    """The latest undismissed notice, with a mark for its kind."""

    DEFAULT_CSS = """
    NoticeBar { height: auto; max-height: 4; background: $panel; color: $foreground; padding: 0 1; display: none;
        link-style: none; link-color: $foreground; link-background: $panel; }
    NoticeBar.-shown { display: block; }
    NoticeBar.-whole { max-height: 50%; overflow-y: auto; }
    NoticeBar.-error { border-left: thick $error; }
    """

    LINES = 4
    """Maximum number of lines of a shortened notice, the same as in `max-height`."""

    def show_notice(self, notices: Sequence[Notice], whole: bool = False) -> None:
        """Show the first of these, files by their names or by their `whole` paths, and how many more there are."""
        self.set_class(bool(notices), "-shown")
        if not notices:
            return
        notice = notices[0]
        self.set_class(notice.error, "-error")
        self.set_class(whole, "-whole")
        mark = Content.from_markup("[b $error]✗ error[/] " if notice.error else "[b $success]✓[/] ")
        body = notice.text if whole else self._within(shortened(notice.text))
        lines = "\n".join(printable(line) for line in body.splitlines())
        more = f"  ({len(notices) - 1} more)" if len(notices) > 1 else ""
        more += "  [@click=app.whole_notice][b]W[/] full text[/]" if body != notice.text else ""
        shown = Content.assemble(mark, lines, Content.from_markup(more))
        dismiss = Content.from_markup("  [@click=app.read][b]Esc[/] dismiss[/]")
        room = max(1, self.app.size.width - 2)
        room_left = ceil((shown + dismiss).cell_length / room) == ceil(shown.cell_length / room)
        over = len(self.app.screen_stack) > 1  # where Esc leaves the screen
        hint = notice.error or (room_left and not over)  # the next notice replaces a success, so the hint is optional
        self.update(shown + dismiss if hint else shown)

    def _within(self, text: str) -> str:
        """A text shortened to leave room for its keys."""
        room = (self.LINES - 1) * (self.app.size.width - 6)
        return text if len(text) <= room else f"{text[:room].rsplit(' ', 1)[0]} …"


class KeyBar(Static):
    """The available keys, on as many lines as needed; each can be clicked."""

    DEFAULT_CSS = """
    KeyBar { height: auto; max-height: 4; background: $footer-background; color: $footer-foreground; padding: 0 1; }
    """

    MOST = 4
    """Maximum number of lines, the same as in `max-height`."""
    auto_links = False  # whose style would replace the color of the keys

    def __init__(self) -> None:
        super().__init__()
        self._most = (0, 0)
        self._due = False

    def on_mount(self) -> None:
        """Follow the focus, which determines the available keys."""
        self.follow()  # so that the first layout has room for it and is not repeated
        self.screen.bindings_updated_signal.subscribe(self, lambda _: self._follow_soon())

    def on_resize(self) -> None:
        """Break the lines again for the new width."""
        self.follow()

    def _follow_soon(self) -> None:
        """Follow several changes of the focus at once: a page that opens causes three."""
        if not self._due:
            self._due = self.call_later(self._follow_now)

    def _follow_now(self) -> None:
        self._due = False
        self.follow()

    def follow(self) -> None:
        """Show the available keys. At one width, the number of lines never shrinks, because a page that changed its
        height with the focus would jump and be laid out again."""
        lines, room = self._lines(), self._room()
        width, most = self._most
        most = min(self.MOST, max(len(lines), most if width == room else 0))
        if self.size:
            self._most = (room, most)
        text = Content("\n").join([*(Content("  ").join(line) for line in lines), *[Content()] * (most - len(lines))])
        if text.plain != str(self.content):
            self.update(text, layout=False)
        if self.size and self.size.height != most:
            self.refresh(layout=True)

    def _room(self) -> int:
        """Cells of a line."""
        return max(20, self.size.width or self.app.size.width - 2)

    def _lines(self) -> list[list[Content]]:
        """Each key with its word, never separated and each word once; keys that work everywhere are last."""
        active = [one for one in self.screen.active_bindings.values() if one.binding.show and one.enabled]
        lines: list[list[Content]] = [[]]
        room = width = self._room()
        named = set[str]()
        for binding in (one.binding for one in sorted(active, key=lambda one: one.binding.description in GLOBAL_KEYS)):
            key = self.app.get_key_display(binding)
            enter = getattr(self.screen.focused, "enter", None) if binding.key == "enter" else None
            word = binding.description if enter is None else enter
            if not word or word in named:
                continue
            named.add(word)
            room -= len(key) + len(word) + 3
            if room < -2 and lines[-1]:
                lines.append([])
                room = width - len(key) - len(word) - 3
            lines[-1].append(_label(key, word, binding.key))
        return lines


GLOBAL_KEYS = ("Undo", "Copy", "Help", "Quit")
"""Keys that work on every page, shown after those of the page."""


@cache
def _label(shown: str, word: str, key: str) -> Content:
    """A key and its word; a click on either presses the key."""
    label = Content.assemble((shown, "b $footer-key-foreground"), f" {word}")
    return label.stylize(clicked(f"app.press({key!r})"))


def clicked(action: str) -> Style:
    """A style of text on which a click runs an action."""
    return Style.from_meta({"@click": action})
