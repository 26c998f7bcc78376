"""Events that a running capture reports to whatever shows them: a line in a terminal, a screen, a test."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Sample:
    """The newest figures of a telemetry stream; what it does not carry is None."""

    altitude: float
    """Above the pad. [m]"""
    time: float | None = None
    """On the logger's own clock. [s]"""
    speed: float | None = None
    """Upwards. [m/s]"""
    state: str = ""
    """The phase of flight, in the logger's words."""


@dataclass(frozen=True, slots=True)
class Stored:
    """A flight in a logger's memory, by the number that the logger has for it."""

    number: int
    about: str = ""
    """What the logger says of it, for a list to choose from."""


@dataclass(frozen=True, slots=True)
class PortOpened:
    """A port is open; every byte from now on goes to `file`. `device` is empty while it is not known."""

    port: str
    device: str
    file: Path


@dataclass(frozen=True, slots=True)
class Recognised:
    """What is on the port is known by what was heard from it."""

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
    """Samples, or lines of them, that arrived whole."""
    damaged: int = 0
    """Pieces that did not: a wrong checksum, a torn line, noise."""
    share: float | None = None
    """Of all that is to come, if that is known. [1]"""
    sample: Sample | None = None


@dataclass(frozen=True, slots=True)
class Lost:
    """The port is gone; all that came is kept, and a reconnection is waited for."""

    port: str
    why: str


@dataclass(frozen=True, slots=True)
class Back:
    """The unit is there again, perhaps on another port."""

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
