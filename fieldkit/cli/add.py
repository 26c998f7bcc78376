"""`fieldkit add`: enter a flight, by answering questions or with options."""

import contextlib
import sys
from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit import settings
from fieldkit.cli.options import takes_flight
from fieldkit.cli.predictions import print_outcome
from fieldkit.cli.screen import complain, print_card, remark, system
from fieldkit.cli.session import LIFT_OFF, MotorCheck, dry_mass, note_dry_mass, open_ledger, read_settings
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.plausibility import doubts
from fieldkit.flight.short_name import flight_label
from fieldkit.quantities import in_system
from fieldkit.services.names import same_name

if TYPE_CHECKING:
    from fieldkit.cli.prompts import Conversation
    from fieldkit.ledger import Ledger

app = typer.Typer()

PANEL = "The flight; a number may have a unit, as in 923ft"
"""Heading of the flight's options in the command's help."""


def add(
    context: typer.Context,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an unfinished flight, without asking.")] = False,
    again: Annotated[
        bool, typer.Option("--again", help="Add the flight even if the ledger has one with the same values.")
    ] = False,
    **given: str | None,
) -> None:
    """Enter a flight by hand. Enter accepts the default, < goes back, ? shows help, - means "not recorded".

    With any flight option nothing is asked; dry mass and diameter are by default those of the plan, of the last flight
    of this build, of an earlier plan or design, or of the rocket's kit.
    Without a terminal, answers are read from standard input, one per line.
    """
    from fieldkit.services.unknown_names import unknown_names

    changes = {name: text for name, text in given.items() if text is not None}
    with open_ledger(context) as ledger:
        if changes:
            if changes.get("rocket"):
                changes["rocket"] = same_name(changes["rocket"], ledger.names("rocket"))
            flight = _from_options(changes)
            for phrase in unknown_names(ledger, flight, given, new=True):
                complain(f"note: {phrase}")
            flight, filled = _as_built(ledger, flight, changes)
            _doubt(ledger, flight)
            _add(ledger, flight, filled, None, again=again)
        else:
            _add(ledger, *_from_answers(ledger, resume=resume), again=again)


takes_flight(add, PANEL)
app.command()(add)


def _from_options(changes: dict[str, str]) -> "Flight":
    from fieldkit.motors.several import tagged

    flight = Flight().with_changes(**read_settings(changes, MotorCheck()))
    if not flight.rocket:
        raise BadValue("rocket: found nothing, expected the rocket's name")
    if LIFT_OFF in changes:
        note_dry_mass(flight)
    return tagged(flight)


def _as_built(ledger: "Ledger", flight: "Flight", given: Collection[str]) -> "tuple[Flight, Collection[str]]":
    """A flight with what is known of its build if that is not given, which is printed, and the names of mass and
    diameter if they were filled in."""
    from fieldkit.services.manual_entry import as_built

    flight, notes = as_built(ledger, flight, given)
    for note in notes:
        options = " and ".join(f"--{one.replace('_', '-')}" for one in note.columns)
        complain(f"note: {in_system(note.text, system())}; change with {options}")
    return flight, [one for note in notes for one in note.columns if one != "config"]


def _doubt(ledger: "Ledger", flight: "Flight") -> None:
    """Print what looks mistyped; the flight is saved anyway."""
    from fieldkit.services.manual_entry import usual

    for phrase in doubts(flight, usual(ledger, MotorCheck().catalogue, flight)):
        remark(phrase)


