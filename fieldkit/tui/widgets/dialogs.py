"""Small screens over a page: help, a question with a typed answer, one to agree to, and the base of such screens."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, TypeVar

from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen, Screen
from textual.widgets import Input, Static

from fieldkit.errors import FieldkitError
from fieldkit.safe_text import printable
from fieldkit.services.pickers import OfferedAnswer, among
from fieldkit.tui.help import Help
from fieldkit.tui.widgets.bars import KeyBar
from fieldkit.tui.widgets.hanging import Hanging, marked
from fieldkit.tui.widgets.line import Line
from fieldkit.tui.widgets.picker import Picker
from fieldkit.tui.widgets.table import Table

OF_TEXTUAL = {
    "app.focus_next": "Next part of the page",
    "app.focus_previous": "Previous part of the page",
    "screen.copy_text": "",
    "scroll_up": "Line up",
    "scroll_down": "Line down",
    "scroll_left": "",
    "scroll_right": "",
    "scroll_home": "First",
    "scroll_end": "Last",
    "page_up": "Page up",
    "page_down": "Page down",
    "page_left": "",
    "page_right": "",
}
"""Actions that Textual binds and describes itself, with the description in our help; an empty one omits the action."""
OF_A_LINE = {"delete_left_all": ("^U", "Clear the field, left of the cursor"), "paste": ("^V", "Paste")}
"""The editing keys of an input that its help lists; everyone knows the others, such as Backspace."""
Result = TypeVar("Result")


class HelpScreen(ModalScreen[None]):
    """The help of a screen: purpose, fields, keys, and equivalent commands."""

    DEFAULT_CSS = """
    HelpScreen { align: center middle; background: $backdrop; }
    HelpScreen > Vertical { width: 90%; max-width: 96; height: 90%; background: $surface; border: solid $border; }
    HelpScreen VerticalScroll { padding: 0 1; }
    HelpScreen VerticalScroll Static { margin-bottom: 1; width: 1fr; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Close"),
        Binding("question_mark,f1,q", "dismiss", "Close", show=False),
        Binding("up", "scroll_by(-1)", "Up", show=False),
        Binding("down", "scroll_by(1)", "Down", show=False),
        Binding("y", "copy", "Copy", show=False),
    ]

    def __init__(self, title: str, help: Help, keys: Sequence[tuple[str, str]], listed: str = "") -> None:
        super().__init__()
        self._title, self._help, self._key_list = title, help, keys
        self._listed = listed or "Fields"

    def compose(self) -> ComposeResult:
        """One column of short paragraphs."""
        with Vertical() as frame:
            frame.border_title = Content(printable(self._title))
            with VerticalScroll():
                yield Static(Content(self._help.about))
                if self._help.fields:
                    yield Static(_paragraphs(self._listed, self._help.fields))
                if self._key_list:
                    yield Static(_paragraphs("Keys", self._key_list))
                if self._help.twin:
                    twins = "\n".join(f"  {line}" for line in self._help.twin)
                    yield Static(Content.assemble(("The same on the command line", "b"), "\n", twins))
            yield KeyBar()

    def action_copy(self) -> None:
        """Copy all of it as text, commands too."""
        parts = self.query_one(VerticalScroll).query(Static)
        self.app.copy_to_clipboard("\n\n".join(str(part.content) for part in parts))

    def action_scroll_by(self, lines: int) -> None:
        """Scroll the text."""
        self.query_one(VerticalScroll).scroll_relative(y=lines, animate=False)


def _paragraphs(heading: str, pairs: Sequence[tuple[str, str]]) -> Hanging:
    """A heading, and below it each name with its description."""
    lines = [(0, Content.assemble((heading, "b")))]
    lines += [(4, Content.assemble("  ", (name, "b $accent"), f"  {text}")) for name, text in pairs]
    return Hanging(tuple(lines))


def key_list(screen: Screen[Any]) -> list[tuple[str, str]]:
    """The keys of a screen and their current actions, the keys of one action together."""
    listed: dict[str, list[str]] = {}
    for active in screen.active_bindings.values():
        key, text = _described(screen, active)
        if active.enabled and text and key not in listed.setdefault(text, []):
            listed[text].append(key)
    return [(" ".join(keys), text) for text, keys in listed.items()]


def _described(screen: Screen[Any], active: ActiveBinding) -> tuple[str, str]:
    """A key and what it does, for the help; an empty description omits it."""
    binding = active.binding
    if isinstance(active.node, Input):
        return OF_A_LINE.get(binding.action, ("", ""))
    text = OF_TEXTUAL.get(binding.action, binding.tooltip or binding.description)
    if isinstance(active.node, Table) and binding.action == "choose":
        text = getattr(screen, "ON_ENTER", ("", ""))[1] or active.node.enter
    return screen.app.get_key_display(binding), text


