"""The flights that fits may use, each with its motor, and notes on the others."""

import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from itertools import islice

from fieldkit.errors import UnknownMotor
from fieldkit.flight import BY_NAME, CHECKED_TAG, Flight
from fieldkit.flight.plausibility import far_from_usual, implausible, middles, not_measured
from fieldkit.flight.short_name import flight_label
from fieldkit.messages import marked, message
from fieldkit.motors import Catalogue, Found, is_cluster
from fieldkit.motors.names import tidy
from fieldkit.quantities import counted

MIN_COMPARED = 3
"""Minimum number of flights for a median that shows outliers. [1]"""
MAX_FITTED_FLIGHTS = 40
"""Maximum number of a rocket's flights that fits use: the mean apogee of 40 on one motor is known to a sixth of their
scatter, and what more flights could add is what every forecast says after "narrows by". The work grows with the square
of the number. [1]"""
MAX_LATEST_FLIGHTS = 30
"""How many of these are the latest; the others are of motors and configurations that these have least of. [1]"""
MAX_EXCLUDED = 20
"""Number of notes of one kind on what is excluded from fits; the others are counted. [1]"""
MAX_NAMED_FLIGHTS = 5
"""Number of flights that a note names; it counts the others. [1]"""
JudgedFlight = tuple[Flight, Found, str | None]
"""A flight, its motor, and the reason why it is implausible, or None."""


def followed(flights: Sequence[Flight], motors: Catalogue) -> list[tuple[Flight, Found]]:
    """The flights of each rocket that fits use, each with its motor, in the given order: those that can be simulated,
    and of a rocket with more than `MAX_FITTED_FLIGHTS` the most informative ones."""
    by_rocket: dict[str, list[tuple[int, Flight, Found]]] = {}
    for row, (flight, found) in reversed(list(enumerate(_with_motors(flights, motors)))):
        if found:
            by_rocket.setdefault(flight.rocket, []).append((row, flight, found))
    kept = sorted(
        (one for latest_first in by_rocket.values() for one in _most_informative(latest_first)), key=lambda one: one[0]
    )
    return [(flight, found) for _, flight, found in kept]


def _most_informative(latest_first: Sequence[tuple[int, Flight, Found]]) -> Iterator[tuple[int, Flight, Found]]:
    """The most informative flights of one rocket, at most `MAX_FITTED_FLIGHTS`.

    The latest come first, because rockets change. Of the older ones, each in turn is the latest normal flight of the
    motor and configuration of which fewest are chosen. Derivation: with n flights, the variance of what a motor or
    configuration has of its own is 1 / (1/T^2 + n/S^2), for a prior variance of T^2 and a scatter of S: it is reduced
    most where n is least.
    """
    left = (one for one in latest_first if not implausible(one[1], one[2].motor))
    count: Counter[tuple[str, ...]] = Counter()
    for one in islice(left, MAX_LATEST_FLIGHTS):
        count[_setup(one)] += 1
        yield one
    older: dict[tuple[str, ...], list[tuple[int, Flight, Found]]] = {}
    for one in left:
        if one[1].clean and one[1].readouts():
            older.setdefault(_setup(one), []).append(one)
    for _ in range(MAX_FITTED_FLIGHTS - MAX_LATEST_FLIGHTS):
        if setup := min(filter(older.get, older), key=lambda one: (count[one], -older[one][0][0]), default=None):
            count[setup] += 1
            yield older[setup].pop(0)


def _setup(one: tuple[int, Flight, Found]) -> tuple[str, ...]:
    """The configuration and motor type of a flight."""
    _, flight, found = one
    return flight.config, found.motor.maker, found.motor.designation


def simulable(flights: Sequence[Flight], motors: Catalogue) -> list[tuple[Flight, Found]]:
    """All flights that can be simulated, each with its motor."""
    known = ((flight, found) for flight, found in _with_motors(flights, motors) if found)
    return [(flight, found) for flight, found in known if not implausible(flight, found.motor)]


def plausible(flights: Sequence[Flight], motors: Catalogue) -> list[Flight]:
    """The flights whose setup a plan can start from, whatever their readouts; clusters are not checked."""
    return [
        flight
        for flight, found in _with_motors(flights, motors)
        if flight.dry_mass is not None and not (found and implausible(flight.unflown(), found.motor))
    ]


