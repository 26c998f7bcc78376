"""A flight being entered, at a prompt or on a screen: default answers, units, and saving."""

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from types import MappingProxyType
from typing import Any

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, Column, Flight
from fieldkit.flight.limits import check
from fieldkit.flight.plausibility import middles
from fieldkit.forecast.conformal import are_numbers
from fieldkit.importing.manual_entry import NOT_RECORDED, QUESTIONS, Question, answer_text, read_answer
from fieldkit.ledger import Added, Ledger, StoredPrediction
from fieldkit.messages import message, of_column
from fieldkit.motors import Catalogue, Motor, is_cluster
from fieldkit.motors.motor import without_motor
from fieldkit.motors.names import parse, with_delay
from fieldkit.motors.several import tag_of_several
from fieldkit.services.day_weather import typed_weather
from fieldkit.services.plans import BODY, body
from fieldkit.services.plausible_flights import credible, motor_type
from fieldkit.services.provenance import is_made_from, is_texts
from fieldkit.services.sites import site_of

WEATHER = ("wind", "temperature")
"""Questions about the day."""
DRAFT = "add"
UNITS = "units"
STARTED_DRAFT = "add started"
"""Names under which the ledger saves the draft, the units that were typed last, and the day on which the draft was
started."""
PLAN = "plan"
"""Key under which a saved forecast holds the answers of the planned flight."""
FLOWN_BEFORE = "flown_before"
"""Key of the flights with readouts that a saved forecast did not use, such as those without a mass."""
LAPSES = timedelta(days=14)
"""A forecast without a flight's name is for a flight at most this much later."""
RETRY_PERIOD = timedelta(days=1)
"""Longest time between an entry and one that repeats it without saying when it was flown."""
CONFIGURATION = ("motor", "dry_mass", "diameter")
"""Questions about the planned configuration."""


def kind(column: Column) -> str:
    """Name of the group of columns that are probably typed in the same unit: all heights, but not a height and a
    diameter."""
    return f"{column.quantity} {column.unit}"


def typed_unit(text: str) -> str:
    """The unit after a number, empty if there is none: `ft` of `923 ft`."""
    return units.typed_unit(text, "") or text.strip().lstrip("+-.,/0123456789eE½¼¾⅛⅜⅝⅞ ")


def typed_number(text: str) -> str:
    """The number without its unit; all of a number in two units: `923` of `923 ft`, but `12'6"`."""
    return text.strip().removesuffix(typed_unit(text)).strip()


def with_unit(text: str, unit: str) -> str:
    """A typed number with its intended unit; a text that has a unit, or is not a number, unchanged."""
    return text if text in ("", NOT_RECORDED) or typed_unit(text) else text + unit


def setup_answers(plan: Flight) -> dict[str, str]:
    """A planned flight as default answers of the form; the delay follows the motor."""
    texts = {question.name: answer_text(plan, question.name) for question in QUESTIONS if question.offered}
    if plan.motor and plan.delay is not None:
        texts["motor"] = _delayed(plan.motor, plan.delay)
    return {name: text for name, text in texts.items() if text}


def _delayed(motor: str, delay: float) -> str:
    """A motor's name with a delay [s] that it does not have yet; a cluster with delays of its own is unchanged."""
    if is_cluster(motor):
        return motor if "-" in motor else f"{motor}-{delay:g}"
    return motor if parse(motor).delay == delay else with_delay(motor, delay)


def lapsed(prediction: StoredPrediction) -> bool:
    """Whether no flight will be compared with a forecast anymore: it names none and is older than two weeks."""
    return not prediction.flight_id and datetime.now(UTC) - prediction.at > LAPSES


def saved_forecasts(ledger: Ledger, rocket: str | None = None) -> list[StoredPrediction]:
    """The saved forecasts of one rocket or of all, oldest first: without results of replayed ones, and without what
    another program saved in a form that this one cannot read."""
    return [one for one in ledger.predictions(rocket) if _is_forecast(one.payload)]


def _is_forecast(saved: Mapping[str, Any]) -> bool:
    apogee, likely, before = saved.get("apogee_m"), saved.get("likely_m"), saved.get(FLOWN_BEFORE, [])
    if not isinstance(apogee, Mapping) or not are_numbers([apogee.get(at) for at in ("p05", "p50", "p95")], 3):
        return False
    if not all(isinstance(saved.get(name, ""), str) for name in ("rocket", "config", "motor", "model")):
        return False
    return (
        ("likely_m" not in saved or (isinstance(likely, list) and len(likely) > 1 and are_numbers(likely, len(likely))))
        and ("made_from" not in saved or is_made_from(saved["made_from"]))
        and is_texts(saved.get(PLAN, {}))
        and isinstance(before, list)
        and all(isinstance(id, str) for id in before)
    )


