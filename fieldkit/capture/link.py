"""A line as protocols use it: pieces between marks, timeouts, progress counts, and a way to stop.

A protocol is a generator: it yields events, and waits with `yield from`, which keeps the display responsive while
nothing arrives. Silence is measured from the last byte received.
"""

import time
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import TypeVar

from fieldkit.capture.events import CaptureEvent, Progress, Sample
from fieldkit.capture.line import SerialLine
from fieldkit.errors import PortLost, PortTrouble

MAX_PIECE = 4096
"""Size limit of a piece between two marks; only the end of a longer piece, which is noise, is used. [byte]"""
NOISE = 4
"""Noise ends a wait after this many times the silence timeout. [1]"""
PROGRESS_INTERVAL = 0.2
"""Time between two progress reports. [s]"""

T = TypeVar("T")
Dialogue = Generator[CaptureEvent, None, T]
"""A dialogue, or a part of one: yields events and returns a result."""


class Stopped(Exception):
    """The user, or the time limit, ended the capture."""


def never() -> bool:
    """A stop check that never stops."""
    return False


@dataclass(slots=True)
class Link:
    """Our end of a dialogue, with the counts of a whole capture, which may use several lines in turn."""

    line: SerialLine
    stop: Callable[[], bool] = never
    ends: float = float("inf")
    """Time limit, on the monotonic clock. [s]"""
    samples: int = 0
    damaged: int = 0
    open_ended: bool = False
    """Whether only the user knows when the capture is over; stopping it then loses nothing."""
    fraction: float | None = None
    sample: Sample | None = None
    about: dict[str, str] = field(default_factory=dict)
    heard: int = 0
    """Number of bytes received in this run. [byte]"""
    _pending: bytearray = field(default_factory=bytearray)
    _searched: int = 0
    """Number of pending bytes in which `piece` found no mark. [byte]"""
    _reported: float = field(default=float("-inf"))

    def send(self, command: bytes) -> None:
        """Send a command from the table. Raises PortLost."""
        self.line.send(command)

    def last_command(self, command: bytes) -> None:
        """Send a last command, if the unit is still connected."""
        try:
            self.line.send(command)
        except PortLost:
            return

    def progress(self) -> Progress:
        """Progress of the capture."""
        return Progress(self.heard, self.samples, self.damaged, self.fraction, self.sample)

    def hear(self) -> Dialogue[bytes]:
        """The bytes pushed back or, without any, those that have arrived, possibly none.

        Raises Stopped, and the errors of `SerialLine.hear`.
        """
        if self.stop():
            raise Stopped("stopped")
        if time.monotonic() >= self.ends:
            raise Stopped("time limit reached")
        if self._pending:
            chunk = bytes(self._pending)
            self._pending.clear()
            self._searched = 0
            return chunk
        chunk = self.line.hear()
        self.heard += len(chunk)
        if time.monotonic() - self._reported >= PROGRESS_INTERVAL:
            self._reported = time.monotonic()
            yield self.progress()
        return chunk

    def push_back(self, chunk: bytes) -> None:
        """Push received bytes back, to be returned before new ones."""
        self._pending[:0] = chunk
        self._searched = 0

    def forget(self) -> None:
        """Discard received bytes that were not read, because their port has disappeared."""
        self._pending.clear()
        self._searched = 0

    def first_word(self, wait: float, asked: str) -> Dialogue[None]:
        """Wait for the first byte. Raises PortTrouble after `wait` [s], whose message ends with what the user is
        `asked` to do."""
        began = time.monotonic()
        while time.monotonic() - began < wait:
            chunk = yield from self.hear()
            if chunk:
                self.push_back(chunk)
                return
        raise PortTrouble(f"{self.line.name}: received nothing in {wait:.0f} s; {asked}")

    def piece(self, mark: bytes, silence: float) -> Dialogue[bytes | None]:
        """The bytes up to the next mark, without it; None after `silence` [s], or after four times that of noise."""
        began = quiet_since = time.monotonic()
        over = False
        while True:
            at = self._pending.find(mark, max(0, self._searched - len(mark) + 1))
            if at >= 0:
                found = bytes(self._pending[:at])
                del self._pending[: at + len(mark)]
                self._searched = 0
                return found[-MAX_PIECE:]
            held = bytes(self._pending)
            if len(held) > 2 * MAX_PIECE:
                held = held[-MAX_PIECE:]
                self.damaged += 1
            self._pending.clear()
            chunk = yield from self.hear()
            self._pending[:] = held + chunk
            self._searched = len(held)
            now = time.monotonic()
            if chunk:
                quiet_since = now
            elif over:
                return None
            over = now - quiet_since >= silence  # look once more: this computer may have slept, but not the unit
            if mark not in self._pending and now - began >= NOISE * silence:
                return None

    def text_line(self, silence: float) -> Dialogue[str | None]:
        """The next line without its line end, one character per byte; None after `silence` [s]."""
        found = yield from self.piece(b"\n", silence)
        return None if found is None else found.decode("latin-1").rstrip("\r")

    def drain(self, silence: float, patience: float = NOISE) -> Dialogue[bytes]:
        """Read until nothing arrives for `silence` [s], or for `patience` times that if there is noise; returns at most
        `MAX_PIECE` of the last bytes."""
        heard = bytearray()
        began = quiet_since = time.monotonic()
        while time.monotonic() - quiet_since < silence and time.monotonic() - began < patience * silence:
            chunk = yield from self.hear()
            if chunk:
                heard += chunk
                del heard[:-MAX_PIECE]
                quiet_since = time.monotonic()
        return bytes(heard)