class HelpedModal(ModalScreen[Result]):
    """A small screen over a page, with help on F1."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("f1", "help", "Help", key_display="F1", priority=True)]

    def explained(self) -> tuple[str, Help]:
        """The title of the screen and its help."""
        raise NotImplementedError

    def action_help(self) -> None:
        """Explain the screen and its keys."""
        title, about = self.explained()
        self.app.push_screen(HelpScreen(f"Help: {title}", about, key_list(self)))


class AskText(HelpedModal[str | None]):
    """One line to be typed; the result is the text, or None.

    `check` is called with a changed text and raises a FieldkitError for one that cannot be used: the line then stays
    open, with the error below it.
    """

    DEFAULT_CSS = """
    AskText { align: center middle; background: $backdrop; layers: base above; }
    AskText > Vertical { width: 80%; max-width: 72; height: auto; background: $surface; border: solid $border;
        padding: 0 1; }
    AskText Static { height: auto; }
    AskText #wrong { display: none; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "take", "OK", key_display="Enter", priority=True),
        Binding("down", "move(1)", "Choose", show=False, priority=True),
        Binding("up", "move(-1)", "Choose", show=False, priority=True),
        Binding("escape", "leave", "Cancel", priority=True),
    ]

    def __init__(
        self,
        title: str,
        text: str,
        about: str = "",
        offered: Sequence[OfferedAnswer] = (),
        check: Callable[[str], object] = str,
    ) -> None:
        super().__init__()
        self._title, self._text, self._about, self._offered, self._check = title, text, about, offered, check
        self._picker = Picker()

    def on_mount(self) -> None:
        """Offer answers from the start."""
        if self._offered:
            self._picker.sources = {"": among(self._offered)}
            self.call_after_refresh(self._picker.follow, self.query_one(Input), "")

    def on_input_changed(self, event: Input.Changed) -> None:
        """Update the offered answers while typing."""
        self.query("#wrong").set(display=False)
        self._picker.follow(event.input, "")

    def compose(self) -> ComposeResult:
        """The question and the input."""
        with Vertical() as frame:
            frame.border_title = Content(printable(self._title))
            if self._about:
                yield Static(Content(printable(self._about)))
            yield Line(printable(self._text))
            yield Static("", id="wrong")
            yield KeyBar()
        yield self._picker

    def explained(self) -> tuple[str, Help]:
        """What is asked for, and how to answer."""
        how = "Type the answer and press Enter. Esc changes nothing."
        choose = " ↓ and ↑ choose one of those listed." if self._offered else ""
        return self._title, Help(f"{self._about} {how}{choose}".strip())

    def action_move(self, by: int) -> None:
        """Move in the list of offered answers."""
        self._picker.move(by)

    def action_leave(self) -> None:
        """Close the list if the text was changed, or else cancel."""
        if self._picker.open and self.query_one(Input).value != printable(self._text):
            self._picker.close()
        else:
            self.dismiss(None)

    def action_take(self) -> None:
        """Submit the line with the chosen answer, or show the error in it."""
        self._picker.take()
        text = self.query_one(Input).value
        try:
            if text != printable(self._text):
                self._check(text)
        except FieldkitError as error:
            wrong = self.query_one("#wrong", Static)
            wrong.update(marked(f"✗ {printable(str(error))}"))
            wrong.display = True
        else:
            self.dismiss(text)


class AskYes(HelpedModal[bool]):
    """A question that `y` or Enter agrees to, and `n` or Esc does not."""

    DEFAULT_CSS = """
    AskYes { align: center middle; background: $backdrop; }
    AskYes > Vertical { width: 80%; max-width: 72; height: auto; background: $surface; border: solid $border;
        padding: 0 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "dismiss(True)", "Yes"),
        Binding("enter", "dismiss(True)", "Yes", show=False),
        Binding("n", "dismiss(False)", "No"),
        Binding("escape", "dismiss(False)", "No", show=False),
    ]

    def __init__(self, question: str) -> None:
        super().__init__()
        self._question = question

    def compose(self) -> ComposeResult:
        """The question and its keys."""
        with Vertical():
            yield Static(Content("\n".join(printable(line) for line in self._question.splitlines())))
            yield KeyBar()

    def explained(self) -> tuple[str, Help]:
        """The question, and what each answer does."""
        question = "\n".join(printable(line) for line in self._question.splitlines())
        return "Question", Help(f"{question}\n\ny or Enter goes ahead; n or Esc goes back without doing it.")