def credible(flights: Sequence[Flight], motors: Catalogue) -> list[Flight]:
    """The flights that are not implausible, also those without the dry mass or known motor that a check needs."""
    known = _with_motors(flights, motors)
    return [flight for flight, found in known if not (found and implausible(flight, found.motor))]


def implausible_flights(flights: Sequence[Flight], motors: Catalogue) -> list[str]:
    """A line for each clean flight that is implausible and therefore not used in a fit."""
    return _implausible_flights(_judged(flights, motors))


def _judged(flights: Sequence[Flight], motors: Catalogue) -> list[JudgedFlight]:
    """The flights with a dry mass and a known motor, each with the reason why it is implausible, or None."""
    known = ((flight, found) for flight, found in _with_motors(flights, motors) if found)
    return [(flight, found, implausible(flight, found.motor)) for flight, found in known]


def _implausible_flights(judged: Sequence[JudgedFlight]) -> list[str]:
    return [
        message(f"{flight_label(flight.flight_id)} of {flight.rocket} is excluded from every fit: {marked(reason)}")
        for flight, _, reason in judged
        if reason and flight.clean
    ]


def exclusions(flights: Sequence[Flight], motors: Catalogue) -> list[str]:
    """Notes on what is excluded from every fit: a line for each implausible flight, one for each figure that flights of
    a rocket lack, one for each readout that cannot be a measurement, at most `MAX_EXCLUDED` of each, and one for a
    rocket with too many flights. Only clean flights are considered."""
    judged = _judged(flights, motors)
    return [
        *_older_flights(judged),
        *_first(_implausible_flights(judged)),
        *incomplete_flights(flights, motors),
        *_first(_excluded_readouts(judged)),
    ]


def _first(lines: Sequence[str]) -> list[str]:
    """The first of many notes, and how many more there are."""
    more = len(lines) - MAX_EXCLUDED
    return [*lines[:MAX_EXCLUDED], *([f"and {counted(more, 'more note')} like these"] if more > 0 else [])]


def _older_flights(judged: Sequence[JudgedFlight]) -> list[str]:
    """A line for each rocket with more flights than fits use."""
    known = Counter(flight.rocket for flight, _, reason in judged if not reason)
    return [
        f"{rocket}: fits use {MAX_FITTED_FLIGHTS} of its {count} flights: the latest {MAX_LATEST_FLIGHTS}, and of "
        "those before them the latest on motors and in configurations with fewest flights"
        for rocket, count in known.items()
        if count > MAX_FITTED_FLIGHTS
    ]


def excluded_readouts(flights: Sequence[Flight], motors: Catalogue) -> list[str]:
    """Lines on the readouts of clean flights that cannot be measurements and are therefore not used in a fit; none on
    flights that are tagged `checked`."""
    return _excluded_readouts(_judged(flights, motors))


def _excluded_readouts(judged: Sequence[JudgedFlight]) -> list[str]:
    return [
        message(f"{flight_label(flight.flight_id)} of {flight.rocket}: {marked(line)}")
        for flight, found, reason in judged
        if flight.clean and CHECKED_TAG not in flight.tags and not reason
        for line in readout_exclusions(flight, found)
    ]


def readout_exclusions(flight: Flight, found: Found) -> list[str]:
    """A phrase for each reason to exclude readouts of a flight on its motor from every fit."""
    titles: dict[str, list[str]] = {}
    for name, reason in not_measured(flight, found.motor).items():
        titles.setdefault(reason, []).append(BY_NAME[name].title.lower())
    return [
        message(f"{' and '.join(own)} {'is' if len(own) == 1 else 'are'} excluded from every fit: {marked(reason)}")
        for reason, own in titles.items()
    ]


def incomplete_flights(flights: Sequence[Flight], motors: Catalogue) -> list[str]:
    """A line for each rocket and what its clean flights with readouts lack, so that they are excluded from every
    fit: the dry mass, or a known motor."""
    lacking: dict[tuple[str, str], list[str]] = {}
    known: dict[str, Found | None] = {}
    for flight in flights:
        if not (flight.clean and flight.readouts()) or is_cluster(flight.motor):
            continue
        if flight.motor not in known:
            known[flight.motor] = _resolved(flight.motor, motors)
        if reason := _lacks(flight, known[flight.motor]):
            lacking.setdefault((flight.rocket, reason), []).append(flight.flight_id)
    return [
        f"{rocket + ': ' if rocket else ''}{named_flights(ids)} {'is' if len(ids) == 1 else 'are'} excluded from "
        f"every fit: {reason}; edit to add {'it' if reason.count('no ') == 1 else 'them'}"
        for (rocket, reason), ids in lacking.items()
    ]


