"""Adding the contents of files to the ledger as one change; a later file of a flight is added to that flight."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from fieldkit.errors import DamagedLog
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.importing import ColumnChoice, Mapped, Rejected
from fieldkit.importing.incoming import IncomingFlight
from fieldkit.importing.to_flights import CheckMotor
from fieldkit.motors import Catalogue, catalogue
from fieldkit.services.imports.companion_files import sorted_out
from fieldkit.services.imports.gather import Gathered, gather
from fieldkit.services.imports.view import FileView
from fieldkit.services.plausible_flights import excluded_readouts, implausible_flights, incomplete_flights, outlying

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger


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
    mapped: tuple[Mapped, ...] = ()
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
    """Import files as one change: `gather` and `take_in`."""
    return take_in(ledger, gather(paths, check_motor, defaults=defaults), motors=motors)


def take_in(
    ledger: "Ledger",
    gathered: Gathered,
    *,
    choices: Sequence[ColumnChoice] = (),
    dry_run: bool = False,
    motors: Catalogue | None = None,
) -> Receipt:
    """Add gathered files to a ledger as one change. `choices` are the column choices used in gathering. With `motors`,
    notes name new flights that are impossible on their motor, and those that no fit can use."""
    sorting = sorted_out(ledger, gathered.incoming_flights, choices)
    added = ledger.add(sorting.new, renewals=sorting.renewals, dry_run=dry_run)
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
            *implausible,
            *unused,
            *incomplete,
            *_outlying(ledger, sorting.new, set(added.new), motors or catalogue()),
            *_corrected(ledger, sorting.new, set(added.new)),
        ),
        gathered.mapped,
        tuple(one.id for one in sorting.renewals),
        implausible,
        gathered.files,
        gathered.unusable,
    )


def _implausible(incoming_flights: Sequence[IncomingFlight], motors: Catalogue) -> Iterator[str]:
    """A line for each new flight that is implausible."""
    for one in incoming_flights:
        for line in implausible_flights([one.flight], motors):
            yield str(DamagedLog(line, row=one.row, source=one.source))


def _excluded_readouts(incoming_flights: Sequence[IncomingFlight], motors: Catalogue) -> Iterator[str]:
    """A line for each readout of a new flight that cannot be a measurement."""
    for one in incoming_flights:
        for line in excluded_readouts([one.flight], motors):
            yield str(DamagedLog(line, row=one.row, source=one.source))


def _outlying(
    ledger: "Ledger", incoming_flights: Sequence[IncomingFlight], added: set[str], motors: Catalogue
) -> Iterator[str]:
    """A line for each added flight that is far from the others of its rocket on the same motor."""
    for rocket, new in _by_rocket(incoming_flights, added).items():
        known = {flight.flight_id: flight for flight in ledger.flights(rocket)}
        known |= {name: one.flight for name, one in new.items()}
        for name, phrase in outlying(list(known.values()), new, motors):
            one = new[name]
            yield str(
                DamagedLog(f"{flight_label(name)} of {rocket}: {phrase}; check it", row=one.row, source=one.source)
            )


def _corrected(ledger: "Ledger", incoming_flights: Sequence[IncomingFlight], added: set[str]) -> Iterator[str]:
    """A line for each added flight that differs in one column from an earlier one of its rocket and date, as a row of a
    table without flight numbers does after it was corrected."""
    for rocket, new in _by_rocket(incoming_flights, added).items():
        before: dict[datetime, list[Flight]] = {}
        for flight in ledger.flights(rocket):
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
        name = one.flight.flight_id
        if one.flight.rocket and added & {name, f"{one.flight.rocket}/{name}"}:
            rockets.setdefault(one.flight.rocket, {})[name] = one
    return rockets
