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
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from fieldkit.errors import LedgerError
from fieldkit.files import BACKUPS
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
STAMP = "%Y%m%dT%H%M%SZ"
"""Format of a time in the name of a file."""


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
    found = [backup for one in (folder.iterdir() if folder.is_dir() else ()) if (backup := _backup(one))]
    return sorted(found, key=lambda one: (one.number, one.at), reverse=True)


def _backup(file: Path) -> Backup | None:
    """A backup by its name, None for the name of another file."""
    with suppress(ValueError):
        if match := _NAME.fullmatch(file.name):
            return Backup(file, int(match[1]), datetime.strptime(match[2], STAMP).replace(tzinfo=UTC), int(match[3]))
    return None


def is_due(file: Path, changes: int) -> bool:
    """Whether a backup of a ledger with this many changes is due: on a new day, or after many changes."""
    newest = next(iter(backups(file)), None)
    if newest is None or not changes:
        return bool(changes)
    return newest.at.date() != datetime.now(UTC).date() or abs(changes - newest.changes) >= CHANGES_PER_BACKUP


def being_made(file: Path) -> bool:
    """Whether another process is backing up the ledger now, so that no other backup is needed."""
    folder = folder_of(file)
    return any(time.time() - since < AT_WORK for since in map(_last_change, folder.glob(f"*{_MAKING}")))


def _last_change(file: Path) -> float:
    """Time of the last write to a file, 0 if it no longer exists. [s since 1970]"""
    try:
        return file.stat().st_mtime
    except OSError:
        return 0.0


def take(ledger: sqlite3.Connection, file: Path, changes: int) -> Backup:
    """Back up an open ledger, and delete the oldest backups.

    Raises LedgerError if the ledger is damaged; OSError or sqlite3.Error if no backup can be made.
    """
    backup = taken(ledger, file, changes)
    if isinstance(backup, str):
        raise LedgerError(f"{file}: the file is damaged ({backup}); {offer(file)}")
    rotate(file)
    return backup


def taken(ledger: sqlite3.Connection, file: Path, changes: int) -> Backup | str:
    """A backup of an open ledger, or a description of the damage. Raises OSError, sqlite3.Error."""
    _make_folder(file)
    last, at = next(iter(backups(file)), None), datetime.now(UTC)
    with claimed(file) as (number, new):
        try:
            copy(ledger, new)
        except sqlite3.DatabaseError as error:
            return damage_in(error)
        if found := fault(new, since=last.file if last else None):
            return found
        kept = new.with_name(f"{number:06d}_{at:{STAMP}}_{changes}.db")
        os.replace(new, kept)
    return Backup(kept, number, at, changes)


def _make_folder(file: Path) -> None:
    """Create the folder of a ledger's backups for everyone who may read or write the ledger."""
    folder = folder_of(file)
    if not folder.is_dir():
        folder.mkdir(exist_ok=True)
        mode = stat.S_IMODE(file.stat().st_mode)
        folder.chmod(stat.S_IMODE(folder.stat().st_mode) | mode | (mode & 0o444) >> 2)


@contextmanager
def claimed(file: Path) -> Iterator[tuple[int, Path]]:
    """Reserve a unique backup number and a partial file with the permissions of the ledger.

    The file is deleted at the end unless it was renamed; files left by killed processes are deleted too.
    """
    folder = folder_of(file)
    for old in folder.glob(f"*{_MAKING}*"):
        if time.time() - _last_change(old) > ABANDONED_COPY_AGE:
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
        new.unlink()  # another process claimed and completed it after we listed the folder


def _last(file: Path) -> int:
    return max((one.number for one in backups(file)), default=0)


def copy(ledger: sqlite3.Connection, target: Path) -> None:
    """Copy a whole database into a file, in one transaction that is on disk when this returns."""
    with opened(target) as copy:
        copy.execute("PRAGMA synchronous = EXTRA")
        ledger.backup(copy)


def rotate(file: Path) -> None:
    """Delete the oldest backups; one that cannot be deleted stays."""
    kept = backups(file)
    while len(kept) > MAX_BACKUPS or (len(kept) > 2 and sum(one.size for one in kept) > ROOM):
        with suppress(OSError):
            kept.pop().file.unlink()


def offer(file: Path) -> str:
    """How to restore a damaged ledger, for the end of a message."""
    try:
        newest = next(iter(backups(file)), None)
    except OSError as error:
        return f"its backups in {folder_of(file)} cannot be read ({error.strerror})"
    if newest is None:
        return "it has no backup; `sqlite3 FILE .recover` may recover some of it"
    when = f"{newest.at.astimezone():%Y-%m-%d %H:%M}"
    return f"`fieldkit backups restore` restores the backup of {when} and saves what is left"
