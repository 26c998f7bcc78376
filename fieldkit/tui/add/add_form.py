"""The form of the Add page without its widgets: default answers, answers, implausible values, and saving."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import date, datetime
from threading import Lock

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.flight import READOUTS, Flight
from fieldkit.flight.further import JUDGED_COLUMNS
from fieldkit.flight.plausibility import (
    DESCENT,
    IDENTITY,
    descent_ratio,
    identity,
    inconsistent_descent,
    inconsistent_speed,
)
from fieldkit.importing.manual_entry import (
    JUDGED_QUESTIONS,
    LIFT_OFF_MASS,
    NOT_RECORDED,
    QUESTIONS,
    Question,
    implausible_answers,
    read_answer,
    read_lift_off_mass,
    with_cells,
)
from fieldkit.messages import marked, message
from fieldkit.motors import is_cluster
from fieldkit.presentation.after_flight_text import apogee_question
from fieldkit.quantities import in_own_unit, in_system, measure, spelled, system_typed
from fieldkit.services.after_flight import expected_instead
from fieldkit.services.manual_entry import (
    UNITS,
    enter,
    id_and_time,
    identical_flight,
    offer,
    planned_answers,
    typed_unit,
    usual,
    weighed,
)
from fieldkit.services.pickers import Names
from fieldkit.services.plausible_flights import excluded_readouts, implausible_flights
from fieldkit.services.range_box import taken_in_words
from fieldkit.tui.resources import Resources

SETUP = ("rocket", "config", "motor", "site")
"""Asked above the readouts, with the last flight's values as defaults."""
DATE = Question(
    "date_time", "Date", "When it flew: 10:30, yesterday 10:30, 2026-05-01 or 2026-05-01 10:30.", offered=True
)


def _asked() -> Iterable[Question]:
    yield DATE
    for question in QUESTIONS:
        yield question
        if question.name == LIFT_OFF_MASS.read_as:
            yield LIFT_OFF_MASS
    yield from JUDGED_QUESTIONS


BY_NAME = {question.name: question for question in _asked()}
"""Every question by its name."""
READOUT_QUESTIONS = tuple(column.name for column in READOUTS)
"""The questions about readouts, in the order of the altimeter."""
BODY = ("dry_mass", "diameter")
"""Needed for Cd and the next forecast; asked before saving if the ledger does not know them."""
MORE_FIELDS = tuple(name for name in BY_NAME if name not in (*SETUP, *READOUT_QUESTIONS, *BODY))
"""The other questions, asked below the button."""
SYSTEM = "system"
"""Key of the system of units in which units were typed, beside the units."""
TODAY = "today"
"""The default date."""


@dataclass(frozen=True, slots=True)
class Answered:
    """The answers as a flight, the errors of unreadable ones by question, the `usual` readouts of the same rocket on
    the same motor, and the mass with the motor, if the rocket was weighed with it. [SI]"""

    flight: Flight
    wrong: Mapping[str, str]
    usual: Mapping[str, float]
    lift_off: float | None = None
    apogee_unit: str = ""
    """The unit in which the apogee was typed, with it or before."""

    def number(self, question: Question) -> float | None:
        """The answer to a question about a number. [SI]"""
        return self.lift_off if question is LIFT_OFF_MASS else self.flight.number(question.name)


@dataclass(frozen=True, slots=True)
class FormStart:
    """The initial state of the form: the draft, the units typed last, the last flight's values."""

    draft: Mapping[str, str]
    units: Mapping[str, str]
    offers: Mapping[str, str]
    names: Names
    waiting: str = ""
    """The build of an open forecast, if the draft is of another one: `Astra B on F39T-6`."""


@dataclass(frozen=True, slots=True)
class Saved:
    """The result of saving: the id of the flight (empty for a duplicate), what it lacks to constrain Cd, what it took
    from the range box, and the `trouble` that excludes it from every fit; or the name of a `wrong` answer, and the
    `trouble` with it; or a question to `confirm` before the flight is added."""

    id: str = ""
    flight: Flight | None = None
    confirm: str = ""
    lacks: str = ""
    wrong: str = ""
    trouble: str = ""
    taken: str = ""


def answered(texts: Mapping[str, str], units: Mapping[str, str], usual: Mapping[str, float]) -> Answered:
    """Read all answers; `units` are those of numbers typed without one, `usual` as in `Answered`. A flight of `TODAY`
    has no time yet: it gets that at which it is saved."""
    flight, wrong, lift_off = Flight(), dict[str, str](), None
    for name, text in texts.items():
        try:
            if name == DATE.name and text.strip().casefold() == TODAY:
                continue
            if name == LIFT_OFF_MASS.name:
                lift_off = read_lift_off_mass(text, units.get(name, ""))
                continue
            value = read_answer(name, "" if text == NOT_RECORDED else text, units.get(name, ""))
            cells = with_cells(flight.extra, {name: str(value)}) if name in JUDGED_COLUMNS else None
            flight = flight.with_changes(**{name: value} if cells is None else {"extra": cells})
        except BadValue as error:
            wrong[name] = str(error)
    typed_in = typed_unit(texts.get("apogee", "")) or units.get("apogee", "")
    return Answered(flight, wrong, usual, lift_off, typed_in)


