"""Backups of a ledger's file, saved in a folder next to it: the last ten, in rotation.

A backup is made by SQLite's backup API, so it is complete even if another process writes. It counts only after SQLite
and the row checksums have verified it: a damaged ledger never replaces a good backup. Backups are numbered because a
clock may be set back. A ledger on a server is backed up by its administrator.
"""

import os
import re
import sqlite3
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from fieldkit.errors import LedgerError
from fieldkit.files import BACKUPS, also_named, free_name
from fieldkit.ledger.soundness import damage_in, fault, opened

MAX_BACKUPS = 10
"""Number of backups retained. [1]"""
ROOM = 1 << 30
"""Total size of the backups above which all but the newest two are deleted. [byte]"""
CHANGES_PER_BACKUP = 50
"""Changes since the last backup that trigger another one on the same day. [1]"""
ABANDONED_COPY_AGE = 3600.0
"""Age above which a partial backup counts as abandoned. [s]"""
AT_WORK = 60.0
"""A partial backup that grew within this time is in progress. [s]"""

_MAKING = ".new"
"""Suffix of a backup in progress, whose name begins with its reserved number."""
_NAME = re.compile(r"(\d{6,})_(\d{8}T\d{6}Z)_(\d+)\.db")
_STAMP = "%Y%m%dT%H%M%SZ"


@dataclass(frozen=True, slots=True)
class Backup:
    """One backup; `number` counts up from 1 and `changes` is the length of the ledger's journal in it."""

    file: Path
    number: int
    at: datetime
    changes: int

    @property
    def size(self) -> int:
        """File size, 0 if another process has deleted it. [byte]"""
        try:
            return self.file.stat().st_size
        except OSError:
            return 0

    @property
    def flights(self) -> int | None:
        """Number of flights in it, None if the backup is damaged. [1]"""
        try:
            with opened(self.file) as copy:
                return int(copy.execute("SELECT count(*) FROM flights").fetchone()[0])
        except sqlite3.DatabaseError:
            return None


def folder_of(file: Path) -> Path:
    """The folder of a ledger's backups, which may not exist."""
    return file.with_name(f"{file.name}{BACKUPS}")


def backups(file: Path) -> list[Backup]:
    """The backups of a ledger, newest first."""
    folder = folder_of(file)
    found = [_backup(one, match) for one in _listed(folder) if (match := _NAME.fullmatch(one.name))]
    return sorted(found, key=lambda one: (one.number, one.at), reverse=True)


def _listed(folder: Path) -> list[Path]:
    return list(folder.iterdir()) if folder.is_dir() else []


def _backup(file: Path, match: re.Match[str]) -> Backup:
    at = datetime.strptime(match[2], _STAMP).replace(tzinfo=UTC)
    return Backup(file, int(match[1]), at, int(match[3]))


def is_due(file: Path, changes: int) -> bool:
    """Whether a backup of a ledger with this many changes is due: on a new day, or after many changes."""
    newest = next(iter(backups(file)), None)
    if newest is None or not changes:
        return bool(changes)
    return newest.at.date() != datetime.now(UTC).date() or abs(changes - newest.changes) >= CHANGES_PER_BACKUP


def being_made(file: Path) -> bool:
    """Whether another process is backing up the ledger now, so that no other backup is needed."""
    folder = folder_of(file)
    return any(time.time() - since < AT_WORK for since in map(_touched, folder.glob(f"*{_MAKING}")))


def _touched(file: Path) -> float:
    """Time of the last write to a file, 0 if it no longer exists. [s since 1970]"""
    try:
        return file.stat().st_mtime
    except OSError:
        return 0.0


def take(ledger: sqlite3.Connection, file: Path, changes: int) -> Backup:
    """Back up an open ledger, and delete the oldest backups.

    Raises LedgerError if the ledger is damaged; OSError or sqlite3.Error if no backup can be made.
    """
    taken = _take(ledger, file, changes)
    if isinstance(taken, str):
        raise LedgerError(f"{file}: the file is damaged ({taken}); {offer(file)}")
    _rotate(file)
    return taken


def _take(ledger: sqlite3.Connection, file: Path, changes: int) -> Backup | str:
    """A backup of an open ledger, or a description of the damage. Raises OSError, sqlite3.Error."""
    folder = folder_of(file)
    folder.mkdir(exist_ok=True)
    last, at = next(iter(backups(file)), None), datetime.now(UTC)
    with _claimed(file) as (number, new):
        try:
            _copy(ledger, new)
        except sqlite3.DatabaseError as error:
            return damage_in(error)
        if found := fault(new, since=last.file if last else None):
            return found
        kept = folder / f"{number:06d}_{at:{_STAMP}}_{changes}.db"
        os.replace(new, kept)
    return Backup(kept, number, at, changes)


