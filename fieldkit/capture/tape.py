"""Keeping what arrives before anybody looks at it: an append-only file of bytes and a journal beside it.

`NAME.raw` holds the bytes as they came, nothing else. `NAME.jsonl` holds one JSON object a line: first the device,
the port, the settings and the time, then what was sent, when bytes arrived, when the port was lost and opened
again; each with `at`, the number of bytes on tape by then, and `t`, seconds since the capture began. Both are only
appended to and synchronized with the disk a few times a second, so neither a kill nor a power cut takes more than
the last instant.
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

SYNC = 0.25
"""Bytes are on the disk at most this long after they came. [s]"""
GRAIN = 0.02
"""Arrivals closer together than this share one line of the journal. [s]"""
BYTES, JOURNAL = ".raw", ".jsonl"
"""Suffixes of the two files of a capture."""


@dataclass(slots=True)
class Tape:
    """An open capture. Make one with `begin` or `go_on`; close it, or use it as a context."""

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
        """Keep bytes that arrived just now. Raises CaptureTrouble if the disk takes no more."""
        self._append(self._raw, chunk)
        self.size += len(chunk)
        self.tick()

    def note(self, **facts: object) -> None:
        """Keep what happened at this place of the tape, in JSON types; nothing but the time without facts."""
        now = time.monotonic()
        line = {"at": self.size, "t": round(now - self._start, 3), **facts}
        self._marked, self._marked_size = now, self.size
        self._append(self._journal, json.dumps(line).encode() + b"\n")

    def tick(self) -> None:
        """Note when bytes came, bring to the disk what is due; to be called also when nothing arrives."""
        if self.size != self._marked_size and time.monotonic() - self._marked >= GRAIN:
            self.note()
        if self._dirty and time.monotonic() - self._synced >= SYNC:
            self._sync()

    def close(self) -> None:
        """Bring everything to the disk and let go of the files. Raises CaptureTrouble if the disk failed since the
        capture began: a disk that fails once does not end a capture, since a logger may send its flight only once."""
        if self._raw.closed:
            return
        self._sync()
        self._raw.close()
        self._journal.close()
        if self._failed:
            raise CaptureTrouble(f"{self.file}: the disk failed ({self._failed}); some of the capture may not be saved")

    def discard_if_empty(self) -> None:
        """Close, and leave nothing behind if nothing ever came."""
        self.close()
        if not self.size:
            self.file.unlink(missing_ok=True)
            self.file.with_suffix(JOURNAL).unlink(missing_ok=True)

    def _append(self, file: FileIO, content: bytes) -> None:
        self._dirty = True
        try:
            while content:
                content = content[file.write(content) :]
        except OSError as error:
            raise CaptureTrouble(
                f"{self.file}: cannot be written ({error.strerror}); what was received before is saved"
            ) from error

    def _sync(self) -> None:
        try:
            os.fsync(self._raw.fileno())
            os.fsync(self._journal.fileno())
        except OSError as error:
            self._failed = error.strerror or str(error)
        self._dirty, self._synced = False, time.monotonic()


def begin(folder: Path, about: Mapping[str, object]) -> Tape:
    """A new capture in a folder, made if it is not there, named after the time.

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
    """Bring the names of new files to the disk, on systems where that is a step of its own."""
    if os.name == "posix":
        names = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(names)
        finally:
            os.close(names)


def _new(folder: Path, name: str) -> tuple[Path, FileIO]:
    """A file of this name, or of this name and a number, that was not there before."""
    for number in range(1, 1000):
        file = folder / f"{name}{f'-{number}' if number > 1 else ''}{BYTES}"
        try:
            return file, FileIO(file, "x")
        except FileExistsError:
            continue
    raise OSError(None, "a thousand captures in one second")


def go_on(file: Path, began: datetime) -> Tape:
    """A capture that continues where it ended, after what its files hold. Raises CaptureTrouble."""
    try:
        raw = FileIO(file, "a")
        journal = FileIO(file.with_suffix(JOURNAL), "a")
    except OSError as error:
        raise CaptureTrouble(f"{file}: cannot continue ({error.strerror})") from error
    passed = max(0.0, (datetime.now().astimezone() - began).total_seconds())
    tape = Tape(file, raw, journal, began, raw.seek(0, os.SEEK_END), time.monotonic() - passed)
    tape._marked_size = tape.size
    if journal.seek(0, os.SEEK_END):
        tape._append(journal, b"\n")  # its last line may be torn
    return tape
