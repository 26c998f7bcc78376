"""The definition of a protocol, and the registry of protocols: one file each in `fieldkit/capture/protocols`.

A protocol that only listens needs just that file. One that sends commands also needs them in the table of
`fieldkit/capture/commands.py`, which is separate on purpose.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fieldkit.capture.captured import Captured, Log, read_capture
from fieldkit.capture.events import Stored
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import Dialogue, Link
from fieldkit.errors import CaptureTrouble, PortTrouble, unknown
from fieldkit.plugins import plugins
from fieldkit.quantities import counted


def everything(flights: Sequence[Stored]) -> Sequence[int]:
    """All flights of a logger."""
    return [flight.number for flight in flights]


@dataclass(frozen=True, slots=True)
class CaptureOptions:
    """The user's choices; None leaves the value to the protocol."""

    choose: Callable[[Sequence[Stored]], Sequence[int]] = everything
    """Given the flights in memory, the numbers of those to read."""
    live: bool = False
    """Record telemetry if the unit has both memory and telemetry."""
    frequency: float | None = None
    """Frequency of a radio. [Hz]"""
    baud: int | None = None
    """Rate of the port. [baud]"""
    wait: float | None = None
    """How long to wait for a unit that sends unprompted. [s]"""
    silence: float | None = None
    """How long a stream may pause before it ends. [s]"""
    seconds: float | None = None
    """Time limit of the whole capture, None for no limit. [s]"""
    reconnect: float = 20.0
    """How long to wait for a lost port. [s]"""


def as_it_came(captured: Captured) -> list[Log]:
    """The whole capture as one log, unchanged."""
    return [Log(captured.file.name, captured.raw)] if captured.raw else []


def unheard(heard: bytes) -> bool:
    """Always False: this protocol cannot be recognized from unprompted bytes."""
    return False


@dataclass(frozen=True, slots=True)
class Protocol:
    """One kind of unit on a serial port.

    `dialogue` reads everything and returns whether it is complete; when a lost unit returns, it is called again with
    the capture so far. `recognizes_stream` returns whether bytes that the unit sent unprompted can only come from it.
    `logs` extracts the logs for parsers from a capture. Both must handle noise and torn pieces without raising.
    """

    title: str
    settings: PortSettings
    dialogue: Callable[[Link, CaptureOptions, Captured], Dialogue[bool]]
    logs: Callable[[Captured], list[Log]] = as_it_came
    recognizes_stream: Callable[[bytes], bool] = unheard
    invites: str = ""
    """An instruction for the user, shown when the port is open."""
    usb: frozenset[tuple[int, int]] = frozenset()
    """Vendor and product numbers that only its units have."""


NOT_PUBLIC: Mapping[str, str] = {
    "pnut": "the download of Pnut and StratoLogger is not public; save the flight as .pf2 with PerfectFlite's "
    "own program and import that file",
    "rrc3": "the download of the RRC3 is not public; export the flight from Missile Works' mDACS and import that file",
    "aim": "the download of the AIM is not public; export the flight as CSV from Entacore's own program and "
    "import that file",
}
"""Devices that may be asked for but cannot be captured, with the alternative."""


def known_devices() -> Mapping[str, Protocol]:
    """Every protocol in the folder, by the name that `--device` takes."""
    found = plugins("capture.protocols", "PROTOCOL")
    for name, protocol in found.items():
        if not isinstance(protocol, Protocol):
            raise TypeError(f"PROTOCOL of capture/protocols/{name}.py is not a Protocol")
    return found  # type: ignore[return-value]


def known_device(name: str) -> Protocol:
    """The protocol with a name. Raises PortTrouble that suggests the nearest."""
    plain = name.strip().lower().replace("-", "_").replace(" ", "_")
    if plain in known_devices():
        return known_devices()[plain]
    if plain in NOT_PUBLIC:
        raise PortTrouble(f"{plain}: {NOT_PUBLIC[plain]}")
    raise PortTrouble(unknown("device", name, known_devices()))


def logs_in(file: Path) -> list[Log]:
    """The logs in a capture, ready for parsers, given either of its files. Raises CaptureTrouble."""
    captured = read_capture(file)
    found = known_devices().get(captured.device) or _sender_of(captured.raw)
    logs = found.logs(captured) if found else as_it_came(captured)
    if not logs:
        raise CaptureTrouble(
            f"{captured.file.name}: found no flight in {counted(len(captured.raw), 'byte')}, expected at least one"
        )
    return logs


def _sender_of(raw: bytes) -> Protocol | None:
    """The only protocol that can have sent these bytes, for a journal that does not name it."""
    fitting = [one for one in known_devices().values() if one.recognizes_stream(raw)]
    return fitting[0] if len(fitting) == 1 else None
