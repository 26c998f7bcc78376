"""Restore a ledger's file from a backup; the former content is saved."""

import os
import sqlite3
import stat
from datetime import UTC, datetime
from pathlib import Path

from fieldkit.errors import LedgerError
from fieldkit.files import also_named, free_name
from fieldkit.ledger.backups import STAMP, Backup, claimed, copy, rotate, taken
from fieldkit.ledger.soundness import damage_in, fault, opened


def restore(file: Path, backup: Backup) -> Path | None:
    """Replace a ledger with a backup; returns the path of the saved former content, None if there was none.

    A sound ledger becomes the newest backup, so another restore can undo this one. A damaged file is renamed, with its
    SQLite journal. From the start of the backup until the ledger is replaced, no other process can read or write it:
    earlier changes are in the backup, later ones go into the restored ledger. If killed, it leaves the old or the new
    ledger. Raises LedgerError if the backup is damaged, the disk is full, or other processes do not release the ledger.
    """
    file = file.resolve()
    try:
        if found := fault(backup.file):
            raise LedgerError(f"{backup.file}: this backup is damaged too ({found}); restore another one")
        if not file.exists() or not file.stat().st_size:
            return _move_aside(file, backup, keep=False)
        with opened(file) as ledger:
            previous = _kept(ledger, file)
            if previous is None:
                return _move_aside(file, backup)
            if found := _miscopied(ledger, file, backup):
                raise LedgerError(f"{backup.file}: cannot be restored ({found}); {_undo_restore(ledger, previous)}")
        rotate(file)
        return previous.file
    except (OSError, sqlite3.Error) as error:
        raise LedgerError(f"{file}: cannot be restored ({error}); nothing was changed") from error


def _miscopied(ledger: sqlite3.Connection, file: Path, backup: Backup) -> str:
    """Copy a backup into a ledger; returns what is wrong with the copy, empty if nothing: SQLite copies a page that a
    disk delivers only in part as zeros, without an error."""
    try:
        with opened(backup.file) as then:
            then.backup(ledger)
        with claimed(file) as (_, new):
            copy(ledger, new)
            return fault(new, since=backup.file)
    except (OSError, sqlite3.Error) as error:
        return str(error)


def _undo_restore(ledger: sqlite3.Connection, previous: Backup) -> str:
    """Restore a ledger's former content; returns the outcome, for the end of a message."""
    try:
        with opened(previous.file) as before:
            before.backup(ledger)
    except sqlite3.Error:
        return f"it may be damaged; its former content is in {previous.file}"
    return "nothing was changed"


def _kept(ledger: sqlite3.Connection, file: Path) -> Backup | None:
    """Back up a ledger and lock out all other processes until it is closed; None for a damaged ledger.

    Raises sqlite3.OperationalError if other processes do not release it.
    """
    try:
        _lock(ledger)
        changes = _changes(ledger)
    except sqlite3.DatabaseError as error:
        damage_in(error)
        return None
    previous = None if changes is None else taken(ledger, file, changes)
    return previous if isinstance(previous, Backup) else None


def _lock(ledger: sqlite3.Connection) -> None:
    """Lock out all other processes from a database until the connection is closed, even after a transaction ends.

    SQLite cannot copy into a database with an open transaction, hence the locking mode. It is set after the lock is
    acquired: otherwise a failed attempt would keep a read lock and block the writer it waits for.
    """
    ledger.isolation_level = None
    for command in ("PRAGMA synchronous = EXTRA", "BEGIN EXCLUSIVE", "PRAGMA locking_mode = EXCLUSIVE", "COMMIT"):
        ledger.execute(command)


def _changes(ledger: sqlite3.Connection) -> int | None:
    """Length of a ledger's journal; None if SQLite finds no damage but the journal is missing. [1]"""
    if not ledger.execute("SELECT 1 FROM sqlite_master WHERE name = 'journal'").fetchone():
        return None
    return int(ledger.execute("SELECT coalesce(max(number), 0) FROM journal").fetchone()[0])


def _move_aside(file: Path, backup: Backup, *, keep: bool = True) -> Path | None:
    """Rename a damaged file and put a backup in its place.

    The damaged file is never opened here, because closing it would release a lock that SQLite holds on it. A process
    that waits for that lock learns from SQLite that the file has moved.
    """
    with claimed(file) as (_, new):
        with opened(backup.file) as then:
            copy(then, new)
        if found := fault(new, since=backup.file):
            raise LedgerError(f"{backup.file}: cannot be read ({found}); nothing was changed, try again")
        if not file.exists():
            new.chmod(stat.S_IMODE(backup.file.stat().st_mode))
        moved = also_named(file, f"{file.name}.damaged-{datetime.now(UTC):{STAMP}}") if keep else None
        journal = file.with_name(f"{file.name}-journal")
        if journal.exists():  # SQLite would roll it back into the copy
            os.replace(journal, free_name(file, f"{moved.name if moved else file.name + '.damaged'}-journal"))
        os.replace(new, file)
    return moved