def waiting_plan(ledger: Ledger) -> StoredPrediction | None:
    """The latest saved forecast of a planned flight whose rocket has not flown since; none older than two weeks."""
    kept = [one for one in saved_forecasts(ledger) if PLAN in one.payload and not lapsed(one)]
    flown: dict[str, set[str]] = {}
    for one in reversed(kept):
        if one.rocket not in flown:
            flown[one.rocket] = {flight.flight_id for flight in ledger.flights(one.rocket) if flight.readouts()}
        before = {*one.payload.get("made_from", {}).get("flights", {}), *one.payload.get(FLOWN_BEFORE, ())}
        if flown[one.rocket] <= before:
            return one
    return None


def planned_answers(ledger: Ledger) -> dict[str, str]:
    """The answers of the planned flight that waits; empty if none does."""
    waiting = waiting_plan(ledger)
    return {} if waiting is None else dict(waiting.payload[PLAN])


def offer(ledger: Ledger, flight: Flight, question: Question, plan: Mapping[str, str] = MappingProxyType({})) -> str:
    """The default answer from the planned flight (see `planned_answers`) or from the last similar flight, as text to
    edit."""
    if question.name == "tags":
        return tag_of_several(flight.motor)
    if not question.offered:
        return ""
    if question.name in plan and _is_planned(flight, question, plan):
        return plan[question.name]
    if question.name in WEATHER:
        return _weather(ledger, question.name)
    rocket = None if question.name == "rocket" else flight.rocket
    if question.name in BODY:
        with suppress(BadValue):  # a damaged file of kits is reported where they are listed
            known = body(flight, ledger.flights(flight.rocket), ledger.rocket(flight.rocket))
            return answer_text(Flight().with_defaults(**known), question.name)
        return ""
    last = ledger.latest(rocket)
    if last is None and question.name == "site":
        last = ledger.latest()
    return answer_text(last, question.name) if last else ""


def _is_planned(flight: Flight, question: Question, plan: Mapping[str, str]) -> bool:
    """Whether the answers so far agree with the plan."""
    if question.name == "rocket":
        return True
    same = question.name not in CONFIGURATION or flight.config == plan.get("config", "")
    return flight.rocket == plan.get("rocket", "") and same


def _weather(ledger: Ledger, name: str) -> str:
    """The weather entered for the day, or that of the day's last flight, whichever is newer."""
    last = ledger.latest()
    flown = last.date_time.replace(tzinfo=None) if last is not None and last.date_time is not None else None
    typed, at = typed_weather(ledger)
    if at is not None and name in typed and (flown is None or flown < at):
        return typed[name]
    same_day = flown is not None and flown.date() == datetime.now().date()
    return answer_text(last, name) if last is not None and same_day else typed.get(name, "")


def with_offers(ledger: Ledger, flight: Flight, answered: Collection[str]) -> tuple[Flight, tuple[str, ...]]:
    """A flight with the default answers for the questions that were not answered, and the names of those filled in.
    Raises BadValue for a saved answer that cannot be read.
    """
    plan, filled = planned_answers(ledger), list[str]()
    for question in QUESTIONS:
        if question.offered and question.name not in answered and flight.rocket:
            value = read_answer(question.name, offer(ledger, flight, question, plan))
            flight, filled = flight.with_changes(**{question.name: value}), [*filled, question.name]
    return flight, tuple(filled)


def with_only_config(ledger: Ledger, flight: Flight, answered: Collection[str]) -> tuple[Flight, str]:
    """A flight in the only configuration that its rocket is known in, unless it was answered, and a note on that; with
    several, the flight as it is and a note that names them."""
    if flight.config or "config" in answered or not flight.rocket:
        return flight, ""
    rocket = ledger.rocket(flight.rocket)
    known = {one.config for one in ledger.flights(flight.rocket)} | {one.config for one in rocket.configurations}
    named = sorted(known - {""})
    if not named or "" in known:
        return flight, ""
    if len(named) > 1:
        return flight, f"no configuration of {flight.rocket}, which has flown as {', '.join(named)}"
    return flight.with_changes(config=named[0]), f"configuration {named[0]}, the only one of {flight.rocket}"


def with_build(ledger: Ledger, flight: Flight, answered: Collection[str]) -> tuple[Flight, tuple[str, ...]]:
    """A flight with the dry mass and diameter of its planned flight or of its configuration, as in `plans.body`, unless
    they were answered; and the names of those filled in. Raises BadValue for a saved answer that cannot be
    read.
    """
    plan, filled = planned_answers(ledger), list[str]()
    for question in QUESTIONS:
        if question.name in BODY and question.name not in answered and flight.number(question.name) is None:
            value = read_answer(question.name, offer(ledger, flight, question, plan))
            if value is not None:
                flight, filled = flight.with_changes(**{question.name: value}), [*filled, question.name]
    return flight, tuple(filled)


@dataclass(frozen=True, slots=True)
class BuildNote:
    """What was filled in about a flight's build, or what is missing, and the columns that change it."""

    text: str
    columns: tuple[str, ...]


