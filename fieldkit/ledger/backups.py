"""Copies of a ledger's file, saved in a folder next to it: the last ten, in rotation.

A copy is made by SQLite's own backup call, so that it is whole while another process writes, and it counts only
once SQLite and the checksums of its rows have found it sound: a damaged ledger never pushes a good copy out. Copies
are numbered, for a clock may go backwards. A ledger on a server is backed up by its administrator.
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
"""Size of all backups above which those beyond the newest two are deleted. [byte]"""
CHANGES_PER_BACKUP = 50
"""Changes since the last backup that trigger another one on the same day. [1]"""
ABANDONED_COPY_AGE = 3600.0
"""Age above which a half-written backup counts as abandoned. [s]"""
AT_WORK = 60.0
"""A half-written backup that grew within this time is in progress. [s]"""

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
        """Size of the file, 0 if another process has deleted it. [byte]"""
        try:
            return self.file.stat().st_size
        except OSError:
            return 0

    @property
    def flights(self) -> int | None:
        """Number of flights in it, None if it is damaged itself. [1]"""
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
    """Whether to back up a ledger with a number of changes before the next one: on a new day, or after many."""
    newest = next(iter(backups(file)), None)
    if newest is None or not changes:
        return bool(changes)
    return newest.at.date() != datetime.now(UTC).date() or abs(changes - newest.changes) >= CHANGES_PER_BACKUP


def being_made(file: Path) -> bool:
    """Whether another process is backing up a ledger now, which suffices."""
    folder = folder_of(file)
    return any(time.time() - since < AT_WORK for since in map(_touched, folder.glob(f"*{_MAKING}")))


def _touched(file: Path) -> float:
    """When a file was last written to, long ago if it no longer exists. [s since 1970]"""
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
    """A backup of an open ledger, or what is wrong with the ledger. Raises OSError, sqlite3.Error."""
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
    """A number that no other copy of a ledger has or gets, and a file for it in the making, of the ledger's own mode.

    The file is gone at the end unless it was renamed; so are those of killed processes.
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
    """The next number, reserved by a new file: processes that ask at the same time each get their own."""
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
        new.unlink()  # it was claimed, made and named since the look at the folder


def _last(file: Path) -> int:
    return max((one.number for one in backups(file)), default=0)


def _copy(ledger: sqlite3.Connection, target: Path) -> None:
    """Copy a whole database into a file, as one transaction that is on the disk at the end."""
    with opened(target) as copy:
        copy.execute("PRAGMA synchronous = EXTRA")
        ledger.backup(copy)


def _rotate(file: Path) -> None:
    kept = backups(file)
    while len(kept) > MAX_BACKUPS or (len(kept) > 2 and sum(one.size for one in kept) > ROOM):
        kept.pop().file.unlink(missing_ok=True)


def offer(file: Path) -> str:
    """What to do about a damaged ledger, for the end of a message."""
    newest = next(iter(backups(file)), None)
    if newest is None:
        return "it has no backup; `sqlite3 FILE .recover` may recover some of it"
    when = f"{newest.at.astimezone():%Y-%m-%d %H:%M}"
    return f"`fieldkit backups restore` restores the backup of {when} and saves what is left"


def restore(file: Path, backup: Backup) -> Path | None:
    """Put a copy in a ledger's place; where what was there is kept now, None if that was nothing.

    A sound ledger becomes the newest copy, so that another restore takes this one back. A damaged file is put
    aside, with what SQLite's journal held for it. From before the copy until the ledger is replaced nobody else
    reads or writes it: what was written before is in the copy, what comes later goes into the restored ledger.
    A kill leaves the ledger as it was or as it will be. Raises LedgerError if the copy is damaged itself,
    the disk takes no more, or others do not let go of the ledger.
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
    """Copy a backup into a ledger; what is wrong with it, empty for nothing: SQLite copies a page that a disk hands
    over in part only, without an error, as one of zeros."""
    try:
        with opened(backup.file) as then:
            then.backup(ledger)
        with _claimed(file) as (_, new):
            _copy(ledger, new)
            return fault(new, since=backup.file)
    except (OSError, sqlite3.Error) as error:
        return str(error)


def _put_back(ledger: sqlite3.Connection, kept: Backup) -> str:
    """Copy what a ledger was back into it; what came of that, for the end of a message."""
    try:
        with opened(kept.file) as before:
            before.backup(ledger)
    except sqlite3.Error:
        return f"it may be damaged; what it was is in {kept.file}"
    return "nothing was changed"


def _kept(ledger: sqlite3.Connection, file: Path) -> Backup | None:
    """A copy of a ledger that is held against everybody else from now on, until it is closed; None for a damaged one.

    Raises sqlite3.OperationalError if others do not let go of it.
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
    """Keep everybody else out of a database until the connection is closed, beyond the end of a transaction.

    SQLite copies into no database that is in a transaction of its own, hence the locking mode. It is set once the lock
    is had: set before, a try that fails would keep a lock for reading, and with it the writer it waits for from ending.
    """
    ledger.isolation_level = None
    for command in ("PRAGMA synchronous = EXTRA", "BEGIN EXCLUSIVE", "PRAGMA locking_mode = EXCLUSIVE", "COMMIT"):
        ledger.execute(command)


def _changes(ledger: sqlite3.Connection) -> int | None:
    """The length of a ledger's journal; None if SQLite finds nothing wrong with a file that has lost it. [1]"""
    if not ledger.execute("SELECT 1 FROM sqlite_master WHERE name = 'journal'").fetchone():
        return None
    return int(ledger.execute("SELECT coalesce(max(number), 0) FROM journal").fetchone()[0])


def _put_aside(file: Path, backup: Backup, *, keep: bool = True) -> Path | None:
    """Put a copy in a damaged file's place, which keeps its bytes under another name.

    The damaged file is never opened for that: closing it would let go of a lock that SQLite holds on it. Who waits
    for that lock learns from SQLite that the file has moved.
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
        if journal.exists():  # it would be played back into the copy
            os.replace(journal, free_name(file, f"{aside.name if aside else file.name + '.damaged'}-journal"))
        os.replace(new, file)
    return aside