def _from_answers(ledger: "Ledger", *, resume: bool) -> "tuple[Flight, Collection[str], str | None]":
    """Ask for a flight, or continue with one; returns the flight, the names of what was filled in, and the name of the
    draft that it completes, None if that is continued later.

    Exits with 1 if the user stops halfway; the draft is retained.
    """
    from fieldkit.cli.prompts import Conversation, converse
    from fieldkit.importing.manual_entry import LIFT_OFF_MASS
    from fieldkit.services.manual_entry import DRAFT, UNITS, with_offers

    interactive = sys.stdin.isatty()
    conversation = Conversation(ledger, _ask_in_terminal if interactive else _read_from_pipe, interactive, MotorCheck())
    _resume_draft(conversation, ledger.draft(DRAFT), resume=resume)
    conversation.units |= (ledger.draft(UNITS) or {}) if interactive else {}
    before = dict(conversation.units)
    finished = converse(conversation)
    if interactive and conversation.units != before:
        ledger.keep_draft(UNITS, conversation.units)
    if not finished and interactive:
        complain("Saved as a draft; run `fieldkit add` to continue it")
        raise typer.Exit(1)
    flight, filled = with_offers(ledger, conversation.flight, conversation.answers)
    if typed := conversation.answers.get(LIFT_OFF_MASS.name):  # in the draft of the app
        flight = flight.with_changes(dry_mass=dry_mass(conversation.motors.catalogue, flight, typed))
        note_dry_mass(flight)
    return flight, filled, DRAFT if conversation.keeps else None


def _resume_draft(conversation: "Conversation", draft: dict[str, str] | None, *, resume: bool) -> None:
    """Continue a draft if the user wants to; without a terminal it is continued only on request. Exits with 1 if the
    input ends."""
    if not draft:
        return
    named = ", ".join(f"{name} {text}" for name, text in draft.items() if text)
    if resume:
        conversation.answers |= draft
    elif conversation.interactive:
        answer = conversation.read_answer(f"A flight is unfinished ({named}). Continue it? [Y/n]: ")
        if answer is None:
            raise typer.Exit(1)
        if not answer.strip().lower().startswith("n"):
            conversation.answers |= draft
    else:
        complain(f"note: a flight is unfinished ({named}); run `fieldkit add --resume` to continue it")
        conversation.keeps = False


def _ask_in_terminal(prompt: str) -> str | None:
    """The answer to a prompt; None at the end of the input or after Ctrl-C."""
    with contextlib.suppress(ImportError):
        import readline  # noqa: F401  # arrow keys while typing

    try:
        return input(prompt)
    except (EOFError, KeyboardInterrupt):
        typer.echo(err=True)
        return None


def _read_from_pipe(_prompt: str) -> str | None:
    """The next line of the input; None at its end."""
    return sys.stdin.readline() or None


def _add(ledger: "Ledger", flight: "Flight", filled: Collection[str], draft: str | None, *, again: bool) -> None:
    """Save a flight in the ledger and print it; that it is saved is reported even if the rest cannot be printed.

    Raises BadValue for a flight that the ledger probably has already, unless it is to be added `again`.
    """
    from fieldkit.services.manual_entry import enter, id_and_time, identical_flight

    if not again and (before := identical_flight(ledger, flight, filled)) is not None:
        raise BadValue(
            f"flight {id_and_time(ledger, before)} has the same values, or had them when it was entered; "
            "nothing was saved; --again saves another one like it"
        )
    if flight.motor and (doubt := MotorCheck().catalogue.doubt(flight.motor)):
        complain(f"note: {doubt}")
    flight, added = enter(ledger, flight, draft)
    if added.duplicates:
        complain("Duplicate: it is already in the ledger")
        return
    try:
        _print(ledger, flight, added.new[0])
    finally:
        complain(f"Saved {flight_label(added.new[0])}. `fieldkit undo` to undo.")
    if box := settings.read_settings().flyer.box:
        from fieldkit.services.range_box import taken_in_words

        if taken := taken_in_words(box, flight, ledger, MotorCheck().catalogue):
            complain(taken)


def _print(ledger: "Ledger", flight: "Flight", id: str) -> None:
    """Print a new flight, its forecast, and remarks on it."""
    from fieldkit.services.plausible_flights import exclusions

    print_card(flight, id)
    ledger.remark(*exclusions([flight], MotorCheck().catalogue))  # before those of other flights
    print_outcome(ledger, flight)
