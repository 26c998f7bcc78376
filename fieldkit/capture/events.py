"""Events that a running capture reports to whatever displays it: a terminal line, a screen, a test."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Sample:
    """The latest telemetry values; None for values that the stream does not carry."""

    altitude: float
    """Height above the pad. [m]"""
    time: float | None = None
    """Time on the logger's own clock. [s]"""
    speed: float | None = None
    """Upward speed. [m/s]"""
    state: str = ""
    """Flight phase as named by the logger."""


@dataclass(frozen=True, slots=True)
class Stored:
    """A flight in a logger's memory, by the logger's flight number."""

    number: int
    about: str = ""
    """The logger's description of it, for a selection list."""


@dataclass(frozen=True, slots=True)
class PortOpened:
    """A port was opened; every byte from now on is saved to `file`. `device` is empty until it is known."""

    port: str
    device: str
    file: Path


@dataclass(frozen=True, slots=True)
class Recognised:
    """The device on the port was recognized from its bytes."""

    device: str


@dataclass(frozen=True, slots=True)
class Instruction:
    """An instruction or a note for the user, in one line."""

    text: str


@dataclass(frozen=True, slots=True)
class FlightsListed:
    """The flights in the logger's memory, and which of them will be read."""

    flights: tuple[Stored, ...]
    chosen: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress of a capture, a few times per second; all counts are for this run."""

    bytes: int
    samples: int = 0
    """Samples, or lines of samples, received intact. [1]"""
    damaged: int = 0
    """Pieces received damaged: a wrong checksum, a torn line, noise. [1]"""
    fraction: float | None = None
    """Fraction received, if the total is known. [1]"""
    sample: Sample | None = None


@dataclass(frozen=True, slots=True)
class Lost:
    """The port has disappeared; everything received is saved, and the capture waits for a reconnection."""

    port: str
    why: str


@dataclass(frozen=True, slots=True)
class Back:
    """The unit has returned, perhaps on another port."""

    port: str


@dataclass(frozen=True, slots=True)
class Ended:
    """The last event: what was saved, and why the capture ended. `whole` is True if nothing is missing."""

    file: Path
    device: str
    bytes: int
    samples: int
    damaged: int
    why: str
    whole: bool
    about: Mapping[str, str] = field(default_factory=dict)
    """What the unit reports about itself."""


CaptureEvent = PortOpened | Recognised | Instruction | FlightsListed | Progress | Lost | Back | Ended
