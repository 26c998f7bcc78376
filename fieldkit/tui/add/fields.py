"""A question with a line to type its answer in, and a note on the answer."""

from collections.abc import Callable, Iterable
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widget import Widget
from textual.widgets import Input, Label, Static

from fieldkit.errors import BadValue
from fieldkit.importing.manual_entry import NOT_RECORDED, Question, read_answer
from fieldkit.quantities import spelled
from fieldkit.safe_text import printable
from fieldkit.tui.widgets.bars import KeyBar


class Line(Input):
    """A line in which a question mark asks for help, unless it `takes_marks`."""

    def __init__(self, text: str = "", *, takes_marks: bool = True, **rest: Any) -> None:
        super().__init__(text, select_on_focus=True, validate_on=(), **rest)
        self.takes_marks = takes_marks
        self.cursor_blink = False

    def check_consume_key(self, key: str, character: str | None = None) -> bool:
        """Whether a key is a letter here; Textual knows the slash by no name."""
        character = "/" if key == "slash" else character
        asks = character == "?" and not self.takes_marks
        return super().check_consume_key(key, character) and not asks


class Field(Horizontal):
    """A question, its answer, and a note on the answer."""

    DEFAULT_CSS = """
    Field { height: 1; }
    Field > Label { width: 22; }
    Field > Input, Field > Input:focus { width: 15; height: 1; padding: 0; border: none; border-left: outer $border; }
    Field > .note { width: 1fr; height: 1; padding: 0 0 0 1; text-wrap: nowrap; text-overflow: ellipsis; }
    Field.-short > Label { width: auto; padding: 0 1 0 0; }
    Field.-short > Input, Field.-short > Input:focus { width: 1fr; }
    Field.-short > .note { display: none; }
    Field.-hand > Label { text-style: bold reverse; }
    """

    def __init__(self, question: Question, *, short: bool = False, text: str = "") -> None:
        super().__init__(id=f"field-{question.name}", classes="-short" if short else "")
        self.question, self._meant, self._noted = question, text, ""

    def compose(self) -> Iterable[Widget]:
        """Label, line, note."""
        yield Label(self.question.title if self.question.name != "config" else "Config")
        yield Line(printable(self._meant), takes_marks=self.question.name == "notes", id=f"in-{self.question.name}")
        yield Static("", classes="note")

    @property
    def line(self) -> Input:
        """Where the answer is typed."""
        return self.query_one(Input)

    @property
    def answer(self) -> str:
        """What was typed, or what was filled in as it was meant: a line shows no escapes, a name may have some."""
        text = self.line.value.strip()
        return self._meant if text == printable(self._meant).strip() else text

    @property
    def typed(self) -> bool:
        """Whether the line holds anything else than what was filled in."""
        return self.line.value != printable(self._meant)

    def fill(self, text: str) -> None:
        """Put an answer in the line."""
        self._meant = text
        self.line.value = printable(text)

    def note(self, text: str) -> None:
        """Say something about the answer, in the line there is for it."""
        if text != self._noted:
            self._noted = text
            self.query_one(".note", Static).update(Content(printable(text)), layout=False)


class Form(ModalScreen[dict[str, object] | None]):
    """A few questions in a frame; the result is the fields of a flight by name, or None.

    `units` are those of numbers typed without one, by question; `read` makes a value of a name, a text and its unit, or
    raises BadValue.
    """

    DEFAULT_CSS = """
    Form { align: center middle; background: $backdrop; }
    Form > Vertical { width: 94%; max-width: 84; height: auto; max-height: 94%; background: $surface;
        border: solid $border; padding: 0 1; }
    Form VerticalScroll { height: auto; max-height: 60vh; }
    Form #help { height: 2; color: $foreground; margin-top: 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+s", "take", "Take it", key_display="^S", priority=True),
        Binding("enter", "go_on", "Next", key_display="Enter", priority=True),
        Binding("up", "app.focus_previous", "Back a field", show=False, priority=True),
        Binding("down", "app.focus_next", "Fields", key_display="↑↓", priority=True),
        Binding("escape", "dismiss(None)", "Leave it"),
    ]

    def __init__(
        self,
        title: str,
        questions: Iterable[Question],
        texts: dict[str, str],
        units: dict[str, str],
        read: Callable[[str, str, str], object] = read_answer,
    ) -> None:
        super().__init__()
        self._title, self._questions, self._texts, self._units = title, tuple(questions), texts, units
        self._value = read

    def compose(self) -> ComposeResult:
        """The questions, and what the one in hand means."""
        with Vertical() as frame:
            frame.border_title = Content(printable(self._title))
            with VerticalScroll(can_focus=False):
                for question in self._questions:
                    yield Field(question, text=self._texts.get(question.name, ""))
            yield Static("", id="help")
            yield KeyBar()

    def on_descendant_focus(self) -> None:
        """Explain the field in hand, or all of why it cannot be read."""
        field = self.focused.parent if self.focused is not None else None
        for one in self.query(Field):
            one.set_class(one is field, "-hand")
            one.note(self._read(one)[1])
        if isinstance(field, Field):
            note = self._read(field)[1]
            about = printable(note) if note.startswith("✗") else field.question.help
            self.query_one("#help", Static).update(Content(about))

    def on_input_changed(self) -> None:
        """The note follows what is typed."""
        self.on_descendant_focus()

    def _read(self, field: Field) -> tuple[object, str]:
        """The value of a field, and a note on it that begins with a cross where it cannot be read."""
        name, text = field.question.name, field.answer
        unit = self._units.get(name, "")
        try:
            return self._value(name, "" if text == NOT_RECORDED else text, unit), spelled(unit)
        except BadValue as error:
            return None, f"✗ {error}"

    def action_go_on(self) -> None:
        """To the next line; on the last one it takes the form."""
        field = self.focused.parent if self.focused is not None else None
        if isinstance(field, Field) and field.question == self._questions[-1]:
            self.action_take()
        else:
            self.focus_next()

    def action_take(self) -> None:
        """Hand the answers over, if all can be read."""
        values: dict[str, object] = {}
        for field in self.query(Field):
            value, note = self._read(field)
            if note.startswith("✗"):
                field.line.focus()
                return
            values[field.question.name] = value
        self.dismiss(values)
