"""Further files of a flight that is already in the ledger: each is added to its flight if the match is certain.

A logger may write a flight into several files: low rate, high rate, a summary. Two files belong to one flight if their
devices match (and their serial numbers, if both have one), their kinds differ, and their lift-off times agree within
two seconds. A download, an export and radio telemetry also match by the logger's serial number and its number of the
flight. Such numbers restart when a memory is erased, so the apogees must agree too. If neither is certain, a note asks
the user to decide.
"""

import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import time
from math import hypot

from fieldkit.errors import DamagedLog, LedgerError, UnknownFormat
from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.importing import ColumnChoice
from fieldkit.importing.companion_files import KINDS, same_moment
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.importing.read import read_stored
from fieldkit.ledger import Ledger, Renewal
from fieldkit.services.imports.remeasure import as_held, format_of, renewed, which

SAME_HEIGHT = 0.01
"""Two files of one flight agree on its apogee within this fraction of it, plus their uncertainties. [1]"""


@dataclass(slots=True)
class Sorting:
    """The new flights, the flights that files are added to, the number of duplicates, and the notes."""

    new: list[IncomingFlight] = field(default_factory=list)
    renewals: list["Renewal"] = field(default_factory=list)
    there: int = 0
    notes: list[str] = field(default_factory=list)


def sorted_out(
    ledger: Ledger, incoming_flights: Iterable[IncomingFlight], choices: Sequence[ColumnChoice] = ()
) -> Sorting:
    """Separate incoming flights that are new flights from further files of flights in the ledger."""
    sorting = Sorting()
    for incoming in incoming_flights:
        if incoming.log is None or not (incoming.flight.extra.get(KINDS) or _number(incoming.flight)):
            sorting.new.append(incoming)
            continue
        held = [(id, flight) for id, flight in _everyone(ledger) if _fits(flight, incoming.flight)]
        certain = [id for id, flight in held if _is_same(flight, incoming)]
        if len(certain) == 1:
            _join(ledger, certain[0], incoming, sorting, choices)
            continue
        sorting.new.append(incoming)
        if maybe := certain or [id for id, flight in held if _maybe(flight, incoming)]:
            why = "which has the same number" if _number(incoming.flight) else "whose lift-off time is uncertain"
            sorting.notes.append(
                f"{incoming.source}: may belong to flight {' or '.join(maybe[:3])}, {why}; "
                f"if so, `fieldkit remove` that flight and import its files together"
            )
    return sorting


def _number(flight: Flight) -> tuple[str, str] | None:
    """A logger's serial number and its number for the flight; None if either is unknown."""
    serial, number = flight.extra.get("serial"), flight.extra.get("flight")
    return (serial, number) if serial and number else None


def _everyone(ledger: Ledger) -> list[tuple[str, Flight]]:
    flights = ledger.flights()
    return list(zip(ledger.ids(flights), flights, strict=True))


def _fits(there: Flight, new: Flight) -> bool:
    """Whether a flight was recorded by the device of a new file, on the same rocket if both name one."""
    if new.rocket not in ("", there.rocket):
        return False
    if _number(new):
        return _number(there) == _number(new)
    serials = {there.extra.get("serial", ""), new.extra.get("serial", "")} - {""}
    return bool(there.extra.get(KINDS)) and there.extra.get("device") == new.extra.get("device") and len(serials) <= 1


def _is_same(there: Flight, incoming: IncomingFlight) -> bool:
    """Whether a matching flight is certainly that of a new file."""
    new = incoming.flight
    if not _number(new):
        return same_moment(there.date_time, new.date_time)
    return _is_other_form(there, incoming) and _are_as_high(there, new)


def _is_other_form(there: Flight, incoming: IncomingFlight) -> bool:
    """Whether a numbered flight arrives in another format than the ledger has, or in several."""
    return there.extra.get("log_format") != incoming.flight.extra.get("log_format") or bool(incoming.others)


def _are_as_high(there: Flight, new: Flight) -> bool:
    """Whether two files can have the same apogee, given the uncertainty of each."""
    heights = [flight.number("apogee") for flight in (there, new)]
    if heights[0] is None or heights[1] is None:
        return False
    sds = [flight.sd.get("apogee", 0.0) for flight in (there, new)]
    return abs(heights[0] - heights[1]) < 3 * hypot(*sds) + SAME_HEIGHT * heights[0]


def _maybe(there: Flight, incoming: IncomingFlight) -> bool:
    """Whether a new file may belong to a matching flight: nothing in its number, kind or date contradicts that."""
    new = incoming.flight
    if _number(new):
        return new.flight_id != there.flight_id
    if set(there.extra[KINDS].split()) & set(new.extra[KINDS].split()):
        return False
    days = {flight.date_time.date() for flight in (there, new) if flight.date_time}
    timed = all(flight.date_time and flight.date_time.time() != time() for flight in (there, new))
    return len(days) <= 1 and not timed


def _join(ledger: Ledger, id: str, incoming: IncomingFlight, sorting: Sorting, choices: Sequence[ColumnChoice]) -> None:
    """Add the files of an incoming flight to a flight, unless together they turn out to be a separate flight."""
    flight, entered, log = ledger.flight(id), ledger.entered(id), ledger.log(id)
    kept = [Original.of(one) for one in ((log,) if log is not None else ()) + tuple(ledger.other_logs(id))]
    digests = {one.digest for one in kept}
    new = [one for one in (incoming.log, *incoming.others) if one and one.digest not in digests]
    if not new:
        sorting.there += _is_there(flight, incoming, sorting)
        return
    kinds = [set(one.extra.get(KINDS, "").split()) for one in (flight, incoming.flight)]
    if not kept or (kinds[1] and kinds[0] >= kinds[1]):
        sorting.new.append(incoming)
        return
    contents = [zlib.decompress(one.compressed) for one in (*kept, *new)]
    try:
        read = which(flight, read_stored(contents, id, format_of(flight), choices), id)
    except (DamagedLog, UnknownFormat, LedgerError) as error:
        sorting.new.append(incoming)
        sorting.notes.append(
            f"{incoming.source}: belongs to {flight_label(id)} but cannot be read together "
            f"with its other files: {error}"
        )
        return
    fresh = as_held(read, flight, " ".join(one.digest for one in (*kept[1:], *new)))
    given = {name: value for name, value in (incoming.given or {}).items() if getattr(flight, name) in (None, "", ())}
    again = None if entered is None else renewed(entered, None, fresh)
    sorting.renewals.append(
        Renewal(id, flight, renewed(flight, entered, fresh).with_changes(**given), again, tuple(new))
    )
    sorting.notes.append(f"{incoming.source}: added to {flight_label(id)}")


def _is_there(flight: Flight, incoming: IncomingFlight, sorting: Sorting) -> bool:
    """Whether the flight has everything that an incoming flight states; otherwise the ledger reports the conflict."""
    beside = ("extra", "sd", "source")
    given = {name: value for name, value in (incoming.given or {}).items() if name not in beside}
    if all(getattr(flight, name) == value for name, value in given.items() if value not in (None, "")):
        return True
    sorting.new.append(incoming)
    return False
