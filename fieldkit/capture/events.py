"""Events that a running capture reports to its display: a line in a terminal, a screen, a test."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Sample:
    """The newest figures of a telemetry stream; what it does not carry is None."""

    altitude: float
    """Height above the pad. [m]"""
    time: float | None = None
    """Time on the logger's own clock. [s]"""
    speed: float | None = None
    """Upward speed. [m/s]"""
    state: str = ""
    """The phase of flight, in the logger's words."""


@dataclass(frozen=True, slots=True)
class Stored:
    """A flight in a logger's memory, by the number that the logger has for it."""

    number: int
    about: str = ""
    """The logger's description of it, for a list to choose from."""


@dataclass(frozen=True, slots=True)
class PortOpened:
    """A port is open; every byte from now on goes to `file`. `device` is empty while it is not known."""

    port: str
    device: str
    file: Path


@dataclass(frozen=True, slots=True)
class Recognised:
    """The device on the port was recognized from its bytes."""

    device: str


@dataclass(frozen=True, slots=True)
class Instruction:
    """An instruction or a fact for the flyer, in one line."""

    text: str


@dataclass(frozen=True, slots=True)
class FlightsListed:
    """The flights in the logger's memory, and those of them that will be read."""

    flights: tuple[Stored, ...]
    chosen: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a capture is, a few times a second: all counts are of this run."""

    bytes: int
    samples: int = 0
    """Samples, or lines of them, received intact. [1]"""
    damaged: int = 0
    """Pieces that were not: a wrong checksum, a torn line, noise. [1]"""
    share: float | None = None
    """Fraction received, if the total is known. [1]"""
    sample: Sample | None = None


@dataclass(frozen=True, slots=True)
class Lost:
    """The port has disappeared; everything received is saved, and a reconnection is awaited."""

    port: str
    why: str


@dataclass(frozen=True, slots=True)
class Back:
    """The unit has returned, perhaps on another port."""

    port: str


@dataclass(frozen=True, slots=True)
class Ended:
    """The last event: what was kept, and why it ended there. `whole` is True when nothing is missing."""

    file: Path
    device: str
    bytes: int
    samples: int
    damaged: int
    why: str
    whole: bool
    about: Mapping[str, str] = field(default_factory=dict)
    """What the unit reports about itself."""


Event = PortOpened | Recognised | Instruction | FlightsListed | Progress | Lost | Back | Ended
