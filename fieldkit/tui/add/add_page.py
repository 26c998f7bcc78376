"""Add: the ten readouts in the order of the altimeter; every key is saved, nothing is refused before saving.

The help of the Add page.

Saves what is typed on the Add page: immediately and in order, independent of other workers.

Saving the flight on the Add page: doubtful answers are confirmed first, and the result is shown.
"""

from asyncio import wrap_future
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import partial
from typing import ClassVar

from textual import events, on
from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Button, Input

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.importing.manual_entry import JUDGED_QUESTIONS, QUESTIONS, Question, date_order
from fieldkit.quantities import spelled, unit_of
from fieldkit.services.manual_entry import kind, typed_unit, with_unit
from fieldkit.tui.add.add_form import (
    BY_NAME,
    DATE,
    MORE_FIELDS,
    READOUT_QUESTIONS,
    Answered,
    Draft,
    FormStart,
    Saved,
    answered,
    beside,
)
from fieldkit.tui.add.add_hand import Hand
from fieldkit.tui.add.add_sheet import FORM_CSS, Sheet, field_of
from fieldkit.tui.add.after_card import AfterCard, AfterFlight, after_flight
from fieldkit.tui.add.estimate_line import EstimateLine
from fieldkit.tui.add.fields import Field, step
from fieldkit.tui.help import Help
from fieldkit.tui.page import PageScreen
from fieldkit.tui.setup.rocket_strip import RocketStrip, rocket_facts
from fieldkit.tui.widgets.dialogs import AskYes

DUPLICATE = "Duplicate: it is already in the ledger."


class Saving:
    """Saves the answers to the ledger, and shows the card that then replaces the form."""

    def __init__(self, page: PageScreen, sheet: Sheet, draft: Draft) -> None:
        self._page, self._sheet, self._draft = page, sheet, draft
        self._objections: list[str] = []

    @property
    def card(self) -> AfterCard:
        """The card of the flight that was just saved."""
        return self._page.query_one(AfterCard)

    def object_to(self, trouble: str) -> None:
        """Show `trouble` with an answer as a notice, which stays until the flight is saved; nothing if it is empty."""
        if trouble:
            self._objections.append(trouble)
            self._page.complain(trouble)

    async def save_once(self, answered: Answered) -> None:
        """Save the flight in the ledger unless a card is shown; the next keys wait, because saving clears the form."""
        if not self.card.display:
            self.save(answered)
            await self._page.settled("save")

    def save(self, answered: Answered, *, confirmed: bool = False) -> None:
        """Save the flight in the ledger."""
        self._page.ask(partial(self._draft.save, answered, confirmed=confirmed), partial(self._saved, answered), "save")

    def clear_if_saved(self, read: Callable[[], Answered], go_on: Callable[[], None]) -> None:
        """Clear a flight that is in the ledger now, unless something was typed meanwhile; else continue with `go_on`.
        `read` returns the answers."""
        typed = read().flight

        def clear(saved: bool) -> None:
            if saved and read().flight == typed:
                self._sheet.clear()
                self._page.reload()
            else:
                go_on()

        self._page.ask(partial(self._draft.is_saved, typed), clear, "start")

    def leave_card(self) -> None:
        """Return to the form."""
        self._front(card=False)

    def _saved(self, answered: Answered, saved: Saved) -> None:

        if saved.confirm:
            self._page.app.push_screen(AskYes(saved.confirm), partial(self._confirmed, answered))
            return
        if saved.wrong:
            self.object_to(saved.trouble)
            self._page.set_focus(self._sheet.field(saved.wrong).line)
            return
        for objection in self._objections:
            self._page.field_app.withdraw(objection)
        self._objections = []
        silent = f" Without its {saved.lacks} it does not constrain Cd." if saved.lacks else ""
        taken = f" {saved.taken}" if saved.taken else ""
        self._page.show_notice(f"Saved {flight_label(saved.id)}. u to undo.{taken}{silent}" if saved.id else DUPLICATE)
        if saved.trouble:
            self._page.complain(saved.trouble)
        self._sheet.clear()
        if saved.id and saved.flight is not None:
            self._compare(saved.id, saved.flight)
        else:
            self._page.set_focus(self._sheet.button)  # outside a field, a digit opens a page
        self._page.field_app.changed()

    def _confirmed(self, answered: Answered, yes: bool | None) -> None:
        """Save the flight anyway, or return to it."""
        if yes:
            self.save(answered, confirmed=True)
        else:
            self._page.set_focus(self._sheet.field(READOUT_QUESTIONS[0]).line)

    def _compare(self, id: str, flight: Flight) -> None:
        """Show forecast and flown, and the next forecast, as soon as they are computed."""
        resources = self._page.resources
        self.card.saved(id, flight, resources.settings.units)
        self._front(card=True)
        self._page.set_focus(self.card)
        self._page.ask(partial(after_flight, resources, flight), self._show, "outcome", alone="app")

    def _show(self, found: AfterFlight | None) -> None:
        self.card.show(found, self._page.resources.settings.units)

    def _front(self, *, card: bool) -> None:
        for widget in self._sheet.widgets():
            widget.display = not card
        self.card.display = card
        self._page.set_class(card, "-saved")


