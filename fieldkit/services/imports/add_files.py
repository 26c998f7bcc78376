"""What files hold, put into the ledger as one change; a file that comes later joins the flight that it is of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fieldkit.importing import Choice, Mapped, Rejected
from fieldkit.importing.to_flights import CheckMotor
from fieldkit.services.imports.companion_files import sorted_out
from fieldkit.services.imports.gather import Gathered, gather
from fieldkit.services.imports.view import FileView

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger


@dataclass(frozen=True, slots=True)
class Receipt:
    """What became of files: ids of the new flights, what the flyer should know, flights that files were added to."""

    ids: tuple[str, ...]
    duplicates: int
    rejected: tuple[Rejected, ...]
    notes: tuple[str, ...]
    mapped: tuple[Mapped, ...] = ()
    joined: tuple[str, ...] = ()
    files: tuple[FileView, ...] = ()


def bring_in(
    ledger: "Ledger",
    paths: Sequence[Path],
    check_motor: CheckMotor,
    *,
    format: str | None = None,
    defaults: Mapping[str, object] | None = None,
    choices: Sequence[Choice] = (),
    dry_run: bool = False,
) -> Receipt:
    """Import files as one command: `gather` and `take_in`."""
    gathered = gather(paths, check_motor, format=format, defaults=defaults, choices=choices)
    return take_in(ledger, gathered, choices=choices, dry_run=dry_run)


def take_in(ledger: "Ledger", gathered: Gathered, *, choices: Sequence[Choice] = (), dry_run: bool = False) -> Receipt:
    """Put what was gathered into a ledger, as one change; `choices` are those that it was gathered with."""
    sorting = sorted_out(ledger, gathered.arrivals, choices)
    added = ledger.add(sorting.new, renewals=sorting.renewals, dry_run=dry_run)
    conflicts = (Rejected(one.arrival.source, one.arrival.row, "flight_id", one.error) for one in added.conflicts)
    return Receipt(
        added.new,
        added.duplicates + sorting.there,
        (*gathered.rejected, *conflicts),
        (*gathered.notes, *sorting.notes),
        gathered.mapped,
        tuple(one.id for one in sorting.renewals),
        gathered.files,
    )