def beside(question: Question, answered: Answered, unit: str, system: str) -> str:
    """The note next to an answer: why it cannot be read, what is implausible, or its unit."""
    if question.name in answered.wrong:
        return f"✗ {answered.wrong[question.name]}"
    if reason := implausible_answers(answered.flight, question.name, answered.usual):
        return f"! {in_system(reason[0], system)}"
    column = question.column
    value = answered.number(question) if column else None
    return spelled(unit) if column is None or value is None else in_own_unit(column, value, unit, system)


def together(flight: Flight, system: str) -> Iterable[str]:
    """Consistency of the readouts: speed, acceleration and burn time, and ejection against apogee and the way down."""
    ratio = identity(flight)
    if ratio is not None:
        fits = IDENTITY[0] <= ratio <= IDENTITY[1]
        mismatch = in_system(inconsistent_speed(flight, ratio), system)
        yield "top speed and burn time agree ✓" if fits else f"! {mismatch}"
    apogee, eject, sinking = flight.apogee, flight.eject_altitude, descent_ratio(flight)
    if sinking is not None and not DESCENT[0] <= sinking <= DESCENT[1]:
        yield f"! {in_system(inconsistent_descent(flight, sinking), system)}"
    elif apogee is not None and eject is not None:
        below = measure(READOUTS[0], abs(apogee - eject), system)
        yield f"ejection {below} below apogee ✓" if eject <= apogee * 1.001 else f"! ejection {below} ABOVE apogee"


def summary(flight: Flight) -> str:
    """The flight in one line: `Astra A on F24-4W: 10 of 10 readouts`."""
    build = " ".join(part for part in (flight.rocket or "rocket not named", flight.config) if part)
    motor = f" on {flight.motor}" if flight.motor else ""
    return f"{build}{motor}: {len(flight.readouts())} of {len(READOUT_QUESTIONS)} readouts"


def lacks(flight: Flight) -> str:
    """What a flight lacks to constrain drag and thrust, empty if it has everything: `motor and dry mass`."""
    return " and ".join(BY_NAME[name].title.lower() for name in ("motor", "dry_mass") if not getattr(flight, name))


def _other_build(draft: Mapping[str, str], plan: Mapping[str, str]) -> str:
    """The build of a plan if a draft names another rocket or configuration; else empty."""
    if not draft or all(draft.get(name, plan.get(name, "")) == plan.get(name, "") for name in ("rocket", "config")):
        return ""
    build = " ".join(plan[name] for name in ("rocket", "config") if plan.get(name))
    return f"{build} on {plan['motor']}" if plan.get("motor") else build


