"""Save what arrives before it is decoded: an append-only file of bytes, with a journal next to it.

`NAME.raw` contains the bytes as received and nothing else. `NAME.jsonl` contains one JSON object per line: first the
device, the port, the settings and the time, then what was sent, when bytes arrived, and when the port was lost and
reopened. Each has `at`, the number of bytes saved by then, and `t`, seconds since the capture started. Both are only
appended to, and synchronized with the disk a few times per second, so a kill or a power failure loses at most the last
instant.
"""

import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from io import FileIO
from pathlib import Path
from types import TracebackType

from fieldkit.errors import CaptureTrouble
from fieldkit.paths import CAPTURE_SUFFIXES

SYNC = 0.25
"""Longest time from the arrival of bytes until they are on disk. [s]"""
GRAIN = 0.02
"""Bytes that arrive closer together than this share one line of the journal. [s]"""
BYTES, JOURNAL = CAPTURE_SUFFIXES


@dataclass(slots=True)
class Tape:
    """An open capture. Make one with `begin` or `go_on`; close it, or use it in a `with` statement."""

    file: Path
    _raw: FileIO
    _journal: FileIO
    began: datetime
    size: int = 0
    _start: float = 0.0
    _marked: float = field(default=float("-inf"))
    _marked_size: int = 0
    _synced: float = 0.0
    _dirty: bool = False
    _failed: str = ""

    def __enter__(self) -> "Tape":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def heard(self, chunk: bytes) -> None:
        """Save bytes that just arrived. Raises CaptureTrouble if they cannot be written."""
        self._append(self._raw, chunk)
        self.size += len(chunk)
        self.tick()

    def note(self, **facts: object) -> None:
        """Record an event at this position, in JSON types; without facts, only the time. Raises CaptureTrouble."""
        now = time.monotonic()
        line = {"at": self.size, "t": round(now - self._start, 3), **facts}
        self._marked, self._marked_size = now, self.size
        self._append(self._journal, json.dumps(line).encode() + b"\n")

    def tick(self) -> None:
        """Record arrival times, and synchronize with the disk if due; call it regularly even if nothing arrives."""
        if self.size != self._marked_size and time.monotonic() - self._marked >= GRAIN:
            self.note()
        if self._dirty and time.monotonic() - self._synced >= SYNC:
            self._sync()

    def close(self) -> None:
        """Write everything to disk and close the files. Raises CaptureTrouble if the disk failed at any time during the
        capture: a failure does not end a capture at that moment, because a logger may send its flight only once."""
        if self._raw.closed:
            return
        self._sync()
        self._raw.close()
        self._journal.close()
        if self._failed:
            raise CaptureTrouble(f"{self.file}: the disk failed ({self._failed}); some of the capture may not be saved")

    def discard_if_empty(self) -> None:
        """Close, and delete the files if nothing ever arrived."""
        self.close()
        if not self.size:
            self.file.unlink(missing_ok=True)
            self.file.with_suffix(JOURNAL).unlink(missing_ok=True)

    def _append(self, file: FileIO, content: bytes) -> None:
        """Write all bytes to the end of a file. Raises CaptureTrouble."""
        self._dirty = True
        try:
            while content:
                content = content[file.write(content) :]
        except OSError as error:
            raise CaptureTrouble(
                f"{self.file}: cannot be written ({error.strerror}); what was received before is saved"
            ) from error

    def _sync(self) -> None:
        """Synchronize both files with the disk; a failure is reported by `close`."""
        try:
            os.fsync(self._raw.fileno())
            os.fsync(self._journal.fileno())
        except OSError as error:
            self._failed = error.strerror or str(error)
        self._dirty, self._synced = False, time.monotonic()


def begin(folder: Path, about: Mapping[str, object]) -> Tape:
    """Start a capture in a folder, created if needed, with files named after the time.

    `about` is the first line of its journal. Raises CaptureTrouble.
    """
    began = datetime.now().astimezone()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file, raw = _new(folder, f"{began:%Y%m%d-%H%M%S}")
        journal = FileIO(file.with_suffix(JOURNAL), "x")
    except OSError as error:
        raise CaptureTrouble(f"{folder}: no capture can be saved here ({error.strerror})") from error
    tape = Tape(file, raw, journal, began, _start=time.monotonic())
    tape.note(capture=1, began=began.isoformat(timespec="milliseconds"), **about)
    tape._sync()
    try:
        _sync_names(folder)
    except OSError as error:
        tape._failed = error.strerror or str(error)
    return tape


def _sync_names(folder: Path) -> None:
    """Write the names of new files to disk, on systems that need a separate step for it."""
    if os.name == "posix":
        names = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(names)
        finally:
            os.close(names)


def _new(folder: Path, name: str) -> tuple[Path, FileIO]:
    """Create a file with this name, or with this name and a number if it exists."""
    for number in range(1, 1000):
        file = folder / f"{name}{f'-{number}' if number > 1 else ''}{BYTES}"
        try:
            return file, FileIO(file, "x")
        except FileExistsError:
            continue
    raise OSError(None, "a thousand captures in one second")


def go_on(file: Path, began: datetime) -> Tape:
    """Resume a capture, which `began` then, at the end of its files. Raises CaptureTrouble."""
    try:
        raw = FileIO(file, "a")
        journal = FileIO(file.with_suffix(JOURNAL), "a")
    except OSError as error:
        raise CaptureTrouble(f"{file}: cannot continue ({error.strerror})") from error
    passed = max(0.0, (datetime.now().astimezone() - began).total_seconds())
    tape = Tape(file, raw, journal, began, raw.seek(0, os.SEEK_END), time.monotonic() - passed)
    tape._marked_size = tape.size
    if journal.seek(0, os.SEEK_END):
        tape._append(journal, b"\n")  # the previous last line may be torn
    return tape