@contextmanager
def _claimed(file: Path) -> Iterator[tuple[int, Path]]:
    """Reserve a unique backup number and a partial file with the permissions of the ledger.

    The file is deleted at the end unless it was renamed; files left by killed processes are deleted too.
    """
    folder = folder_of(file)
    for old in folder.glob(f"*{_MAKING}*"):
        if time.time() - _touched(old) > ABANDONED_COPY_AGE:
            old.unlink(missing_ok=True)
    number, new = _claim(file)
    try:
        if file.exists():
            new.chmod(stat.S_IMODE(file.stat().st_mode))
        yield number, new
    finally:
        new.unlink(missing_ok=True)


def _claim(file: Path) -> tuple[int, Path]:
    """Reserve the next number by creating a file: concurrent processes each get their own."""
    folder, number = folder_of(file), 0
    while True:
        number = max(number, _last(file)) + 1
        new = folder / f"{number:06d}{_MAKING}"
        try:
            os.close(os.open(new, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        except FileExistsError:
            continue
        if number > _last(file):
            return number, new
        new.unlink()  # another process claimed, made and named it after we listed the folder


def _last(file: Path) -> int:
    return max((one.number for one in backups(file)), default=0)


def _copy(ledger: sqlite3.Connection, target: Path) -> None:
    """Copy a whole database into a file, in one transaction that is on disk when this returns."""
    with opened(target) as copy:
        copy.execute("PRAGMA synchronous = EXTRA")
        ledger.backup(copy)


def _rotate(file: Path) -> None:
    kept = backups(file)
    while len(kept) > MAX_BACKUPS or (len(kept) > 2 and sum(one.size for one in kept) > ROOM):
        kept.pop().file.unlink(missing_ok=True)


def offer(file: Path) -> str:
    """How to restore a damaged ledger, for the end of a message."""
    newest = next(iter(backups(file)), None)
    if newest is None:
        return "it has no backup; `sqlite3 FILE .recover` may recover some of it"
    when = f"{newest.at.astimezone():%Y-%m-%d %H:%M}"
    return f"`fieldkit backups restore` restores the backup of {when} and saves what is left"


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
            return _put_aside(file, backup, keep=False)
        with opened(file) as ledger:
            kept = _kept(ledger, file)
            if kept is None:
                return _put_aside(file, backup)
            if found := _miscopied(ledger, file, backup):
                raise LedgerError(f"{backup.file}: cannot be restored ({found}); {_put_back(ledger, kept)}")
        _rotate(file)
        return kept.file
    except (OSError, sqlite3.Error) as error:
        raise LedgerError(f"{file}: cannot be restored ({error}); nothing was changed") from error


def _miscopied(ledger: sqlite3.Connection, file: Path, backup: Backup) -> str:
    """Copy a backup into a ledger; returns what is wrong with the copy, empty if nothing: SQLite copies a page that a
    disk delivers only in part as zeros, without an error."""
    try:
        with opened(backup.file) as then:
            then.backup(ledger)
        with _claimed(file) as (_, new):
            _copy(ledger, new)
            return fault(new, since=backup.file)
    except (OSError, sqlite3.Error) as error:
        return str(error)


def _put_back(ledger: sqlite3.Connection, kept: Backup) -> str:
    """Restore a ledger's former content; returns the outcome, for the end of a message."""
    try:
        with opened(kept.file) as before:
            before.backup(ledger)
    except sqlite3.Error:
        return f"it may be damaged; what it was is in {kept.file}"
    return "nothing was changed"


def _kept(ledger: sqlite3.Connection, file: Path) -> Backup | None:
    """Back up a ledger and lock out all other processes until it is closed; None for a damaged ledger.

    Raises sqlite3.OperationalError if other processes do not release it.
    """
    try:
        _hold(ledger)
        changes = _changes(ledger)
    except sqlite3.DatabaseError as error:
        damage_in(error)
        return None
    kept = None if changes is None else _take(ledger, file, changes)
    return kept if isinstance(kept, Backup) else None


def _hold(ledger: sqlite3.Connection) -> None:
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


def _put_aside(file: Path, backup: Backup, *, keep: bool = True) -> Path | None:
    """Rename a damaged file and put a backup in its place.

    The damaged file is never opened here, because closing it would release a lock that SQLite holds on it. A process
    that waits for that lock learns from SQLite that the file has moved.
    """
    with _claimed(file) as (_, new):
        with opened(backup.file) as then:
            _copy(then, new)
        if found := fault(new, since=backup.file):
            raise LedgerError(f"{backup.file}: cannot be read ({found}); nothing was changed, try again")
        if not file.exists():
            new.chmod(stat.S_IMODE(backup.file.stat().st_mode))
        aside = also_named(file, f"{file.name}.damaged-{datetime.now(UTC):{_STAMP}}") if keep else None
        journal = file.with_name(f"{file.name}-journal")
        if journal.exists():  # SQLite would roll it back into the copy
            os.replace(journal, free_name(file, f"{aside.name if aside else file.name + '.damaged'}-journal"))
        os.replace(new, file)
    return aside