class Draft:
    """The flight being entered, as a draft in the ledger and finally saved.

    A worker saves drafts while keys are typed: a draft that arrives after its flight was saved or discarded is dropped.
    All methods may be called from any thread.
    """

    def __init__(self, resources: Resources) -> None:
        self._resources = resources
        self._lock = Lock()
        self._units: Mapping[str, str] = {}
        self._kept = False  # whether the ledger has held what was typed last
        self._dated = False  # whether the ledger has the day on which it was started
        self.flight = 0
        """Counts the flights that were entered."""
        self.shown = False
        """Whether the draft in the ledger has been filled into the form; until then it is not overwritten."""

    def begin(self) -> FormStart:
        """Load the draft; one that was started on another day has that day as its default date."""
        ledger, own = self._resources.ledger, self._resources.own_draft
        draft, units = ledger.draft(own.name) or {}, ledger.draft(UNITS) or {}
        same_system = units.pop(SYSTEM, self._resources.settings.units) == self._resources.settings.units
        self._units = units if same_system else {}  # those of the settings were chosen later
        self._kept = self._dated = bool(draft)
        started = (ledger.draft(own.started) or {}).get(DATE.name) if draft else None
        day = {DATE.name: started} if started and started != f"{date.today()}" else {}
        waiting = _other_build(draft, planned_answers(ledger))
        return FormStart(draft, self._units, self.offers(draft) | day, self._resources.names(), waiting)

    def offers(self, answers: Mapping[str, str]) -> dict[str, str]:
        """The default answers from the planned flight, or from the last one, given the answers so far."""
        plan = planned_answers(self._resources.ledger)
        flight, offers = Flight(), {DATE.name: TODAY}
        for question in QUESTIONS:
            text = answers.get(question.name)
            if text is None:
                text = offers[question.name] = offer(self._resources.ledger, flight, question, plan)
            try:
                flight = flight.with_changes(**{question.name: read_answer(question.name, text)})
            except BadValue:
                continue
        return offers

    def usual(self, flight: Flight) -> dict[str, float]:
        """The usual readouts of the same rocket on the same motor. [SI]"""
        return usual(self._resources.ledger, self._resources.motors, flight)

    def keep(self, flight: int, answers: Mapping[str, str], units: Mapping[str, str], whole: bool) -> None:
        """Save the draft of the `flight`-th flight: added to that in the ledger, unless the answers are the `whole` of
        it."""
        with self._lock:
            if flight != self.flight:
                return
            ledger, own, self._kept = self._resources.ledger, self._resources.own_draft, False
            before = {} if whole else ledger.draft(own.name) or {}
            ledger.keep_draft(own.name, {**before, **answers})
            self._kept = True
            if not self._dated:
                ledger.keep_draft(own.started, {DATE.name: f"{date.today()}"})
                self._dated = True
            if units != self._units:
                ledger.keep_draft(UNITS, {**units, SYSTEM: self._resources.settings.units})
                self._units = units

    def is_saved(self, typed: Flight) -> bool:
        """Whether the flight being entered is the last one of the ledger: `redo` or another app has saved it."""
        ledger = self._resources.ledger
        last = ledger.latest() if self._kept and ledger.draft(self._resources.own_draft.name) is None else None
        return last is not None and (last.rocket, last.motor, last.readouts()) == (
            typed.rocket,
            typed.motor,
            typed.readouts(),
        )

    def forget(self) -> bool:
        """Discard the draft, which undo restores; False if there is none."""
        with self._lock:
            self.flight, self._dated = self.flight + 1, False
            return self._resources.ledger.drop_draft(self._resources.own_draft.name)

    def save(self, answered: Answered, *, confirmed: bool = False) -> Saved:
        """Save the flight in the ledger if all answers can be read and its motor is known; a duplicate, a name that may
        be misspelled or an implausible apogee must be `confirmed`."""
        for name, why in answered.wrong.items():
            return Saved(wrong=name, trouble=f"{BY_NAME[name].title}: {why}")
        if trouble := self.motor_trouble(answered.flight.motor):
            return Saved(wrong="motor", trouble=trouble)
        try:
            typed = weighed(self._resources.motors, answered.flight, answered.lift_off)
        except FieldkitError as error:
            why = in_system(error, self._resources.settings.units)
            return Saved(wrong=LIFT_OFF_MASS.name, trouble=f"{LIFT_OFF_MASS.title}: {why}")
        if not confirmed and (question := self._question(typed, answered.apogee_unit)):
            return Saved(confirm=question)
        try:
            with self._lock:
                flight, added = enter(self._resources.ledger, typed, self._resources.own_draft.name)
                self.flight, self._dated = self.flight + 1, False
        except FieldkitError as error:
            return Saved(wrong=READOUT_QUESTIONS[0] if typed.rocket else "rocket", trouble=str(error))
        motors = self._resources.motors
        excluded = implausible_flights([flight], motors) + excluded_readouts([flight], motors) if added.new else []
        return Saved(
            added.new[0] if added.new else "",
            flight,
            lacks=lacks(typed),
            taken=taken_in_words(self._resources.settings.flyer.box, flight, self._resources.ledger, motors),
            trouble=in_system(message("; ".join(map(marked, excluded))), self._resources.settings.units),
        )

    def _question(self, flight: Flight, unit: str) -> str:
        """The question about a flight that the ledger has, a name that may be misspelled or an implausible apogee, in
        the `unit` in which it was typed; empty if there is none."""
        if (before := identical_flight(self._resources.ledger, flight)) is not None:
            flight_named = id_and_time(self._resources.ledger, before)
            return f"Flight {flight_named} has the same values, or had when it was entered.\nSave another one like it?"
        named = self._resources.names()
        doubts = [doubt for name in ("rocket", "site", "motor") if (doubt := named.doubt(name, getattr(flight, name)))]
        if flight.date_time is not None and flight.date_time > datetime.now():
            doubts.append(f"{flight.date_time:%Y-%m-%d %H:%M} is in the future.")
        expected = expected_instead(self._resources.ledger, self._resources.motors, flight)
        if expected is not None and flight.apogee is not None:
            system = system_typed(READOUTS[0], unit, self._resources.settings.units)
            doubts.append(apogee_question(expected, flight.apogee, system))
        elif doubts:
            doubts.append("Save it as it is?")
        return "\n".join(doubts)

    def motor_trouble(self, name: str) -> str:
        """Why a motor is unknown; empty if it is known or a cluster, or if none is named."""
        trouble = "" if not name or is_cluster(name) else self._resources.motors.complaint(name)
        return f"Motor: {trouble}" if trouble else ""
