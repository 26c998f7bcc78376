"""A question with an input line and a note on the answer."""

import asyncio
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any, ClassVar, cast

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Input, Label, Static
from textual.worker import Worker

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.importing.manual_entry import NOT_RECORDED, Question, read_answer
from fieldkit.quantities import in_own_unit, spelled
from fieldkit.safe_text import printable
from fieldkit.services.manual_entry import typed_unit
from fieldkit.services.pickers import Names
from fieldkit.tui.help import Help
from fieldkit.tui.host import Host
from fieldkit.tui.widgets.bars import KeyBar
from fieldkit.tui.widgets.dialogs import AskYes, HelpedModal
from fieldkit.tui.widgets.hanging import marked
from fieldkit.tui.widgets.line import Line
from fieldkit.tui.widgets.picker import Picker


class Field(Horizontal):
    """A question, its answer, and a note on the answer."""

    DEFAULT_CSS = """
    Field { height: 1; }
    Field > Label { width: 22; }
    Field > Input, Field > Input:focus { width: 19; height: 1; padding: 0; border: none; border-left: outer $border; }
    Field > .note { width: 1fr; height: 1; padding: 0 0 0 1; text-wrap: nowrap; text-overflow: ellipsis; }
    Field.-short > Label { width: auto; padding: 0 1 0 0; }
    Field.-short > Input, Field.-short > Input:focus { width: 1fr; }
    Field.-short > .note { display: none; }
    Field.-hand > Label { text-style: bold reverse; }
    """

    def __init__(self, question: Question, *, short: bool = False, text: str = "") -> None:
        super().__init__(id=f"field-{question.name}", classes="-short" if short else "")
        self.question, self._meant, self._noted = question, text, ""
        self._filled = printable(text)

    def compose(self) -> Iterable[Widget]:
        """Label, line, note."""
        yield Label(self.question.title if self.question.name != "config" else "Config")
        yield Line(self._filled, takes_marks=self.question.name == "notes", id=f"in-{self.question.name}")
        yield Static("", classes="note")

    @property
    def line(self) -> Input:
        """Where the answer is typed."""
        return self.query_one(Input)

    @property
    def answer(self) -> str:
        """The text as typed, or as filled in: a line shows sanitized text and rounded numbers."""
        text = self.line.value.strip()
        return self._meant if text == self._filled.strip() else text

    @property
    def typed(self) -> bool:
        """Whether the text differs from what was filled in."""
        return self.line.value != self._filled

    def fill(self, text: str, shown: str = "") -> None:
        """Set the answer of the line, displayed as `shown`."""
        self._meant, self._filled = text, printable(shown or text)
        self.line.value = self._filled

    def note(self, text: str) -> None:
        """Show a note on the answer."""
        if text != self._noted:
            self._noted, place = text, self.query_one(".note", Static)
            place.update(marked(printable(brief(text, place.size.width - 1))), layout=False)


def brief(note: str, width: int) -> str:
    """A note in a width [cell]; of one that is longer, only what its field does not show: `✗ unit 'x'`, `! 2 times the
    usual 22 s`, `! top speed looks 14% low`."""
    if cell_len(note) <= width:
        return note
    if note.startswith("! "):
        return f"! {note.partition(' is ')[2] or note[2:].partition(' for ')[0]}"
    if not note.startswith("✗ found "):
        return note
    return f"✗ {note.removeprefix('✗ found ').removeprefix('the ').partition(', expected')[0]}"


def step(screen: Screen[Any], by: int) -> None:
    """Move to the next or previous line of a screen; a key held down does not go around to the other end."""
    lines = screen.query(Input)
    if screen.focused is not (lines.last() if by > 0 else lines.first()):
        screen.focus_next() if by > 0 else screen.focus_previous()


