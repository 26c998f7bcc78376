"""Adding the contents of files to the ledger as one change; a later file of a flight is added to that flight.

Further files of a flight that is already in the ledger: each is added to its flight if the match is certain.

A logger may write a flight into several files: low rate, high rate, a summary. Two files belong to one flight if their
devices match (and their serial numbers, if both have one), their kinds differ, and their lift-off times agree within
two seconds. A download, an export and radio telemetry also match by the logger's serial number and its number of the
flight. Such numbers restart when a memory is erased, so the apogees must agree too. If neither is certain, a note asks
the user to decide.
"""

import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, time
from math import hypot
from pathlib import Path

from fieldkit.errors import DamagedLog, LedgerError, UnknownFormat
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.importing import ColumnChoice, Rejected
from fieldkit.importing.companion_files import same_moment
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.importing.read import read_stored
from fieldkit.importing.tables.mapping import remember
from fieldkit.importing.to_flights import CheckMotor
from fieldkit.ledger import Ledger, Renewal
from fieldkit.messages import marked, message
from fieldkit.motors import Catalogue, catalogue
from fieldkit.services.imports.gather import Gathered, ReadAs, gather
from fieldkit.services.imports.remeasure import as_held, format_of, renewed, which
from fieldkit.services.imports.view import FileView
from fieldkit.services.manual_entry import as_built
from fieldkit.services.plausible_flights import (
    excluded_readouts,
    implausible_flights,
    incomplete_flights,
    named_flights,
    outlying,
)

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
        if incoming.log is None or not (incoming.flight.origin.kinds or _number(incoming.flight)):
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
    origin = flight.origin
    return (origin.serial, origin.number) if origin.serial and origin.number else None


def _everyone(ledger: Ledger) -> list[tuple[str, Flight]]:
    flights = ledger.flights()
    return list(zip(ledger.ids(flights), flights, strict=True))


def _fits(there: Flight, new: Flight) -> bool:
    """Whether a flight was recorded by the device of a new file, on the same rocket if both name one."""
    if new.rocket not in ("", there.rocket):
        return False
    if _number(new):
        return _number(there) == _number(new)
    held, own = there.origin, new.origin
    return bool(held.kinds) and held.device == own.device and len({held.serial, own.serial} - {""}) <= 1


def _is_same(there: Flight, incoming: IncomingFlight) -> bool:
    """Whether a matching flight is certainly that of a new file."""
    new = incoming.flight
    if not _number(new):
        return same_moment(there.date_time, new.date_time)
    return _is_other_form(there, incoming) and _are_as_high(there, new)


def _is_other_form(there: Flight, incoming: IncomingFlight) -> bool:
    """Whether a numbered flight arrives in another format than the ledger has, or in several."""
    return there.origin.format != incoming.flight.origin.format or bool(incoming.others)


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
    if set(there.origin.kinds) & set(new.origin.kinds):
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
    kinds = [set(one.origin.kinds) for one in (flight, incoming.flight)]
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
    fresh = as_held(read, flight, [one.digest for one in (*kept[1:], *new)])
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


@dataclass(frozen=True, slots=True)
class Receipt:
    """The result of an import: ids of the new flights, notes, and flights to which files were added.

    `implausible` are the notes on new flights that are physically impossible; `unusable` counts the rejected files
    without any usable content.
    """

    ids: tuple[str, ...]
    duplicates: int
    rejected: tuple[Rejected, ...]
    notes: tuple[str, ...]
    joined: tuple[str, ...] = ()
    implausible: tuple[str, ...] = ()
    files: tuple[FileView, ...] = ()
    unusable: int = 0


def bring_in(
    ledger: "Ledger",
    paths: Sequence[Path],
    check_motor: CheckMotor,
    *,
    defaults: Mapping[str, object] | None = None,
    motors: Catalogue | None = None,
) -> Receipt:
    """Import files as one change: `gather` and `take_in`. Raises FieldkitError as these."""
    return take_in(ledger, gather(paths, check_motor, ReadAs(defaults=defaults or {})), motors=motors)


def take_in(ledger: "Ledger", gathered: Gathered, *, dry_run: bool = False, motors: Catalogue | None = None) -> Receipt:
    """Add gathered files to a ledger as one change, and save how the flyer chose the columns of tables. With `motors`,
    notes name new flights that are impossible on their motor, and those that no fit can use. Raises FieldkitError if
    something cannot be saved."""
    sorting = sorted_out(ledger, gathered.incoming_flights, gathered.choices)
    built = [_as_built(ledger, one) for one in sorting.new]
    sorting.new = [incoming for incoming, _ in built]
    added = ledger.add(sorting.new, renewals=sorting.renewals, dry_run=dry_run)
    for mapped in gathered.mapped:
        if mapped.chosen and not dry_run:
            remember(mapped.choice)
    conflicts = (Rejected(one.incoming.source, one.incoming.row, "flight_id", one.error) for one in added.conflicts)
    implausible = tuple(_implausible(sorting.new, motors)) if motors else ()
    unused = tuple(_excluded_readouts(sorting.new, motors)) if motors else ()
    incomplete = incomplete_flights([one.flight for one in sorting.new], motors) if motors else []
    return Receipt(
        added.new,
        added.duplicates + sorting.there,
        (*gathered.rejected, *conflicts),
        (
            *gathered.notes,
            *sorting.notes,
            *_notes_on_builds(built, set(added.new)),
            *implausible,
            *unused,
            *incomplete,
            *_beside_others(ledger, sorting.new, set(added.new), motors or catalogue()),
        ),
        tuple(one.id for one in sorting.renewals),
        implausible,
        gathered.files,
        gathered.unusable,
    )