def _lacks(flight: Flight, found: Found | None) -> str:
    """What a flight on a motor lacks that every fit needs: `no rocket, no motor, no dry mass`; empty if nothing."""
    motor = "no known motor" if flight.motor else "no motor"
    needed: dict[str, object] = {motor: found, "no dry mass": flight.dry_mass}
    lacking = [name for name, value in needed.items() if value is None]
    return ", ".join(["no rocket"] * bool(lacking and not flight.rocket) + lacking)


def exclusion(flight: Flight, motors: Catalogue) -> str:
    """Why a clean flight is excluded from every fit; empty if it is used."""
    if not flight.readouts():
        return "no readouts"
    found = _resolved(flight.motor, motors)
    return _lacks(flight, found) or (implausible(flight, found.motor) if found else None) or ""


def used_except(flight: Flight, motors: Catalogue) -> str:
    """Which readouts of a flight that is used in fits are excluded, and why; empty if all are used."""
    found = _resolved(flight.motor, motors)
    return message("; ".join(map(marked, readout_exclusions(flight, found)))) if found else ""


def named_flights(ids: Sequence[str]) -> str:
    """Flights by id, the first few of many: `flights 2, 3, and 40 others`."""
    if len(ids) == 1:
        return flight_label(ids[0])
    shown, others = ids[:MAX_NAMED_FLIGHTS], len(ids) - MAX_NAMED_FLIGHTS
    if others > 0:
        return f"flights {', '.join(shown)}, and {counted(others, 'other')}"
    return f"flights {', '.join(shown[:-1])} and {shown[-1]}"


def outlying(flights: Sequence[Flight], new: Collection[str], motors: Catalogue) -> list[tuple[str, str]]:
    """The id of each new flight whose apogee or top speed is far from the median of its rocket's on the same motor, and
    a line about it. Only with at least `MIN_COMPARED` clean flights to compare, without implausible ones."""
    by_motor: dict[str, list[Flight]] = {}
    for flight in flights:
        if flight.clean and flight.motor:
            by_motor.setdefault(motor_type(flight.motor, motors), []).append(flight)
    found: list[tuple[str, str]] = []
    for several in by_motor.values():
        compared = credible(several, motors)
        usual = {name: value for name, value in middles(compared).items() if name in ("apogee", "top_speed")}
        if len(compared) >= MIN_COMPARED:
            judged = (one for one in several if one.flight_id in new)
            found += [(one.flight_id, phrase) for one in judged for phrase, _ in far_from_usual(one, usual)]
    return found


_TO_THE_LETTERS = re.compile(r"(?:.*?[\s-])??\d*(?:1/[248])?[A-O]-?\d[\d.]*[A-Z]*(?=[-\s]|$)")
"""A motor's name up to its propellant letters. Hyphens occur before its class too: `Q-Jet C12-4`, `HP-I205W-6`."""


def motor_type(name: str, motors: Catalogue) -> str:
    """What motors of one type have in common, however they are written: maker and designation, or of an unknown motor
    its name without a delay."""
    found = None if is_cluster(name) else _resolved(name, motors)
    return without_delay(name) if found is None else f"{found.motor.maker} {found.motor.designation}"


def without_delay(motor: str) -> str:
    """A motor's name without its delay, to compare by; a cluster's whole name."""
    if is_cluster(motor):
        return tidy(motor)
    found = _TO_THE_LETTERS.match(tidy(motor))
    return found[0] if found else motor.partition("-")[0].strip().upper()


def _with_motors(flights: Sequence[Flight], motors: Catalogue) -> Iterator[tuple[Flight, Found | None]]:
    """Every flight with its motor, None if that is not known or the flight has no dry mass; each name is looked up
    once."""
    known: dict[str, Found | None] = {}
    for flight in flights:
        if flight.dry_mass is not None and flight.motor not in known:
            known[flight.motor] = _resolved(flight.motor, motors)
        yield flight, None if flight.dry_mass is None else known[flight.motor]


def _resolved(name: str, motors: Catalogue) -> Found | None:
    try:
        return motors.resolve(name)
    except UnknownMotor:
        return None