class DraftPen:
    """One thread that saves a draft; the page is notified once if it cannot be saved."""

    def __init__(self, page: PageScreen) -> None:
        self._page = page
        self._writer = ThreadPoolExecutor(1, "draft")
        self._unkept = ""

    def keep(self, draft: Draft, answers: Mapping[str, str], units: Mapping[str, str]) -> Future[None]:
        """Save a draft; it replaces one that is still waiting to be written."""
        kept = self._writer.submit(draft.keep, draft.flight, answers, units, draft.shown)
        self._page.run_worker(partial(self._report_unsaved, kept), exclusive=True, group="draft")  # type: ignore[arg-type]  # narrower than it takes
        return kept

    def finish(self) -> None:
        """Wait until the draft is written."""
        self._writer.shutdown()

    async def _report_unsaved(self, writing: Future[None]) -> None:
        before, self._unkept = self._unkept, ""
        try:
            await wrap_future(writing)
        except FieldkitError as error:
            self._unkept = str(error)
            if self._unkept != before:
                self._page.complain(f"What you type cannot be saved: {error}")


ABOUT = Help(
    "Type what your altimeter shows, in its order. Enter goes to the next field, the up arrow to the one before. "
    "Everything you type is saved at once, so a dead battery loses nothing.",
    (
        (
            "units",
            "A number may have a unit (923ft, 281.3 m, 140mph), which also applies to the next flight; without one it "
            "is in the unit beside the field. Esc, then N, switches to feet, mph and ounces, and back.",
        ),
        ("-", "A lone - means not recorded."),
        ("!", "Implausible; it is accepted all the same."),
        *((question.title, question.help) for question in (*QUESTIONS, *JUDGED_QUESTIONS)),
    ),
    ("fieldkit add", "fieldkit add --rocket R --motor M --apogee 935ft"),
)


AT_MOST = 0.02
"""Maximum time that the display of a key waits for its saving, which is enough for most disks. [s]"""