class Form(HelpedModal[dict[str, object] | None]):
    """A few questions in a frame; the result is the fields of a flight by name, or None.

    `units` are those of numbers typed without one, by question; `read` converts a name, a text and its unit to a value,
    or raises BadValue. `names` finds the answers to offer while typing; names that it does not know must be confirmed.
    """

    DEFAULT_CSS = """
    Form { align: center middle; background: $backdrop; layers: base above; }
    Form > Vertical { width: 94%; max-width: 100; height: auto; max-height: 94%; background: $surface;
        border: solid $border; padding: 0 1; }
    Form VerticalScroll { height: auto; max-height: 64vh; }
    Form.-low VerticalScroll { max-height: 40vh; }
    Form.-tall VerticalScroll { max-height: 74vh; }
    Form #help { height: 2; color: $foreground; margin-top: 1; }
    """
    ABOUT = "Enter goes to the next field and saves after the last one. A number may have a unit, as in 923ft."
    VERTICAL_BREAKPOINTS = [(0, "-low"), (20, "-high"), (34, "-tall")]  # noqa: RUF012  # as Textual has it
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+s", "take", "Save", key_display="^S", priority=True),
        Binding("enter", "go_on", "Next", key_display="Enter", priority=True),
        Binding("up", "step(-1)", "Previous field", show=False, priority=True),
        Binding("down", "step(1)", "Fields", key_display="↑↓", priority=True),
        Binding("escape", "leave", "Cancel", priority=True),
    ]

    def __init__(
        self,
        title: str,
        questions: Iterable[Question],
        texts: dict[str, str],
        units: dict[str, str],
        read: Callable[[str, str, str], object] = read_answer,
        names: Callable[[], Names] | None = None,
    ) -> None:
        super().__init__()
        self._title, self._questions, self._texts, self._units = title, tuple(questions), texts, units
        self._value, self._find_names = read, names
        self._names: Names | None = None
        self._picker = Picker()
        self._reading: Worker[None] | None = None
        self._refused = False

    def compose(self) -> ComposeResult:
        """The questions, and what the current one means."""
        with Vertical() as frame:
            frame.border_title = Content(printable(self._title))
            yield from self.above()
            with VerticalScroll(can_focus=False):
                for question in self._questions:
                    yield Field(question, text=self._texts.get(question.name, ""))
            yield Static("", id="help")
            yield KeyBar()
        yield self._picker

    def above(self) -> Iterable[Widget]:
        """What is shown above the questions."""
        return ()

    def open_fields(self) -> dict[str, Field]:
        """The fields by question; none once the form closes, which removes its widgets before its workers end."""
        fields = {field.question.name: field for field in self.query(Field)}
        return fields if all(field.query(Input) for field in fields.values()) else {}

    def on_mount(self) -> None:
        """Read the answers to offer."""
        if self._find_names is not None:
            self._reading = self.run_worker(self._have_names, group="names")

    async def _have_names(self) -> None:
        with suppress(FieldkitError):  # without a ledger, no answers are offered
            self._names = await asyncio.to_thread(self._find_names) if self._find_names is not None else None
        if self._names is not None:
            self._picker.sources = self._names.sources()

    def on_descendant_focus(self) -> None:
        """Explain the current field, or show the full reason why it cannot be read."""
        field = self.focused.parent if self.focused is not None else None
        for one in self.query(Field):
            one.set_class(one is field, "-hand")
            one.note(self._read(one)[1] if one.answer else spelled(self._units.get(one.question.name, "")))
        if isinstance(field, Field):
            note = self._read(field)[1] if field.answer or self._refused else ""
            about = printable(note) if note.startswith(("✗", "? ")) else field.question.help
            self.query_one("#help", Static).update(marked(about))

    def on_descendant_blur(self) -> None:
        """Close the list when another line gets the focus."""
        self._picker.close()

    def on_input_changed(self, event: Input.Changed) -> None:
        """Update the note and the offered answers while typing."""
        self.on_descendant_focus()
        if isinstance(event.input.parent, Field) and event.input.parent.typed:
            self._picker.follow(event.input, event.input.parent.question.name)

    def _read(self, field: Field) -> tuple[object, str]:
        """The value of a field, and a note on it that starts with `✗` if the value cannot be used, and with `?` if it
        may be misspelled."""
        name, text = field.question.name, field.answer
        unit = self._units.get(name, "")
        try:
            value = self._value(name, "" if text == NOT_RECORDED else text, unit)
        except BadValue as error:
            return None, f"✗ {error}"
        if self._names is None or not field.typed:
            return value, self.beside(field, value, unit)
        if name == "motor" and (trouble := self._names.motor_trouble(str(value or ""))):
            return value, f"✗ {trouble}"  # no ledger accepts it
        doubt = self._names.doubt(name, value)
        return value, f"? {doubt}" if doubt else self.beside(field, value, unit)

    def beside(self, field: Field, value: object, unit: str) -> str:
        """The unit of an answer; if it was typed in another one, that and its value in the flyer's."""
        column, typed = field.question.column, typed_unit(field.answer)
        if column is None or not isinstance(value, float) or not typed or spelled(typed) == spelled(unit):
            return spelled(unit)
        return in_own_unit(column, value, typed, cast(Host, self.app).resources.settings.units)

    async def action_go_on(self) -> None:
        """Move to the next line, or save on the last one. A chosen answer is accepted first."""
        self._picker.take()
        field = self.focused.parent if self.focused is not None else None
        if isinstance(field, Field) and field.question == self._questions[-1]:
            await self.action_take()
        else:
            self.focus_next()

    def action_step(self, by: int) -> None:
        """Move to the next or previous line, or in the open list."""
        if self._picker.open:
            self._picker.move(by)
        else:
            step(self, by)

    def explained(self) -> tuple[str, Help]:
        """Every field."""
        fields = tuple((question.title, question.help) for question in self._questions)
        return self._title, Help(self.ABOUT, fields)

    def action_leave(self) -> None:
        """Close the list, or cancel the form."""
        if self._picker.open:
            self._picker.close()
        else:
            self.dismiss(None)

    async def action_take(self) -> None:
        """Submit the answers, once the known names are read, if all answers can be used; one that may be misspelled
        must be confirmed first."""
        if self._reading is not None:
            await self._reading.wait()
        values: dict[str, object] = {}
        doubts: dict[Field, str] = {}
        self._picker.close()
        for field in self.query(Field):
            value, note = self._read(field)
            if note.startswith("✗"):
                self._refused = True
                self.set_focus(field.line)  # immediately, because the next key is for it
                self.on_descendant_focus()
                return
            doubts |= {field: note.removeprefix("? ")} if note.startswith("? ") else {}
            values[field.question.name] = value
        if not doubts:
            self.dismiss(values)
            return

        def sure(yes: bool | None) -> None:
            if yes:
                self.dismiss(values)
            else:
                self.set_focus(next(iter(doubts)).line)

        self.app.push_screen(AskYes("\n".join([*doubts.values(), "Save it as it is?"])), sure)
