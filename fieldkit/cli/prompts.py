"""The conversation of `fieldkit add`: a question at a time, forwards and back, nothing typed is lost."""

from collections.abc import Callable
from dataclasses import dataclass, field

from fieldkit.cli.screen import complain
from fieldkit.cli.session import MotorCheck
from fieldkit.errors import BadValue, UnknownMotor
from fieldkit.flight import Flight
from fieldkit.importing.manual_entry import NOT_RECORDED, QUESTIONS, Question, implausible_answers, read_answer
from fieldkit.ledger import Ledger
from fieldkit.quantities import spelled
from fieldkit.safe_text import printable
from fieldkit.services import manual_entry

BACK = "<"

Listen = Callable[[str], str | None]
"""Asks and returns the answer; None when no more will come."""


@dataclass(slots=True)
class Conversation:
    """A conversation: what was answered, as typed and as a flight; `patient` is one with a person.

    `units` are those typed last, by kind of column; only a person, who sees them, is held to them.
    """

    ledger: Ledger
    listen: Listen
    patient: bool
    motors: MotorCheck
    flight: Flight = field(default_factory=Flight)
    answers: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    keeps: bool = True


def converse(talk: Conversation) -> bool:
    """Ask all that is not answered yet; False when the answers ended early."""
    place = _caught_up(talk)
    while place < len(QUESTIONS):
        question = QUESTIONS[place]
        text = talk.listen(_prompt(talk, question))
        if text is None:
            return False
        if text.strip() == BACK:
            place = max(0, place - 1)
        elif text.strip() == "?":
            _explain(talk, question)
        elif question.name == "motor" and text.strip().startswith("?"):
            _search(talk, text.strip()[1:])
        else:
            place += _answered(talk, question, text)
    return True


def _caught_up(talk: Conversation) -> int:
    """Take the answers that a draft holds; the place of the first question that it leaves open."""
    for place, question in enumerate(QUESTIONS):
        text = talk.answers.get(question.name)
        if text is None:
            return place
        try:
            _take(talk, question, text)
        except (BadValue, UnknownMotor) as error:  # a motor file may be gone since
            complain(f"{question.title}: {error}")
            del talk.answers[question.name]
            return place
    return len(QUESTIONS)


def offer(talk: Conversation, question: Question) -> str:
    """What Enter takes: the answer given before, or the one of the last flight like this."""
    if question.name in talk.answers:
        return talk.answers[question.name]
    return manual_entry.offer(talk.ledger, talk.flight, question)


def _prompt(talk: Conversation, question: Question) -> str:
    offered = offer(talk, question)
    unit = f" ({spelled(_unit(talk, question))})" if question.column else ""
    return f"{question.title}{unit}{f' [{printable(offered)}]' if offered else ''}: "


def _unit(talk: Conversation, question: Question) -> str:
    """The unit of a number typed without one."""
    column = question.column
    if column is None:
        return ""
    return talk.units.get(manual_entry.kind(column), column.unit) if talk.patient else column.unit


def _answered(talk: Conversation, question: Question, text: str) -> bool:
    """Take an answer if it can be read and, where it is odd, is kept on being asked."""
    text = text.strip() or offer(talk, question)
    while True:
        try:
            _take(talk, question, text)
        except (BadValue, UnknownMotor) as error:
            complain(f"{question.title}: {error}")
            return False
        odd = implausible_answers(talk.flight, question.name, manual_entry.usual(talk.ledger, talk.flight))
        for phrase in odd:
            complain(f"  odd: {phrase}")
        again = talk.listen("  Enter keeps it, or type it again: ") if odd and talk.patient else ""
        if not again or not again.strip():
            break
        if again.strip() == BACK:
            return False
        text = again.strip()
    talk.answers[question.name] = _with_unit(talk, question, text)
    if talk.keeps:
        talk.ledger.keep_draft(manual_entry.DRAFT, talk.answers)
    return True


def _take(talk: Conversation, question: Question, text: str) -> None:
    """Read an answer into the flight. Raises BadValue or UnknownMotor."""
    if text == NOT_RECORDED:
        text = ""
    if question.name == "rocket" and not text:
        raise BadValue("found nothing, expected the rocket's name")
    if question.name == "motor" and text:
        _look_up(talk, text)
    value = read_answer(question.name, text, _unit(talk, question))
    talk.flight = talk.flight.with_changes(**{question.name: value})


def _with_unit(talk: Conversation, question: Question, text: str) -> str:
    """A number with the unit it was meant in, which is remembered for the next; another text as it is."""
    column = question.column
    if column is None or text in ("", NOT_RECORDED):
        return text
    unit = talk.units[manual_entry.kind(column)] = manual_entry.typed_unit(text) or _unit(talk, question)
    return manual_entry.with_unit(text, unit)


def _look_up(talk: Conversation, text: str) -> None:
    if _several(text):
        complain("Motor: several at once; the tag `cluster` keeps the flight from teaching the model")
        return
    for note in talk.motors.catalogue.resolve(text).notes:
        complain(f"Motor: {note}")


def _several(motor: str) -> bool:
    from fieldkit.motors import is_cluster

    return is_cluster(motor)


def _explain(talk: Conversation, question: Question) -> None:
    """What a question is about, and what was answered to it so far."""
    complain(question.help)
    if question.name in ("rocket", "config", "motor", "site"):
        rocket = None if question.name in ("rocket", "site") else talk.flight.rocket
        if known := talk.ledger.names(question.name, rocket):
            complain(f"  so far {', '.join(known)}")


def _search(talk: Conversation, text: str) -> None:
    found = talk.motors.catalogue.search(text)
    for motor in found[:10]:
        size = f"{motor.diameter * 1e3:g} mm, {motor.total_impulse:.4g} N s"
        complain(f"  {motor.maker} {motor.designation}, {size}")
    if len(found) > 10:
        complain(f"  and {len(found) - 10} more")
