"""Add: the ten readouts as the altimeter shows them; every key is kept, odd figures are noted and never refused."""

from collections.abc import Iterable, Mapping
from functools import partial
from threading import Lock
from typing import ClassVar

from textual import events, on
from textual.binding import Binding, BindingType
from textual.containers import Container, Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Button, Digits, Input, Static

from fieldkit.entry import NOTHING, QUESTIONS, Question, oddities, read_answer
from fieldkit.errors import BadValue, FieldkitError
from fieldkit.flight import READOUTS, Flight
from fieldkit.measures import measure, spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.sanity import IDENTITY, identity
from fieldkit.tui.fields import Field
from fieldkit.tui.page import Help, Page, PageScreen

SETUP = ("rocket", "config", "motor", "site")
"""Asked above the readouts, and offered from the last flight."""
BY_NAME = {question.name: question for question in QUESTIONS}
READ = tuple(column.name for column in READOUTS)
MORE = tuple(name for name in BY_NAME if name not in (*SETUP, *READ))
OTHER = {"SI": "US", "US": "SI", "mixed": "SI"}
"""The system in which a figure is repeated beside it."""


class AddScreen(PageScreen):
    """The form: set-up above, the field in hand large, the ten readouts, the rest below."""

    NAME = "add"
    AUTO_FOCUS = f"#in-{READ[0]}"  # ready to be typed while the ledger is still being read
    TITLE = "Add a flight"
    ABOUT = Help(
        "Type what your altimeter shows, in its order; Enter goes on, the arrow up goes back. A unit may follow the "
        "number (923ft, 281.3 m, 140mph); without one it is the unit beside the field, and a unit once typed is the "
        "next one's. A lone - means not recorded. Odd figures are noted with ! and taken as they are. Every key is "
        "kept: after a dead battery the form is as you left it.",
        tuple((question.title, question.help) for question in QUESTIONS),
        ("fieldkit add", "fieldkit add --rocket R --motor M --apogee 935ft"),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("question_mark", "help", "Help", priority=True, show=False),
        Binding("enter", "go_on", "Next", key_display="Enter", priority=True),
        Binding("down", "app.focus_next", "Fields", key_display="↑↓", priority=True),
        Binding("ctrl+s", "save", "Save", key_display="^S"),
        Binding("ctrl+n", "anew", "Start anew", key_display="^N"),
        Binding("up", "app.focus_previous", "Back a field", show=False, priority=True),
        Binding("f1", "help", "Help", key_display="F1"),
        Binding("escape", "back", "Leave", tooltip="Leave the field, so that keys are keys again"),
    ]
    DEFAULT_CSS = """
    AddScreen #setup { layout: grid; grid-size: 4; grid-gutter: 0 1; height: auto; padding: 0 1; background: $panel; }
    AddScreen.-narrow #setup { grid-size: 2; }
    AddScreen #hand { height: 5; border: round $border; padding: 0 1; margin: 0 0; }
    AddScreen #big { width: 30; height: 3; color: $accent; }
    AddScreen.-narrow #big { width: 26; }
    AddScreen #says { width: 1fr; height: 3; }
    AddScreen #fields { padding: 0 1; height: 1fr; }
    AddScreen Button { min-width: 24; background: $panel; color: $foreground; text-style: bold; }
    AddScreen Button:focus { background: $block-cursor-background; color: $block-cursor-foreground; text-style: bold; }
    AddScreen.-tall #save { margin: 1 0; }
    AddScreen #readouts, AddScreen #more { height: auto; width: 1fr; }
    AddScreen.-wide #fields { layout: horizontal; }
    AddScreen.-tall #hand { margin: 1 0; }
    AddScreen.-tall Field { height: 3; }
    AddScreen.-tall Field > Label, AddScreen.-tall Field > .note { margin-top: 1; }
    AddScreen.-tall Field > Input { height: 3; border: round $border-blurred; padding: 0 1; }
    AddScreen.-tall Field > Input:focus { height: 3; border: round $border; padding: 0 1; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._touched: set[str] = set()
        self._units: dict[str, str] = {}
        self._flight = Flight()
        self._writing = self._dirty = False
        self._lock, self._kept_for = Lock(), 0

    def body(self) -> Iterable[Widget]:
        """The form."""
        with Container(id="setup"):
            for name in SETUP:
                yield Field(BY_NAME[name], short=True)
        with Horizontal(id="hand"):
            yield Digits("", id="big")
            yield Static("", id="says")
        with VerticalScroll(id="fields", can_focus=False):
            with Vertical(id="readouts"):
                for name in READ:
                    yield Field(BY_NAME[name])
                yield Button("Save this flight", id="save", compact=True)
            with Vertical(id="more"):
                for name in MORE:
                    yield Field(BY_NAME[name])

    def field(self, name: str) -> Field:
        """The field of a question."""
        return self.query_one(f"#field-{name}", Field)

    def reload(self) -> None:
        """Take up a draft, or offer what the last flight suggests."""
        if not self._touched:
            self.ask(self._start, self._started, "start")

    def _start(self) -> tuple[dict[str, str], dict[str, str], dict[str, str]]:
        from fieldkit.form import DRAFT, UNITS

        ledger = self.desk.ledger
        draft = ledger.draft(DRAFT) or {}
        return draft, ledger.draft(UNITS) or {}, self._offers(draft)

    def _offers(self, answers: Mapping[str, str]) -> dict[str, str]:
        """What the last flight suggests, given what was answered."""
        from fieldkit.form import offer

        flight, offers = Flight(), dict[str, str]()
        for question in QUESTIONS:
            text = answers.get(question.name)
            if text is None:
                text = offers[question.name] = offer(self.desk.ledger, flight, question)
            try:
                flight = flight.with_changes(**{question.name: read_answer(question.name, text)})
            except BadValue:
                continue
        return offers

    def _started(self, found: tuple[dict[str, str], dict[str, str], dict[str, str]]) -> None:
        draft, units, offers = found
        self._units = units | self._units
        typed = set(self._touched)
        self._fill({name: text for name, text in (offers | draft).items() if name not in typed})
        self._touched |= {name for name in draft if name in BY_NAME}
        if draft:
            self.tell("a flight was typed halfway: it goes on here; ^N starts anew")
        first = self.field(READ[0]).line
        if self.focused is first and READ[0] not in typed:
            named = [name for name in SETUP[:3] if not self.field(name).line.value]
            unread = [name for name in READ if name not in self._touched]
            self.set_focus(self.field((named or unread or READ)[0]).line)
        self._look()

    def _fill(self, texts: Mapping[str, str]) -> None:
        with self.prevent(Input.Changed):
            for name, text in texts.items():
                if name in BY_NAME:
                    self.field(name).fill(text)

    def unit(self, question: Question) -> str:
        """The unit of a number typed without one: the last typed, else that of the settings."""
        from fieldkit.form import kind

        column = question.column
        if column is None:
            return ""
        return self._units.get(kind(column)) or unit_of(column, self.desk.settings.units)

    @on(Input.Changed)
    def _typed(self, event: Input.Changed) -> None:
        """Read what is there now, say what is odd, keep it."""
        field = event.input.parent
        if isinstance(field, Field):
            self._touched.add(field.question.name)
            self._look()
            self._keep()

    def _look(self) -> None:
        """Read all answers into a flight and note what cannot be read or looks odd."""
        flight, wrong = Flight(), dict[str, str]()
        for name, question in BY_NAME.items():
            text = self.field(name).answer
            try:
                value = read_answer(name, "" if text == NOTHING else text, self.unit(question))
                flight = flight.with_changes(**{name: value})
            except BadValue as error:
                wrong[name] = str(error)
        self._flight = flight
        for name, question in BY_NAME.items():
            self.field(name).note(f"✗ {wrong[name]}" if name in wrong else self._note(question))
        self._in_hand(wrong)

    def _note(self, question: Question) -> str:
        """What is odd about an answer, else its unit, and the figure in the other system."""
        column = question.column
        if odd := oddities(self._flight, question.name):
            return f"! {odd[0]}"
        if column is None:
            return ""
        value = self._flight.number(question.name)
        unit = spelled(self.unit(question))
        if value is None:
            return unit
        other = measure(column, value, OTHER[self.desk.settings.units])
        mine = measure(column, value, self.desk.settings.units)
        return f"{unit}  = {mine} = {other}" if other != mine else unit

    def _in_hand(self, wrong: Mapping[str, str]) -> None:
        """The field in hand, large, with what it means and what the figures say together."""
        from fieldkit.form import typed_unit

        field = self.focused.parent if self.focused is not None else None
        for one in self.query(Field):
            one.set_class(one is field, "-hand")
        frame = self.query_one("#hand")
        if not isinstance(field, Field):
            frame.border_title = "Enter saves it"
            self._say([self._summary(), *self._together()])
            return
        question = field.question
        column, value = question.column, self._flight.number(question.name) if question.column else None
        text = field.line.value.strip()
        unit = f" ({spelled(self.unit(question))})" if column else ""
        frame.border_title = Content(f"{question.title}{unit}")
        self.query_one("#big", Digits).update(text[: len(text) - len(typed_unit(text))] if value is not None else "")
        frame.border_subtitle = spelled(typed_unit(text)) if value is not None else ""
        trouble = wrong.get(question.name)
        odd = oddities(self._flight, question.name)
        first = f"✗ {trouble}" if trouble and text else f"! {odd[0]}" if odd else question.help
        self._say([first, *self._together()])

    def _say(self, lines: Iterable[str]) -> None:
        self.query_one("#says", Static).update(
            Content("\n".join(printable(line) for line in lines if line)), layout=False
        )

    def _together(self) -> list[str]:
        """The identity of speed, acceleration and burn time, and ejection against apogee."""
        lines, ratio = [], identity(self._flight)
        if ratio is not None:
            fits = IDENTITY[0] <= ratio <= IDENTITY[1]
            lines.append(f"speed/(average × burn) {ratio:.2f} {'✓' if fits else '! not about 1'}")
        apogee, eject = self._flight.apogee, self._flight.eject_altitude
        if apogee is not None and eject is not None:
            below = measure(READOUTS[0], abs(apogee - eject), self.desk.settings.units)
            lines.append(
                f"ejection {below} below apogee ✓" if eject <= apogee * 1.001 else f"! ejection {below} ABOVE apogee"
            )
        return lines

    def _summary(self) -> str:
        flight = self._flight
        count = len(flight.readouts())
        return f"{flight.rocket} {flight.config} on {flight.motor}: {count} of 10 readouts"

    def _keep(self) -> None:
        """Keep the draft; what is typed while it is being written is written after."""
        if self._writing:
            self._dirty = True
            return
        self._writing, self._dirty = True, False
        self.ask(partial(self._write, self._kept_for, self._answers(), dict(self._units)), self._kept, "draft")

    def _answers(self) -> dict[str, str]:
        """What was typed, units and all."""
        from fieldkit.form import with_unit

        texts = {name: self.field(name).answer for name in BY_NAME if name in self._touched}
        return {name: with_unit(text, self.unit(BY_NAME[name])) for name, text in texts.items()}

    def _write(self, flight: int, answers: dict[str, str], units: dict[str, str]) -> None:
        """Keep a draft, unless its flight was saved in the meantime."""
        from fieldkit.form import DRAFT, UNITS

        with self._lock:
            if flight != self._kept_for:
                return
            self.desk.ledger.keep_draft(DRAFT, answers)
            if units:
                self.desk.ledger.keep_draft(UNITS, units)

    def _kept(self, _: None) -> None:
        self._writing = False
        if self._dirty:
            self._keep()

    def on_descendant_focus(self, event: events.DescendantFocus) -> None:
        """The field in hand is shown large."""
        self._look()
        event.widget.scroll_visible(animate=False)

    def action_go_on(self) -> None:
        """To the next field; after the tenth readout comes the button that saves."""
        if isinstance(self.focused, Button):
            self.action_save()
        elif isinstance(self.focused, Input) and self.focused.id == f"in-{MORE[-1]}":
            self.set_focus(self.query_one("#save", Button))
        else:
            self.focus_next()

    @on(Input.Blurred)
    def _left(self, event: Input.Blurred) -> None:
        """A field was left: its unit is the next one's, another rocket suggests other answers."""
        from fieldkit.form import kind, typed_unit

        field = event.input.parent
        if not isinstance(field, Field) or field.question.name not in self._touched:
            return
        question, column = field.question, field.question.column
        unit = typed_unit(event.value)
        if column is not None and unit and self._flight.number(question.name) is not None:
            self._units[kind(column)] = unit
            self._look()
        if question.name in ("rocket", "config"):
            self._offer_again()
        if question.name == "motor" and event.value:
            self.ask(partial(self._motor_trouble, event.value), self._say_motor, "motor")

    def _motor_trouble(self, name: str) -> str:
        from fieldkit.motors import is_cluster

        return "" if is_cluster(name) else self.desk.motors.complaint(name) or ""

    def _say_motor(self, trouble: str) -> None:
        if trouble:
            self.complain(f"Motor: {trouble}")

    def _offer_again(self) -> None:
        """Another rocket or configuration suggests other answers where nothing was typed."""
        self.ask(partial(self._offers, self._answers()), self._offered, "offers")

    def _offered(self, offers: dict[str, str]) -> None:
        self._fill({name: text for name, text in offers.items() if name not in self._touched})
        self._look()

    @on(Button.Pressed, "#save")
    def action_save(self) -> None:
        """Put the flight in the ledger."""
        texts = {name: with_nothing(self.field(name).answer) for name in BY_NAME}
        units = {name: self.unit(question) for name, question in BY_NAME.items()}
        self.ask(partial(self._saved, texts, units), self._added, "save")

    def _saved(self, texts: Mapping[str, str], units: Mapping[str, str]) -> tuple[str, str]:
        """The name of a field that cannot be read and why, or the id of the flight."""
        from fieldkit.form import DRAFT, enter

        flight = Flight()
        for name, text in texts.items():
            try:
                flight = flight.with_changes(**{name: read_answer(name, text, units[name])})
            except BadValue as error:
                return name, f"{BY_NAME[name].title}: {error}"
        if flight.motor and (trouble := self._motor_trouble(flight.motor)):
            return "motor", f"Motor: {trouble}"
        try:
            with self._lock:
                flight, added = enter(self.desk.ledger, flight, DRAFT)
                self._kept_for += 1
        except FieldkitError as error:
            return "rocket" if not flight.rocket else READ[0], str(error)
        return "", added.new[0] if added.new else ""

    def _added(self, found: tuple[str, str]) -> None:
        wrong, text = found
        if wrong:
            self.complain(text)
            self.set_focus(self.field(wrong).line)
            return
        self.tell(f"added as flight {text}; u takes it back" if text else "it is in the ledger already")
        self._clear()
        self.field_app.changed()

    def action_anew(self) -> None:
        """Forget what was typed."""
        from fieldkit.form import DRAFT

        def forget() -> None:
            with self._lock:
                self._kept_for += 1
                self.desk.ledger.drop_draft(DRAFT)

        self._clear()
        self.ask(forget, lambda _: self.reload(), "anew")

    def _clear(self) -> None:
        self._touched, self._writing, self._dirty = set(), False, False
        self._fill(dict.fromkeys(BY_NAME, ""))

    def resting_place(self) -> Widget | None:
        """The button: from it the keys of the app work."""
        return self.query_one("#save", Button)

    def copied(self) -> str:
        """The form as text."""
        return "\n".join(f"{BY_NAME[n].title}  {t}" for n, t in self._answers().items() if t)


def with_nothing(text: str) -> str:
    """A lone dash means nothing."""
    return "" if text == NOTHING else text


PAGE = Page(2, "Add", AddScreen)
