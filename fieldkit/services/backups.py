"""The backups of a ledger: listing them and restoring one."""

from pathlib import Path

from fieldkit.errors import LedgerError
from fieldkit.ledger import whereabouts
from fieldkit.ledger.backups import Backup, backups


def copies(where: str | Path | None) -> tuple[Path, list[Backup]]:
    """A ledger's file and its backups, newest first. Raises LedgerError for a ledger that is not a file."""
    url = whereabouts.location(where)
    file = whereabouts.file_of(url)
    if file is None:
        raise LedgerError(
            f"{whereabouts.name_of(url)}: found a ledger on a server, expected a file; use the server's own backups"
        )
    return file, backups(file)


def chosen_copy(where: str | Path | None, number: int | None) -> tuple[Path, Backup]:
    """A ledger's file and the backup with a number, by default the newest. Raises LedgerError if there is none."""
    file, known = copies(where)
    for one in known:
        if number in (None, one.number):
            return file, one
    if not known:
        raise LedgerError(f"{file}: has no backups yet; one is made before the first change of a day")
    raise LedgerError(f"{file}: no backup {number}, expected one of: {', '.join(str(one.number) for one in known)}")