class AddScreen(PageScreen):
    """The form: set-up above, the current field large, the ten readouts, the rest below."""

    NAME = "add"
    AUTO_FOCUS = f"#in-{READOUT_QUESTIONS[0]}"  # accepts input while the ledger is still being read
    TITLE = "Add a flight"
    ABOUT = ABOUT
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("question_mark", "help", "Help", priority=True, show=False),
        Binding("enter", "go_on", "Next", key_display="Enter", priority=True, tooltip="Take the answer"),
        Binding("down", "step(1)", "Fields", key_display="↑↓", priority=True, tooltip="The next field; ↑ previous"),
        Binding("ctrl+s", "save", "Save", key_display="^S", tooltip="Save this flight"),
        Binding("ctrl+n", "start_again", "Start over", key_display="^N", tooltip="Clear what was typed"),
        Binding("up", "step(-1)", "Previous field", show=False, priority=True),
        Binding("f1", "help", "Help", key_display="F1", tooltip="Explain the field and the form"),
        Binding("N", "next_units", "Units", tooltip="Next units: SI, US, mixed"),
        Binding("escape", "back", "Leave", tooltip="Leave the field, so that keys work as commands", priority=True),
    ]
    VERTICAL_BREAKPOINTS = [(0, "-short"), (34, "-high"), (40, "-tall"), (58, "-lofty")]  # noqa: RUF012  # as Textual has it
    DEFAULT_CSS = FORM_CSS

    def __init__(self) -> None:
        super().__init__()
        self._sheet = Sheet(self)
        self._units: dict[str, str] = {}
        self._answered = Answered(Flight(), {}, {})
        self._usual: dict[str, float] = {}
        self._rocket = ("", "")
        self._pen = DraftPen(self)

    def on_mount(self) -> None:
        """Prepare the draft of the flight being entered."""
        self._draft, self._system = Draft(self.resources), self.resources.settings.units
        self._saving = Saving(self, self._sheet, self._draft)

    def on_unmount(self) -> None:
        """Save the last key."""
        self.finish()

    def keep_typed(self) -> None:
        """Save the answers as they stand."""
        if self.is_mounted and (answers := self._answers()):
            self._pen.keep(self._draft, answers, dict(self._units))

    def finish(self) -> None:
        """Wait until the draft is written."""
        self._pen.finish()

    def body(self) -> Iterable[Widget]:
        """The form, and the card that replaces it after saving."""
        yield from self._sheet.body()
        yield AfterCard()

    def field(self, name: str) -> Field:
        """The field of a question."""
        return self._sheet.field(name)

    def reload(self) -> None:
        """Continue a draft and offer defaults; clear a typed flight that is saved now; the card changes its units."""
        if self._system != self.resources.settings.units:  # chosen after any unit that was typed
            self._units, self._system = {}, self.resources.settings.units
        self.query_one(EstimateLine).forget()
        self._rocket = ("", "")
        self._saving.card.redraw(self.resources.settings.units)
        if self._sheet.touched:
            self._saving.clear_if_saved(self._read, self._offer_again)  # a forecast may have been saved
        else:
            self.ask(self._draft.begin, self._take_up, "start")

    def _take_up(self, start: FormStart) -> None:
        """Fill the lines that are still empty, and go to the first empty question."""
        self._units = dict(start.units) | self._units
        ahead = self.field(READOUT_QUESTIONS[0]).typed
        self._sheet.fill(start.draft)
        self._sheet.touched |= start.draft.keys() & BY_NAME.keys()
        self._sheet.fill(start.offers, self.resources.settings.units)
        self._sheet.picker.sources = start.names.sources()
        if start.draft and not self._draft.shown:
            other = f"^N to start the forecast's: {start.waiting}" if start.waiting else "^N to start over"
            self.show_notice(f"Unfinished flight{_of(start.draft)}: continue here, or {other}")
        self._draft.shown = True
        if start.draft and isinstance(self.focused, AfterCard):  # its flight was undone
            self._saving.leave_card()
            self.set_focus(self._sheet.button)
        first = self.field(READOUT_QUESTIONS[0]).line
        if self.focused is first and not ahead:
            self._to_first()
        self._look()
        self._ask_usual()

    def came(self) -> None:
        """Focus the field where typing continues."""
        if not isinstance(self.focused, Input):
            self._to_first()

    @property
    def typed(self) -> bool:
        """Whether anything was typed that is not saved."""
        return bool(self._sheet.touched)

    def _to_first(self) -> None:
        self._saving.leave_card()
        self.set_focus(self._sheet.first_empty())

    def unit(self, question: Question) -> str:
        """The unit of a number typed without one: the one that applied when it was typed, the last typed, else the
        settings'."""
        column = question.column
        if column is None:
            return ""
        known = self._sheet.typed_in.get(question.name) or self._units.get(kind(column))
        return known or unit_of(column, self.resources.settings.units)

    @on(Input.Changed)
    def _typed(self, event: Input.Changed) -> None:
        """Read the current answers, note what is implausible, and save them."""
        field = field_of(event.input)
        if field is not None:
            self._sheet.touch(field, self.unit(field.question))
            kept: Future[None] = self._pen.keep(self._draft, self._answers(), dict(self._units))
            self._look()
            self._sheet.picker.follow(event.input, field.question.name)
            wait([kept], AT_MOST)

    def _look(self) -> None:
        """Read all answers into a flight, and note unreadable or implausible ones."""
        self._answered = self._read()
        system = self.resources.settings.units
        for name, question in BY_NAME.items():
            note = beside(question, self._answered, self._unit_of_answer(question), system)
            typed = typed_unit(self.field(name).line.value)
            self.field(name).note("" if typed and note == spelled(typed) else note)
        self._show_current()
        self._show_rocket(self._answered.flight)
        self.query_one(EstimateLine).follow(self._answered.flight, self._answered.lift_off)

    def _show_rocket(self, flight: Flight) -> None:
        """Show the rocket and its flights below the form, if there is room."""
        if self.has_class("-wide") and not self.has_class("-short") and self._rocket != (flight.rocket, flight.config):
            self._rocket = flight.rocket, flight.config
            facts = partial(rocket_facts, self.resources, flight)
            self.ask(facts, self.query_one(RocketStrip).show, "rocket")

    def _unit_of_answer(self, question: Question) -> str:
        """The unit that is shown with an answer, else that of a number without one."""
        known = question.column is not None and self._answered.number(question) is not None
        return (typed_unit(self.field(question.name).line.value) if known else "") or self.unit(question)

    def _read(self) -> Answered:
        units = {name: self.unit(question) for name, question in BY_NAME.items()}
        units[DATE.name] = date_order(self.resources.settings.units)
        return answered(self._sheet.answers(), units, self._usual)

    def _ask_usual(self) -> None:
        """Look up this rocket's readouts on this motor, to detect mistakes."""
        self.ask(partial(self._draft.usual, self._answered.flight), self._know_usual, "usual")

    def _know_usual(self, usual: dict[str, float]) -> None:
        self._usual = usual
        self._look()

    def _show_current(self) -> None:
        """Show the current field in large digits, with its meaning and the consistency of the readouts."""
        field, hand = self._sheet.highlight(self.focused), self.query_one(Hand)
        system = self.resources.settings.units
        if field is not None:
            hand.show(field, self._answered, self.unit(field.question), system)
        else:
            hand.rest(self._answered, system)
            self.follow_keys()  # the action of Enter depends on the answers

    def _answers(self) -> dict[str, str]:
        """The typed answers with their units."""
        texts = {name: text for name, text in self._sheet.answers().items() if name in self._sheet.touched}
        return {name: with_unit(text, self.unit(BY_NAME[name])) for name, text in texts.items()}

    def on_descendant_focus(self, event: events.DescendantFocus) -> None:
        """Show the current field in large digits, once the cursor is in it."""
        self.soon(self._show_current)
        event.widget.scroll_visible(animate=False, immediate=True)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Without input there is nothing to save; on the card of a saved flight, arrows scroll it."""
        if action == "save" and isinstance(self.focused, Button | AfterCard) and not self.typed:
            return False
        if action in ("step", "start_again") and isinstance(self.focused, AfterCard):
            return False
        return super().check_action(action, parameters)

    async def action_go_on(self) -> None:
        """Move to the next field; after the tenth readout, past a known mass and diameter to the button that saves and
        starts the next flight. A chosen answer from the list is accepted first."""
        self._sheet.picker.take()
        if isinstance(self.focused, AfterCard) or (isinstance(self.focused, Button) and not self.typed):
            self._to_first()
        elif isinstance(self.focused, Button):
            await self.action_save()
        elif isinstance(self.focused, Input) and self.focused.id == f"in-{MORE_FIELDS[-1]}":
            self.set_focus(self._sheet.button)
        elif isinstance(self.focused, Input) and self.focused.id == f"in-{READOUT_QUESTIONS[-1]}":
            self.set_focus(self._sheet.after_readouts())
        else:
            self.focus_next()

    def action_step(self, by: int) -> None:
        """Move to the next or previous field, or in the open list."""
        if self._sheet.picker.open:
            self._sheet.picker.move(by)
        else:
            step(self, by)

    def action_back(self) -> None:
        """Close the open list, or else act as on every page."""
        if self._sheet.picker.open:
            self._sheet.picker.close()
        else:
            super().action_back()

    @on(Input.Blurred)
    def _left(self, event: Input.Blurred) -> None:
        """After leaving a field: its unit becomes the default of the next, and another rocket changes the defaults."""
        field = field_of(event.input)
        self._sheet.picker.close()
        if field is None or field.question.name not in self._sheet.touched:
            return
        question, column = field.question, field.question.column
        unit = typed_unit(event.value)
        if column is not None and unit and self._answered.number(question) is not None:
            self._units[kind(column)] = unit
            self._look()
        if question.name in ("rocket", "config"):
            self._offer_again()
        if question.name == "motor":
            self._ask_usual()
            self.ask(partial(self._draft.motor_trouble, event.value), self._saving.object_to, "motor")

    def _offer_again(self) -> None:
        """Change the defaults of untouched fields after another rocket or configuration was typed."""
        self.ask(partial(self._draft.offers, self._answers()), self._offered, "offers")

    def _offered(self, offers: dict[str, str]) -> None:
        self._sheet.fill(offers, self.resources.settings.units)
        self._look()
        self._ask_usual()

    @on(Button.Pressed, "#save")
    async def action_save(self) -> None:
        """Save the flight in the ledger."""
        await self._saving.save_once(self._read())

    def action_start_again(self) -> None:
        """Discard the draft; undo restores it."""
        self._sheet.clear()
        self.set_focus(self.field(READOUT_QUESTIONS[0]).line)
        self.change(self._draft.forget, self._forgotten)

    def _forgotten(self, any_was: bool) -> None:
        if any_was:
            self.show_notice("Started over. ^Z to undo")
        self.reload()

    def resting_place(self) -> Widget | None:
        """The button, or the card of the saved flight; the keys of the app work there."""
        return self._saving.card if self._saving.card.display else self._sheet.button

    def copied(self) -> str:
        """The form as text, or the card of the saved flight."""
        if self._saving.card.display:
            return self._saving.card.text
        return "\n".join(f"{BY_NAME[n].title}  {t}" for n, t in self._answers().items() if t)


def _of(draft: Mapping[str, str]) -> str:
    """The rocket and configuration of a draft, if it names a rocket: ` of Astra A`."""
    build = " ".join(draft[name] for name in ("rocket", "config") if draft.get(name))
    return f" of {build}" if draft.get("rocket") else ""
