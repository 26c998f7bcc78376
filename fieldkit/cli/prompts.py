"""The questions of `fieldkit add`: one at a time, forward and back; nothing typed is lost."""

from collections.abc import Callable
from dataclasses import dataclass, field

from fieldkit import units
from fieldkit.cli.screen import complain, system
from fieldkit.cli.session import MotorCheck
from fieldkit.errors import BadValue, UnknownMotor
from fieldkit.flight import Flight
from fieldkit.importing.manual_entry import (
    NOT_RECORDED,
    QUESTIONS,
    Question,
    implausible_answers,
    read_answer,
    read_lift_off_mass,
)
from fieldkit.ledger import Ledger
from fieldkit.motors import is_cluster
from fieldkit.quantities import in_system, rounded, spelled
from fieldkit.safe_text import printable
from fieldkit.services import manual_entry

BACK = "<"
"""The answer that returns to the question before."""
WITH_MOTOR = "with motor"
"""The end of an answer that is a mass on the pad."""

ReadAnswer = Callable[[str], str | None]
"""Asks a question and returns the answer; None at the end of the input."""


@dataclass(slots=True)
class Conversation:
    """A conversation: the answers so far, as typed and as a flight. `interactive` means that a person answers, `keeps`
    that the answers are saved as a draft.

    `units` are those typed last, by kind of column. They apply to later numbers only if a person answers, who sees
    them.
    """

    ledger: Ledger
    read_answer: ReadAnswer
    interactive: bool
    motors: MotorCheck
    flight: Flight = field(default_factory=Flight)
    answers: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    keeps: bool = True


def converse(conversation: Conversation) -> bool:
    """Ask everything that is not answered yet; False if the input ends early."""
    place = _caught_up(conversation)
    while place < len(QUESTIONS):
        question = QUESTIONS[place]
        text = conversation.read_answer(_prompt(conversation, question))
        if text is None:
            return False
        if text.strip() == BACK:
            place = max(0, place - 1)
        elif text.strip() == "?":
            _explain(conversation, question)
        elif question.name == "motor" and text.strip().startswith("?"):
            _search(conversation, text.strip()[1:])
        else:
            place += _answered(conversation, question, text)
    return True


def _caught_up(conversation: Conversation) -> int:
    """Copy the answers of a draft; returns the position of the first question without an answer, or with one that
    cannot be read any more."""
    for place, question in enumerate(QUESTIONS):
        text = conversation.answers.get(question.name)
        if text is None:
            return place
        try:
            _take(conversation, question, text)
        except (BadValue, UnknownMotor) as error:  # the motor file may have been removed since
            complain(f"{question.title}: {in_system(error, system())}")
            del conversation.answers[question.name]
            return place
    return len(QUESTIONS)


def offer(conversation: Conversation, question: Question) -> str:
    """The default answer: the one given before, else that of the plan or of the last similar flight."""
    if question.name in conversation.answers:
        return conversation.answers[question.name]
    plan = manual_entry.planned_answers(conversation.ledger)
    return manual_entry.offer(conversation.ledger, conversation.flight, question, plan)


def _prompt(conversation: Conversation, question: Question) -> str:
    offered = offer(conversation, question)
    unit = f" ({spelled(_unit(conversation, question))})" if question.column else ""
    return f"{question.title}{unit}{f' [{printable(offered)}]' if offered else ''}: "


def _unit(conversation: Conversation, question: Question) -> str:
    """The unit of a number typed without one."""
    column = question.column
    if column is None:
        return ""
    return conversation.units.get(manual_entry.kind(column), column.unit) if conversation.interactive else column.unit


def _answered(conversation: Conversation, question: Question, text: str) -> bool:
    """Accept an answer if it can be read and, if it is unusual and a person answers, is confirmed; returns whether it
    was accepted."""
    text = text.strip() or offer(conversation, question)
    while True:
        try:
            text = _without_motor(conversation, question, text)
            _take(conversation, question, text)
        except (BadValue, UnknownMotor) as error:
            complain(f"{question.title}: {in_system(error, system())}")
            return False
        implausible = implausible_answers(
            conversation.flight,
            question.name,
            manual_entry.usual(conversation.ledger, conversation.motors.catalogue, conversation.flight),
        )
        for phrase in implausible:
            complain(f"  unusual: {in_system(phrase, system())}")
        again = (
            conversation.read_answer("  Enter to accept it, or type it again: ")
            if implausible and conversation.interactive
            else ""
        )
        if not again or not again.strip():
            break
        if again.strip() == BACK:
            return False
        text = again.strip()
    conversation.answers[question.name] = _with_unit(conversation, question, text)
    if conversation.keeps:
        conversation.ledger.keep_draft(manual_entry.DRAFT, conversation.answers)
    return True


def _without_motor(conversation: Conversation, question: Question, text: str) -> str:
    """The dry mass of a rocket weighed with its motor, for an answer such as `620g with motor`; any other answer
    unchanged. Raises BadValue."""
    if question.name != "dry_mass" or not text.casefold().endswith(WITH_MOTOR):
        return text
    unit = _unit(conversation, question)
    lift_off = read_lift_off_mass(text[: -len(WITH_MOTOR)], unit)
    mass = manual_entry.weighed(conversation.motors.catalogue, conversation.flight, lift_off).dry_mass
    dry = f"{units.unit('mass', unit).from_si(mass or 0.0):.6g} {unit}"
    complain(f"  {dry} without {conversation.flight.motor}")
    return dry


def _take(conversation: Conversation, question: Question, text: str) -> None:
    """Read an answer into the flight. Raises BadValue or UnknownMotor."""
    if text == NOT_RECORDED:
        text = ""
    if question.name == "rocket" and not text:
        raise BadValue("found nothing, expected the rocket's name")
    if question.name == "motor" and text:
        _look_up(conversation, text)
    value = read_answer(question.name, text, _unit(conversation, question))
    conversation.flight = conversation.flight.with_changes(**{question.name: value})


def _with_unit(conversation: Conversation, question: Question, text: str) -> str:
    """A number with its intended unit, which is remembered for the next one; other text unchanged."""
    column = question.column
    if column is None or text in ("", NOT_RECORDED):
        return text
    unit = conversation.units[manual_entry.kind(column)] = manual_entry.typed_unit(text) or _unit(
        conversation, question
    )
    return manual_entry.with_unit(text, unit)


def _look_up(conversation: Conversation, text: str) -> None:
    if is_cluster(text):
        complain("Motor: several at once; with the tag `cluster` the flight is not used in the model")
        return
    for note in conversation.motors.catalogue.resolve(text).notes:
        complain(f"Motor: {note}")


def _explain(conversation: Conversation, question: Question) -> None:
    """Print the help of a question, and the names in the ledger that answer it."""
    complain(question.help)
    if question.name == "dry_mass":
        complain(f"  or weighed ready to fly: 620g {WITH_MOTOR}")
    if question.name in ("rocket", "config", "motor", "site"):
        rocket = None if question.name in ("rocket", "site") else conversation.flight.rocket
        if known := conversation.ledger.names(question.name, rocket):
            complain(f"  so far {', '.join(known)}")


def _search(conversation: Conversation, text: str) -> None:
    found = conversation.motors.catalogue.search(text)
    for motor in found[:10]:
        size = f"{motor.diameter * 1e3:g} mm, {rounded(motor.total_impulse)} N s"
        complain(f"  {motor.maker} {motor.designation}, {size}")
    if len(found) > 10:
        complain(f"  and {len(found) - 10} more")
