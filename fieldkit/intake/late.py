"""Files that come after others of the same flight: each joins its flight, where that can be told for certain.

A logger may write a flight into several files: low rate, high rate, a summary. Files are of one flight where the
device, and the serial number if both name one, are the same, the kinds of file differ, and they state the same
lift-off to within two seconds. Where no time of day is stated that may be so: it is said, and the flyer decides.
"""

import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import time
from typing import TYPE_CHECKING

from fieldkit.arrival import Arrival, Original
from fieldkit.errors import DamagedLog, LedgerError, UnknownFormat
from fieldkit.flight import Flight
from fieldkit.intake.again import as_held, format_of, renewed, which
from fieldkit.parsing import Choice, read_kept
from fieldkit.parsing.parts import KINDS, same_moment

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger, Renewal


@dataclass(slots=True)
class Sorting:
    """Arrivals that are new, flights that files are added to, how many are there already, and what is to be said."""

    new: list[Arrival] = field(default_factory=list)
    renewals: list["Renewal"] = field(default_factory=list)
    there: int = 0
    notes: list[str] = field(default_factory=list)


def sorted_out(ledger: "Ledger", arrivals: Iterable[Arrival], choices: Sequence[Choice] = ()) -> Sorting:
    """Which arrivals are flights of their own, and which are further files of a flight of the ledger."""
    sorting = Sorting()
    for arrival in arrivals:
        if arrival.log is None or not arrival.flight.extra.get(KINDS):
            sorting.new.append(arrival)
            continue
        held = [(id, flight) for id, flight in _everyone(ledger) if _fits(flight, arrival.flight)]
        certain = [id for id, flight in held if same_moment(flight.date_time, arrival.flight.date_time)]
        if len(certain) == 1:
            _join(ledger, certain[0], arrival, sorting, choices)
            continue
        sorting.new.append(arrival)
        if maybe := certain or [id for id, flight in held if _maybe(flight, arrival.flight)]:
            sorting.notes.append(
                f"{arrival.source}: may be of the flight {' or '.join(maybe[:3])}, whose lift-off is not known for "
                f"certain; where it is, `fieldkit remove` that flight and import its files together"
            )
    return sorting


def _everyone(ledger: "Ledger") -> list[tuple[str, Flight]]:
    flights = ledger.flights()
    return list(zip(ledger.ids(flights), flights, strict=True))


def _fits(there: Flight, new: Flight) -> bool:
    """Whether a flight is by the device of a new file, and of no other rocket."""
    if not there.extra.get(KINDS) or new.rocket not in ("", there.rocket):
        return False
    serials = {there.extra.get("serial", ""), new.extra.get("serial", "")} - {""}
    return there.extra.get("device") == new.extra.get("device") and len(serials) <= 1


def _maybe(there: Flight, new: Flight) -> bool:
    """Whether a new file may be of a flight: its kind is another, and no date speaks against it."""
    if set(there.extra[KINDS].split()) & set(new.extra[KINDS].split()):
        return False
    days = {flight.date_time.date() for flight in (there, new) if flight.date_time}
    timed = all(flight.date_time and flight.date_time.time() != time() for flight in (there, new))
    return len(days) <= 1 and not timed


def _join(ledger: "Ledger", id: str, arrival: Arrival, sorting: Sorting, choices: Sequence[Choice]) -> None:
    """Add the files of an arrival to a flight, or leave it where its files are a flight of their own after all."""
    from fieldkit.ledger import Renewal

    flight, entered, log = ledger.flight(id), ledger.entered(id), ledger.log(id)
    kept = [Original.of(one) for one in ((log,) if log is not None else ()) + tuple(ledger.other_logs(id))]
    digests = {one.digest for one in kept}
    new = [one for one in (arrival.log, *arrival.others) if one and one.digest not in digests]
    if not new:
        sorting.there += _is_there(flight, arrival, sorting)
        return
    if not kept or set(flight.extra[KINDS].split()) >= set(arrival.flight.extra[KINDS].split()):
        sorting.new.append(arrival)
        return
    contents = [zlib.decompress(one.packed) for one in (*kept, *new)]
    try:
        read = which(flight, read_kept(contents, id, format_of(flight), choices), id)
    except (DamagedLog, UnknownFormat, LedgerError) as error:
        sorting.new.append(arrival)
        sorting.notes.append(
            f"{arrival.source}: is of the flight {id}, but cannot be read with its other files: {error}"
        )
        return
    fresh = as_held(read, flight, " ".join(one.digest for one in (*kept[1:], *new)))
    given = {name: value for name, value in (arrival.given or {}).items() if getattr(flight, name) in (None, "", ())}
    again = None if entered is None else renewed(entered, None, fresh)
    sorting.renewals.append(Renewal(id, renewed(flight, entered, fresh).with_changes(**given), again, tuple(new)))
    sorting.notes.append(f"{arrival.source}: is a further file of the flight {id}, and was added to it")


def _is_there(flight: Flight, arrival: Arrival, sorting: Sorting) -> bool:
    """Whether the flight has all that an arrival says; else the arrival is left for the ledger to object to."""
    said = {name: value for name, value in (arrival.given or {}).items() if name != "extra" and value not in (None, "")}
    if all(getattr(flight, name) == value for name, value in said.items()):
        return True
    sorting.new.append(arrival)
    return False
