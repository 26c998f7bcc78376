"""The range box: what is left of the motors that the flyer counted, after the flights flown since.

The counts are settings, and every flight stays in its ledger: what is left follows from both, so undoing, removing or
correcting a flight puts its motors back, and flights from before the count take nothing out.
"""

from collections import Counter, defaultdict
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.flight import Flight
from fieldkit.flight.storable import check_name
from fieldkit.motors.lots import recorded_lot
from fieldkit.motors.search import with_delays
from fieldkit.motors.several import each_motor
from fieldkit.paths import data_file
from fieldkit.planning.delay import obtainable
from fieldkit.settings import MOST_IN_BOX, BoxedMotors

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue, Found, Motor

Box = tuple[BoxedMotors, ...]


@dataclass(frozen=True, slots=True)
class _Entry:
    """A counted entry of the box with its motor."""

    place: int
    found: "Found"
    lot: str
    counted: datetime

    def holds(self, taken: "Found", lot: str) -> bool:
        """Whether a motor flown may be one of these: the same one, with its delay or one that is drilled from it."""
        if (self.found.motor.maker, self.found.motor.designation) != (taken.motor.maker, taken.motor.designation):
            return False
        if self.lot and lot and self.lot.casefold() != lot.casefold():
            return False
        if self.found.delay is None or taken.delay in (None, self.found.delay):
            return True
        return taken.delay in obtainable(with_delays(self.found.motor, self.found.delay), data_file("drills.toml"))


def box_left(box: Box, ledger: "Ledger", motors: "Catalogue") -> Box:
    """The entries of a box with what is left of each count after the flights of a ledger flown since it was counted."""
    taken = Counter(place for _, places in _withdrawals(box, ledger, motors) for place in places)
    return tuple(replace(one, count=one.count - taken[place]) for place, one in enumerate(box))


def taken_in_words(box: Box, flight: Flight, ledger: "Ledger", motors: "Catalogue") -> str:
    """What a flight of the ledger took from the box, in words; empty if nothing."""
    withdrawals = _withdrawals(box, ledger, motors)
    identity = flight.rocket, flight.flight_id
    taken = Counter(place for one, places in withdrawals if (one.rocket, one.flight_id) == identity for place in places)
    left = Counter(place for _, places in withdrawals for place in places)
    parts = [f"{count} x {box[place].motor}, {box[place].count - left[place]} left" for place, count in taken.items()]
    return f"Taken from your range box: {'; '.join(parts)}." if parts else ""


def _withdrawals(box: Box, ledger: "Ledger", motors: "Catalogue") -> list[tuple[Flight, list[int]]]:
    """The flights since a box was counted, in the order flown, each with the places of the entries from which it took
    its motors, once for each motor; no entry gives more than it has."""
    entries, left, withdrawals = _counted_entries(box, motors), [one.count for one in box], []
    if not entries:
        return []
    for flight in ledger.flights(since=min(one.counted for one in entries).date()):
        withdrawals.append((flight, places := _taken(flight, entries, left, motors)))
        for place in places:
            left[place] -= 1
    return withdrawals


def _counted_entries(box: Box, motors: "Catalogue") -> list[_Entry]:
    """The entries whose time of counting is known and whose motor is in the catalog."""
    entries = []
    for place, one in enumerate(box):
        with suppress(FieldkitError, ValueError):
            counted = datetime.fromisoformat(one.counted).replace(tzinfo=None)
            entries.append(_Entry(place, motors.resolve(one.motor), one.lot, counted))
    return entries


def _taken(flight: Flight, entries: Sequence[_Entry], left: Sequence[int], motors: "Catalogue") -> list[int]:
    """The places of the entries from which a flight took its motors: one with its lot and delay first. A flight with a
    day and no time counts as flown when the day began."""
    flown = None if flight.date_time is None else flight.date_time.replace(tzinfo=None)
    if flown is None or not flight.motor:
        return []
    try:
        flown_motors = each_motor(flight.motor, motors.resolve)
    except FieldkitError:
        return []
    lot, places = recorded_lot(flight), list[int]()
    for one in flown_motors:
        taken = replace(one, delay=flight.delay) if one.delay is None and len(flown_motors) == 1 else one
        fitting = [
            entry
            for entry in entries
            if entry.counted <= flown and left[entry.place] > places.count(entry.place) and entry.holds(taken, lot)
        ]
        if fitting:
            best = min(fitting, key=lambda entry: (entry.lot != lot, entry.found.delay != taken.delay))
            places.append(best.place)
    return places


def recounted(box: Sequence[BoxedMotors], shown: Box, saved: Box) -> Box:
    """A box as edited, when `shown` were its contents: entries that were not edited stay as `saved`, with their time of
    counting, the others are counted now. Raises BadValue as `counted_now`."""
    unchanged = dict(zip(shown, saved, strict=True))
    return tuple(
        next((saved for seen, saved in unchanged.items() if replace(seen, counted="") == one), counted_now(one))
        for one in box
    )


def counted_now(one: BoxedMotors) -> BoxedMotors:
    """An entry counted now, from which flights from now on are subtracted. Raises BadValue for more than a box holds,
    and for a lot that no table can show."""
    check_name(one.lot)
    if one.count > MOST_IN_BOX:
        raise BadValue(f"found a count of {one.count:.4g}, expected at most {MOST_IN_BOX}")
    return replace(one, counted=datetime.now().isoformat(timespec="minutes"))


def motors_in_box(box: Box, motors: "Catalogue") -> "Counter[Motor]":
    """How many of each motor are in a range box, each with only the delays that are there, if they are named; a name
    that no motor has any more is left out."""
    counts: Counter[Motor] = Counter()
    delays: defaultdict[Motor, set[float | None]] = defaultdict(set)
    for one in box:
        with suppress(FieldkitError):
            found = motors.resolve(one.motor)
            if one.count:
                counts[found.motor] += one.count
                delays[found.motor].add(found.delay)
    return Counter({_boxed_motor(motor, delays[motor]): count for motor, count in counts.items()})


def _boxed_motor(motor: "Motor", delays: Collection[float | None]) -> "Motor":
    """A motor with the delays in the box; with all of its own if one there has no known delay."""
    known = sorted(delay for delay in delays if delay is not None)
    return with_delays(motor, *known) if len(known) == len(delays) else motor
