"""Copies of a ledger's file, kept in a folder beside it: the last ten, in rotation.

A copy is made by SQLite's own backup call, so that it is whole while another process writes, and it counts only
once SQLite and the checksums of its rows have found it sound: a damaged ledger never pushes a good copy out. Copies
are numbered, for a clock may go backwards. A ledger on a server is backed up by whoever runs the server.
"""

import os
import re
import shutil
import sqlite3
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from fieldkit.errors import LedgerError
from fieldkit.files import BACKUPS
from fieldkit.ledger.soundness import fault, opened

KEPT = 10
"""So many copies are kept. [1]"""
ROOM = 1 << 30
"""Copies beyond the newest two go where all together are larger. [byte]"""
EVERY = 50
"""So many changes since the last copy call for another on the same day. [1]"""
ABANDONED = 3600.0
"""A half-made copy this old is nobody's any more. [s]"""

_NAME = re.compile(r"(\d{6,})_(\d{8}T\d{6}Z)_(\d+)\.db")
_STAMP = "%Y%m%dT%H%M%SZ"


@dataclass(frozen=True, slots=True)
class Backup:
    """One copy; `number` counts up from 1 and `changes` is the length of the ledger's journal in it."""

    file: Path
    number: int
    at: datetime
    changes: int

    @property
    def size(self) -> int:
        """Of the file. [byte]"""
        return self.file.stat().st_size

    @property
    def flights(self) -> int | None:
        """How many flights it holds, None where it is damaged itself. [1]"""
        try:
            with opened(self.file) as copy:
                return int(copy.execute("SELECT count(*) FROM flights").fetchone()[0])
        except sqlite3.DatabaseError:
            return None


def folder_of(file: Path) -> Path:
    """Where the copies of a ledger are, which may not be there."""
    return file.with_name(f"{file.name}{BACKUPS}")


def backups(file: Path) -> list[Backup]:
    """The copies of a ledger, newest first."""
    folder = folder_of(file)
    found = [_backup(one, match) for one in _listed(folder) if (match := _NAME.fullmatch(one.name))]
    return sorted(found, key=lambda one: (one.number, one.at), reverse=True)


def _listed(folder: Path) -> list[Path]:
    return list(folder.iterdir()) if folder.is_dir() else []


def _backup(file: Path, match: re.Match[str]) -> Backup:
    at = datetime.strptime(match[2], _STAMP).replace(tzinfo=UTC)
    return Backup(file, int(match[1]), at, int(match[3]))


def is_due(file: Path, changes: int) -> bool:
    """Whether to copy a ledger with so many changes before the next one: on a new day, or after many."""
    newest = next(iter(backups(file)), None)
    if newest is None or not changes:
        return bool(changes)
    return newest.at.date() != datetime.now(UTC).date() or abs(changes - newest.changes) >= EVERY


def take(ledger: sqlite3.Connection, file: Path, changes: int) -> Backup:
    """Copy an open ledger, and let the oldest copies go.

    Raises LedgerError where the ledger is damaged; OSError or sqlite3.Error where no copy can be made.
    """
    taken = _take(ledger, file, changes)
    _rotate(file)
    return taken


def _take(ledger: sqlite3.Connection, file: Path, changes: int) -> Backup:
    folder = folder_of(file)
    folder.mkdir(exist_ok=True)
    last = next(iter(backups(file)), None)
    number, at = (last.number if last else 0) + 1, datetime.now(UTC)
    with _beside(folder) as new:
        _copy(ledger, new)
        if found := fault(new, since=last.file if last else None):
            raise LedgerError(f"{file}: the file is damaged ({found}); {offer(file)}")
        kept = folder / f"{number:06d}_{at:{_STAMP}}_{changes}.db"
        os.replace(new, kept)
    return Backup(kept, number, at, changes)


@contextmanager
def _beside(folder: Path) -> Iterator[Path]:
    """A file for a copy in the making, gone at the end unless it was renamed; so are those of killed processes."""
    for old in folder.glob("*.new*"):
        if time.time() - old.stat().st_mtime > ABANDONED:
            old.unlink(missing_ok=True)
    handle, name = tempfile.mkstemp(suffix=".new", dir=folder)
    os.close(handle)
    try:
        yield Path(name)
    finally:
        Path(name).unlink(missing_ok=True)


def _copy(ledger: sqlite3.Connection, target: Path) -> None:
    """Copy a whole database into a file, as one transaction that is on the disc at the end."""
    with opened(target) as copy:
        copy.execute("PRAGMA synchronous = EXTRA")
        ledger.backup(copy)


def _rotate(file: Path) -> None:
    kept = backups(file)
    while len(kept) > KEPT or (len(kept) > 2 and sum(one.size for one in kept) > ROOM):
        kept.pop().file.unlink(missing_ok=True)


def offer(file: Path) -> str:
    """What can be done about a damaged ledger, for the end of a message."""
    newest = next(iter(backups(file)), None)
    if newest is None:
        return "no backup of it is kept; `sqlite3 FILE .recover` may save some of it"
    when = f"{newest.at.astimezone():%Y-%m-%d %H:%M}"
    return f"`fieldkit backups restore` puts back the copy of {when} and keeps what is left"


def restore(file: Path, backup: Backup) -> Path | None:
    """Put a copy in a ledger's place; where what was there is kept now, None if that was nothing.

    A sound ledger becomes the newest copy, so that another restore takes this one back. A damaged file is put
    aside, with what SQLite's journal held for it. A kill leaves the ledger as it was or as it will be.
    Raises LedgerError where the copy is damaged itself or the disc takes no more.
    """
    try:
        if found := fault(backup.file):
            raise LedgerError(f"{backup.file}: this copy is damaged too ({found}); restore another one")
        if not file.exists() or not file.stat().st_size:
            return _put_aside(file, backup, keep=False)
        changes = None if fault(file, since=backup.file) else _changes(file)
        return _put_aside(file, backup) if changes is None else _overwrite(file, backup, changes)
    except (OSError, sqlite3.Error) as error:
        raise LedgerError(f"{file}: cannot be restored ({error}); nothing was changed") from error


def _changes(file: Path) -> int | None:
    """The length of a ledger's journal; None where SQLite finds nothing wrong with a file that has lost it. [1]"""
    with opened(file) as ledger:
        if not ledger.execute("SELECT 1 FROM sqlite_master WHERE name = 'journal'").fetchone():
            return None
        return int(ledger.execute("SELECT coalesce(max(number), 0) FROM journal").fetchone()[0])


def _overwrite(file: Path, backup: Backup, changes: int) -> Path:
    """Change a sound ledger into a copy, as one transaction that other processes see."""
    with opened(file) as now, opened(backup.file) as then:
        kept = _take(now, file, changes)
        _copy(then, file)
    _rotate(file)
    return kept.file


def _put_aside(file: Path, backup: Backup, *, keep: bool = True) -> Path | None:
    """Put a copy in a damaged file's place, which keeps its bytes under another name."""
    with _beside(folder_of(file)) as new:
        with opened(backup.file) as then:
            _copy(then, new)
        aside = file.with_name(f"{file.name}.damaged-{datetime.now(UTC):{_STAMP}}")
        if keep:
            shutil.copy2(file, aside)
        journal = file.with_name(f"{file.name}-journal")
        if journal.exists():  # it would be played back into the copy
            os.replace(journal, aside.with_name(f"{aside.name}-journal"))
        os.replace(new, file)
    return aside if keep else None