def _as_built(ledger: Ledger, incoming: IncomingFlight) -> tuple[IncomingFlight, list[str]]:
    """A log's flight with what is known of the build of its rocket, as a typed flight gets it, and notes on that. A row
    of a table stays as it is: a table has a column for the mass, or flights of many years."""
    if incoming.row is not None or not incoming.flight.rocket:
        return incoming, []
    flight, notes = as_built(ledger, incoming.flight, ())
    return replace(incoming, flight=flight), [note.text for note in notes]


def _notes_on_builds(built: Iterable[tuple[IncomingFlight, list[str]]], added: set[str]) -> Iterator[str]:
    """A line for each thing that was filled in, with the added flights that it was filled in for."""
    flights: dict[str, list[str]] = {}
    for incoming, notes in built:
        for note in notes if _is_among(incoming, added) else ():
            flights.setdefault(note, []).append(incoming.flight.flight_id)
    for note, ids in flights.items():
        yield message(f"{named_flights(ids)}: {marked(note)}; edit to change")


def _implausible(incoming_flights: Sequence[IncomingFlight], motors: Catalogue) -> Iterator[str]:
    """A line for each new flight that is implausible."""
    for one in incoming_flights:
        for line in implausible_flights([one.flight], motors):
            yield message(marked(DamagedLog(line, row=one.row, source=one.source)))


def _excluded_readouts(incoming_flights: Sequence[IncomingFlight], motors: Catalogue) -> Iterator[str]:
    """A line for each readout of a new flight that cannot be a measurement."""
    for one in incoming_flights:
        for line in excluded_readouts([one.flight], motors):
            yield message(marked(DamagedLog(line, row=one.row, source=one.source)))


def _beside_others(
    ledger: "Ledger", incoming_flights: Sequence[IncomingFlight], added: set[str], motors: Catalogue
) -> list[str]:
    """Lines on the added flights compared with the others of their rockets, which are read once: those that are
    outlying, then those that may be corrections."""
    far: list[str] = []
    corrected: list[str] = []
    for rocket, new in _by_rocket(incoming_flights, added).items():
        there = ledger.flights(rocket)
        far += _outlying(rocket, there, new, motors)
        corrected += _corrected(rocket, there, new)
    return far + corrected


def _outlying(
    rocket: str, there: Sequence[Flight], new: Mapping[str, IncomingFlight], motors: Catalogue
) -> Iterator[str]:
    """A line for each new flight that is far from the others of its rocket on the same motor."""
    known = {flight.flight_id: flight for flight in there} | {name: one.flight for name, one in new.items()}
    for name, phrase in outlying(list(known.values()), new, motors):
        one, line = new[name], message(f"{flight_label(name)} of {rocket}: {marked(phrase)}; check it")
        yield message(marked(DamagedLog(line, row=one.row, source=one.source)))


def _corrected(rocket: str, there: Sequence[Flight], new: Mapping[str, IncomingFlight]) -> Iterator[str]:
    """A line for each new flight that differs in one column from an earlier one of its rocket and date, as a row of a
    table without flight numbers does after it was corrected."""
    before: dict[datetime, list[Flight]] = {}
    for flight in there:
        if flight.date_time and flight.flight_id not in new:
            before.setdefault(flight.date_time, []).append(flight)
    for name, one in new.items():
        for old in before.get(one.flight.date_time, []) if one.flight.date_time else []:
            changed = _differing(old, one.flight)
            if len(changed) == 1:
                text = f"{flight_label(name)} of {rocket} differs from {flight_label(old.flight_id)} only in "
                text += f"{changed[0]}; if it is a correction, remove {old.flight_id}"
                yield str(DamagedLog(text, row=one.row, source=one.source))


def _differing(one: Flight, other: Flight) -> list[str]:
    """The columns in which two flights differ, other than their names."""
    names = {"motor": "motor", "config": "config"} | {name: column.title.lower() for name, column in BY_NAME.items()}
    return [label for name, label in names.items() if getattr(one, name) != getattr(other, name)]


def _by_rocket(incoming_flights: Sequence[IncomingFlight], added: set[str]) -> dict[str, dict[str, IncomingFlight]]:
    """The added flights of each named rocket, by name."""
    rockets: dict[str, dict[str, IncomingFlight]] = {}
    for one in incoming_flights:
        if one.flight.rocket and _is_among(one, added):
            rockets.setdefault(one.flight.rocket, {})[one.flight.flight_id] = one
    return rockets


def _is_among(one: IncomingFlight, added: set[str]) -> bool:
    """Whether a flight is among those added, by their ids."""
    name = one.flight.flight_id
    return bool(added & {name, f"{one.flight.rocket}/{name}"})