def as_built(ledger: Ledger, flight: Flight, answered: Collection[str]) -> tuple[Flight, list[BuildNote]]:
    """A flight in its rocket's only configuration, with the dry mass and diameter that are known of its build, unless
    they were answered, and notes on that. Raises BadValue for a saved answer that cannot be read."""
    flight, named = with_only_config(ledger, flight, answered)
    flight, filled = with_build(ledger, flight, answered)
    notes = [BuildNote(named, ("config",))] if named else []
    if filled:
        known = [(BY_NAME[one], value) for one in filled if (value := flight.number(one)) is not None]
        values = [f"{column.title.lower()} {of_column(column, value)}" for column, value in known]
        notes.append(BuildNote(message(f"filled in {', '.join(values)}"), filled))
    return flight, notes


def usual(ledger: Ledger, motors: Catalogue, flight: Flight) -> dict[str, float]:
    """The medians of the readouts of the same rocket on the same motor, any delay, without implausible flights; none if
    rocket or motor is missing. [SI]"""
    if not (flight.rocket and flight.motor):
        return {}
    types = {name: motor_type(name, motors) for name in {flight.motor, *ledger.names("motor", flight.rocket)}}
    same = [one for one in ledger.flights(flight.rocket) if types.get(one.motor) == types[flight.motor]]
    return middles(credible(same, motors))


def weighed(motors: Catalogue, flight: Flight, lift_off: float | None) -> Flight:
    """A flight with the dry mass that follows from its mass on the pad with its motor or cluster [kg]; unchanged
    without one.

    Raises BadValue for an impossible mass, and for one without a motor; UnknownMotor.
    """
    if lift_off is None:
        return flight
    if not flight.motor:
        raise BadValue("found a lift-off mass and no motor, expected both: the dry mass is the difference")
    return flight.with_changes(dry_mass=dry_mass_under(lift_off, motors.resolve_several(flight.motor).motor))


def dry_mass_under(lift_off: float, motor: Motor) -> float:
    """The dry mass, given the mass on the pad with a motor [kg]. Raises BadValue for an impossible one. [kg]"""
    return check(BY_NAME["dry_mass"], without_motor(lift_off, motor))


def identical_flight(ledger: Ledger, flight: Flight, filled: Collection[str] = ()) -> Flight | None:
    """The flight of a ledger that a typed one without a number repeats; None if there is none.

    Everything but the number is equal to the flight as it is now or as it was entered, before any edit; what fieldkit
    itself `filled` in may differ, because it follows the last flight. A typed flight without a time can repeat only one
    of the last day. That is probably one entry made twice, but two flights may really read the same, so the flyer
    decides.
    """
    if flight.flight_id or not (flight.rocket and (flight.readouts() or flight.tags)):
        return None
    typed, free = _as_typed(ledger, flight), {"flight_id", *filled}
    if flight.site_elevation is None:
        free.add("site_elevation")
    if flight.date_time is None:
        free.add("date_time")
    for now, form in ledger.forms(flight.rocket):
        is_then = flight.date_time is not None or _is_of_last_day(form)
        if is_then and form == typed.with_changes(**{name: getattr(form, name) for name in free}):
            return now
    return None


def id_and_time(ledger: Ledger, flight: Flight) -> str:
    """The id of a flight of a ledger, and when it was flown if that is recorded: `7 of 2026-05-01 10:30`."""
    (id,) = ledger.ids([flight])
    return id if flight.date_time is None else f"{id} of {flight.date_time:%Y-%m-%d %H:%M}"


def _is_of_last_day(flight: Flight) -> bool:
    """Whether a flight was flown, or entered without a time, in the last day; a retry may come after midnight."""
    flown = flight.date_time
    return flown is not None and abs(datetime.now(flown.tzinfo) - flown) <= RETRY_PERIOD


def enter(ledger: Ledger, flight: Flight, draft: str | None = None) -> tuple[Flight, Added]:
    """Give a typed flight a number, a time and its site's elevation if it has none, and add it to the ledger.

    Its readouts have the source "typed".

    Raises BadValue for a flight without a rocket or without any readout or tag.
    """
    if not flight.rocket:
        raise BadValue("input ended before the rocket was named; nothing was saved")
    if not (flight.readouts() or flight.tags):
        raise BadValue("found no readout and no tag, expected at least one; nothing was saved")
    flight = _as_typed(ledger, flight).with_changes(
        flight_id=flight.flight_id or ledger.next_flight_id(flight.rocket),
        date_time=flight.date_time or datetime.now().replace(second=0, microsecond=0),
    )
    added = ledger.add([flight], command="add", draft=draft)
    if added.conflicts:
        raise BadValue(added.conflicts[0].error)
    return flight, added


def _as_typed(ledger: Ledger, flight: Flight) -> Flight:
    """A typed flight with its site's elevation if it has none, and the source of its readouts."""
    if flight.site and flight.site_elevation is None:
        flight = flight.with_changes(site_elevation=site_of(ledger, flight.site).elevation)
    return flight.with_source(flight.readouts(), "typed")
