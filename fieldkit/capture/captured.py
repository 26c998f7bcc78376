"""Read back captures: the bytes, the commands sent and their times, and the logs."""

import json
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from math import isfinite
from pathlib import Path

from fieldkit.capture.tape import BYTES, JOURNAL
from fieldkit.errors import CaptureTrouble
from fieldkit.files import read


@dataclass(frozen=True, slots=True)
class TapeMark:
    """A line of the journal: `at` bytes had been saved `time` seconds after the capture started."""

    at: int
    time: float
    facts: Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Response:
    """The bytes between a command and the next one; the command is empty before the first."""

    command: bytes
    content: bytes


@dataclass(frozen=True, slots=True)
class Captured:
    """A capture on disk, even if the program that wrote it was killed."""

    file: Path
    raw: bytes
    marks: tuple[TapeMark, ...] = ()

    def fact(self, name: str) -> object:
        """The newest value of a fact in the journal, None if there is none."""
        return next((mark.facts[name] for mark in reversed(self.marks) if name in mark.facts), None)

    @property
    def device(self) -> str:
        """The protocol of the capture, empty if it was never determined."""
        return str(self.fact("device") or "")

    @property
    def began(self) -> datetime | None:
        """Start of the capture, with its offset from UTC; None if the journal does not state it."""
        try:
            return datetime.fromisoformat(str(self.fact("began"))).astimezone()
        except (ValueError, OverflowError):
            return None

    @property
    def whole(self) -> bool:
        """Whether the capture ended with everything received."""
        return self.fact("whole") is True

    def answers(self) -> list[Response]:
        """The bytes, split where a command was sent."""
        marks = [mark for mark in self.marks if "sent" in mark.facts]
        sent = [(min(mark.at, len(self.raw)), str(mark.facts["sent"]).encode("latin-1")) for mark in marks]
        starts = [(0, b""), *sent]
        ends = [at for at, _ in sent] + [len(self.raw)]
        return [Response(command, self.raw[at:end]) for (at, command), end in zip(starts, ends, strict=True)]

    def received_at(self, offsets: Iterable[int]) -> list[float]:
        """Arrival times of the bytes at these offsets, since the start of the capture; 0 without a journal. [s]"""
        counts = [mark.at for mark in self.marks]
        places = (min(bisect_right(counts, offset), len(counts) - 1) for offset in offsets)
        return [self.marks[place].time if counts else 0.0 for place in places]

    @property
    def breaks(self) -> list[int]:
        """Offsets at which bytes do not continue the earlier ones: the port was lost, or the capture resumed."""
        return [mark.at for mark in self.marks if mark.at and "port" in mark.facts]

    def lines(self) -> Iterator[tuple[int, bytes]]:
        """The complete lines, each with the offset of the byte that ends it, without lines torn by a break.

        The remains of two torn lines look like one line: `16` of `160` and `300` would read 16300.
        """
        start, breaks = 0, self.breaks
        for line in self.raw.split(b"\n")[:-1]:
            end = start + len(line)
            torn = bisect_left(breaks, start) < bisect_right(breaks, end)
            start = end + 1
            if not torn:
                yield end, line

    @property
    def untorn(self) -> bytes:
        """The bytes as received, without lines torn by a break."""
        if not self.breaks:
            return self.raw
        return b"\n".join([*(line for _, line in self.lines()), self.raw[self.raw.rfind(b"\n") + 1 :]])


@dataclass(frozen=True, slots=True)
class Log:
    """A log from a capture, ready for a parser."""

    name: str
    content: bytes


def is_capture(file: Path) -> bool:
    """Whether a file is one of the two files of a capture, and both exist."""
    return file.suffix in (BYTES, JOURNAL) and file.with_suffix(BYTES).is_file() and file.with_suffix(JOURNAL).is_file()


def read_capture(file: Path) -> Captured:
    """Read a capture, given either file. Raises CaptureTrouble; a damaged journal is read as far as possible."""
    try:
        raw = read(file.with_suffix(BYTES), plain=True)
        journal = read(file.with_suffix(JOURNAL), plain=True)
    except OSError as error:
        raise CaptureTrouble(f"{file}: cannot be read ({error.strerror})") from error
    marks = tuple(mark for line in journal.splitlines() if (mark := _mark(line)))
    return Captured(file.with_suffix(BYTES), raw, marks)


def _mark(line: bytes) -> TapeMark | None:
    """The mark in a line of the journal; None if the line is damaged."""
    try:
        facts = json.loads(line)
        mark = TapeMark(int(facts.pop("at")), float(facts.pop("t")), facts)
    except (ValueError, OverflowError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return mark if mark.at >= 0 and isfinite(mark.time) else None


def captures(folder: Path) -> list[Path]:
    """The captures in a folder, newest last."""
    return [file for file in sorted(folder.glob(f"*{BYTES}"), key=_by_number) if is_capture(file)]


def _by_number(file: Path) -> list[str | int]:
    """Sort key of a name by its numbers: a capture that starts within the second of another has a number after it."""
    parts = re.split(r"([0-9]+)", file.stem)  # every second one is a number
    return [int(part) if place % 2 else part for place, part in enumerate(parts)]


def unfinished(folder: Path) -> Path | None:
    """The newest incomplete capture, None if there is none. Raises CaptureTrouble."""
    return next((file for file in reversed(captures(folder)) if not read_capture(file).whole), None)
