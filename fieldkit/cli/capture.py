"""`fieldkit capture`: download or record a logger on a serial port, and import it.

A running capture: counts and altitude, drawn in a terminal, otherwise printed as lines.
"""

import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from shlex import quote
from types import TracebackType
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.importing import GivenValues, complain_of, complain_of_names, say_next, say_receipt
from fieldkit.cli.numbers import not_negative
from fieldkit.cli.options import takes_lacking
from fieldkit.cli.screen import AsJson, complain, measured, print_json, print_table, say, system
from fieldkit.cli.session import MotorCheck, given_columns, open_ledger, read_settings
from fieldkit.errors import BadValue, CaptureTrouble, PortTrouble
from fieldkit.paths import capture_folder
from fieldkit.presentation.home_text import sparkline
from fieldkit.quantities import ShownUnits, counted
from fieldkit.safe_text import printable, whole_number

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.live import Live

    from fieldkit.capture import CaptureEvent, CaptureOptions, Ended, Port, Progress, Sample, Stored
    from fieldkit.services.imports import Receipt


STALE_ALTITUDE_AGE = 3.0
"""Age above which an altitude is marked as old. [s]"""
WIDTH = 60
"""Number of latest altitudes drawn. [1]"""


@dataclass(slots=True)
class View:
    """The display of a capture; a context that restores the terminal."""

    device: str = ""
    port: str = ""
    highest: float = float("-inf")
    heights: deque[float] = field(default_factory=lambda: deque(maxlen=WIDTH))
    last: "Sample | None" = None
    received_at: float = 0.0
    """When the last altitude arrived, on the monotonic clock. [s]"""
    _live: "Live | None" = None

    def __enter__(self) -> "View":
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.live import Live

            self._live = Live(console=Console(stderr=True), auto_refresh=False, transient=True)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.pause()

    def pause(self) -> None:
        """Release the terminal until the next event."""
        if self._live is not None:
            self._live.stop()

    def show(self, event: "CaptureEvent") -> None:
        """Show one event."""
        from fieldkit import capture
        from fieldkit.presentation.capture_text import event_line

        match event:
            case capture.PortOpened(port, device, _):
                self.device, self.port = device, port
            case capture.Recognised(device):
                self.device = device
            case capture.Back(port):
                self.port = port
            case capture.Progress():
                self._draw(event)
        if line := event_line(event):
            self._say(line)

    def _say(self, text: str) -> None:
        if self._live is None:
            complain(text)
        else:
            self._live.console.print(printable(text), markup=False, highlight=False, soft_wrap=True)

    def _draw(self, progress: "Progress") -> None:
        if progress.sample is not None and progress.sample != self.last:
            self.last, self.received_at = progress.sample, time.monotonic()
            self.highest = max(self.highest, progress.sample.altitude)
            self.heights.append(progress.sample.altitude)
        if self._live is not None:
            if not self._live.is_started:
                self._live.start()
            self._live.update(self._picture(progress), refresh=True)

    def _picture(self, progress: "Progress") -> "RenderableType":
        from rich.text import Text

        from fieldkit.presentation.capture_text import counts

        received = [*counts(progress), *([f"{progress.fraction:.0%}"] if progress.fraction is not None else [])]
        lines = [f"{self.device or 'listening'} on {self.port}   {', '.join(received)}"]
        if progress.sample is not None:
            altitude = measured("apogee", progress.sample.altitude)
            lines.append(f"altitude {altitude}   highest {measured('apogee', self.highest)}")
            lines.append(flight_line(progress.sample, time.monotonic() - self.received_at))
            lines.append(sparkline([*self.heights], WIDTH))
        return Text("\n".join(map(printable, lines)), no_wrap=True, overflow="ellipsis")


def flight_line(sample: "Sample", age: float) -> str:
    """Speed, state and, if it is old, age [s] of a sample."""
    parts = (
        [f"{'+' if sample.speed >= 0 else ''}{ShownUnits(system()).speed(sample.speed)}"]
        if sample.speed is not None
        else []
    )
    parts += [sample.state] if sample.state else []
    parts += [f"received {age:.0f} s ago"] if age > STALE_ALTITUDE_AGE else []
    return "   ".join(parts)


app = typer.Typer()


def capture(
    context: typer.Context,
    where: Annotated[
        list[str] | None,
        typer.Argument(metavar="PORT", help="The port; with --resume, also the capture.", show_default=False),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List serial ports and supported devices.")] = False,
    device: Annotated[str | None, typer.Option(help="The device on the port, if it is not recognized.")] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a capture; default: the newest unfinished one.")
    ] = False,
    flight: Annotated[
        list[int] | None, typer.Option(min=0, help="Read only this flight, as listed; can be repeated.")
    ] = None,
    live: Annotated[bool, typer.Option("--live", help="Record telemetry instead of reading the memory.")] = False,
    frequency: Annotated[
        float | None, typer.Option(callback=not_negative, metavar="MHZ", help="Frequency to tune a TeleDongle to.")
    ] = None,
    baud: Annotated[
        int | None, typer.Option(min=50, max=4_000_000, help="Baud rate, if not the unit's default.")
    ] = None,
    wait: Annotated[
        float | None,
        typer.Option(callback=not_negative, metavar="SECONDS", help="How long to wait for the first byte."),
    ] = None,
    silence: Annotated[
        float | None,
        typer.Option(callback=not_negative, metavar="SECONDS", help="Length of silence that ends a stream."),
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(callback=not_negative, metavar="SECONDS", help="Stop after this time.")
    ] = None,
    reconnect: Annotated[
        float, typer.Option(callback=not_negative, metavar="SECONDS", help="How long to wait for a lost unit.")
    ] = 20.0,
    import_: Annotated[
        bool | None,
        typer.Option("--import/--no-import", help="Import or do not import, without asking.", show_default=False),
    ] = None,
    given: GivenValues = None,
    json: AsJson = False,
    **named: str | None,
) -> None:
    """Read a logger on a serial port; Ctrl-C stops. Every byte is saved; nothing on the logger is ever changed."""
    from fieldkit.capture import CaptureOptions

    if list_:
        print_ports(json)
        return
    settings = given_columns(given, named)
    defaults = read_settings(settings, MotorCheck())
    if settings:
        with open_ledger(context) as ledger:  # before the download: a misspelled name is easier to correct now
            complain_of_names(ledger, settings)
    with _interrupt() as stop, View() as view:
        hertz = None if frequency is None else frequency * 1e6
        choose = _chooser(flight or (), view.pause, asks=sys.stdin.isatty() and not json)
        options = CaptureOptions(choose, live, hertz, baud, wait, silence, seconds, reconnect)
        end = _followed(_events(where or (), device, resume, options, stop), view.show)
    _print_end(end)
    empty = not end.bytes or (end.whole and not end.samples and not resume)
    receipt = None if empty else _received(context, end, import_, defaults, json)
    if json:
        print_json(_document(end, receipt))
    if not end.whole:
        raise typer.Exit(1)


takes_lacking(capture)
app.command()(capture)


def _followed(events: "Iterator[CaptureEvent]", show: "Callable[[CaptureEvent], None]") -> "Ended":
    """Show all events and return the last one."""
    for event in events:
        show(event)
    return event  # type: ignore[return-value]  # a capture ends with it or raises


def _events(
    where: Sequence[str], device: str | None, resume: bool, options: "CaptureOptions", stop: Callable[[], bool]
) -> "Iterator[CaptureEvent]":
    """The events of the requested capture. Raises PortTrouble or CaptureTrouble, and BadParameter for wrong usage."""
    from fieldkit import capture

    if device is not None:
        capture.known_device(device)
    if not resume:
        if len(where) > 1:
            raise typer.BadParameter(f"found {len(where)} ports, expected one")
        return capture.capture(_port(where, device), device, folder=capture_folder(), wishes=options, stop=stop)
    files = [file for text in where if (file := _capture_of(text)) is not None]
    names = [text for text in where if _capture_of(text) is None]
    if len(files) > 1 or len(names) > 1:
        raise typer.BadParameter(f"found {' '.join(where)!r}, expected one capture and one port at most")
    file = files[0] if files else _unfinished()
    return capture.resume(file, _port(names, device) if names else None, device, wishes=options, stop=stop)


def _capture_of(text: str) -> Path | None:
    """The capture that a text names, by its path or by its name in the user's folder, None for a port."""
    from fieldkit.capture import is_capture

    return next((file for file in (Path(text), capture_folder() / text) if is_capture(file)), None)


def _unfinished() -> Path:
    from fieldkit.capture import unfinished

    found = unfinished(capture_folder())
    if found is None:
        raise CaptureTrouble(f"{capture_folder()}: found no unfinished capture, expected one to continue")
    return found


def _port(names: Sequence[str], device: str | None) -> "Port":
    """The named port, or the only one that may have a logger. Raises PortTrouble that lists those ports."""
    from fieldkit.capture import Port, ports

    here = ports()
    if names and not names[0]:
        raise PortTrouble("found an empty name, expected a port; `fieldkit capture --list` shows them")
    if names:
        real = str(Path(names[0]).resolve())
        return next((port for port in here if port.name in (names[0], real)), Port(names[0]))
    proven = [port for port in here if port.device and port.device == (device or port.device)]
    likely = proven or [
        port for port in here if port.vendor is not None
    ]  # others are legacy ports with nothing attached
    if len(likely) != 1:
        found = ", ".join(port.name for port in likely) or "no serial port"
        raise PortTrouble(f"found {found}, expected one; name the port, `fieldkit capture --list` shows what is known")
    return likely[0]


def _chooser(
    wanted: Sequence[int], pause: Callable[[], None], asks: bool
) -> "Callable[[Sequence[Stored]], Sequence[int]]":
    """Chooses the flights to read: those `wanted`; else those that the user types, if it `asks` and there are several;
    else all. Raises BadValue for a wanted flight that is not in memory."""

    def choose(flights: "Sequence[Stored]") -> Sequence[int]:
        numbers_found = [flight.number for flight in flights]
        if wanted:
            if missing := set(wanted) - set(numbers_found):
                raise BadValue(
                    f"found no flight {min(missing)} in memory, expected one of {', '.join(map(str, numbers_found))}"
                )
            return wanted
        if not asks or len(flights) == 1:
            return numbers_found
        pause()
        for flight in flights:
            complain(f"  {flight.number:3d}  {flight.about}")
        typed = typer.prompt("Which flights, by number? Enter for all", default="", show_default=False, err=True)
        numbers = map(whole_number, typed.replace(",", " ").split())
        return [number for number in numbers if number is not None] or numbers_found

    return choose


@contextmanager
def _interrupt() -> "Iterator[Callable[[], bool]]":
    """Whether Ctrl-C was pressed: once ends the capture cleanly, twice immediately."""
    pressed = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield pressed.is_set
        return
    before = signal.getsignal(signal.SIGINT)

    def press(number: int, frame: object) -> None:
        pressed.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, press)
    try:
        yield pressed.is_set
    finally:
        signal.signal(signal.SIGINT, before)


def _print_end(end: "Ended") -> None:
    """Print how a capture ended and, if it is incomplete, how to continue."""
    kept = f"{counted(end.samples, 'sample')}, {counted(end.bytes, 'byte')} in {end.file}"
    complain(f"{end.why}: {kept}" if end.bytes else f"{end.why}: nothing received")
    if not end.whole and end.bytes:
        complain(f"Incomplete; run `fieldkit capture --resume {end.file.name}` to continue")


def _received(
    context: typer.Context, end: "Ended", wanted: bool | None, defaults: dict[str, object], json: bool
) -> "Receipt | None":
    """Import a capture if the user wants it; a log that cannot be read stays in the capture, which the message
    names."""
    from fieldkit.services.imports import bring_in

    if wanted is None and end.whole and sys.stdin.isatty() and not json:
        wanted = typer.confirm("Import it now?", default=True, err=True)
    if not (end.whole if wanted is None else wanted):
        complain(f"Not imported; run `fieldkit import {quote(str(end.file))}` to import it")
        return None
    with open_ledger(context) as ledger:
        check = MotorCheck()
        receipt = bring_in(ledger, [end.file], check, defaults=defaults, motors=check.catalogue)
        complain_of(receipt.rejected, receipt.notes)
        if not json:
            say_receipt(receipt, "Imported")
            say_next(ledger, receipt)
    return receipt


def _document(end: "Ended", receipt: "Receipt | None") -> dict[str, object]:
    counts = {"bytes": end.bytes, "samples": end.samples, "damaged": end.damaged}
    document: dict[str, object] = {"file": str(end.file), "device": end.device, **counts}
    document |= {"whole": end.whole, "ended": end.why, "unit": dict(end.about)}
    if receipt is not None:
        rejected = [asdict(row) for row in receipt.rejected]
        document |= {"imported": len(receipt.ids), "duplicates": receipt.duplicates}
        document |= {"rejected": rejected, "flights": list(receipt.ids)}
    return document


def print_ports(json: bool) -> None:
    """Print ports, supported devices, and devices that only their vendor's program can read."""
    from fieldkit.capture import known_devices, ports
    from fieldkit.capture.protocol import NOT_PUBLIC

    here = ports()
    if json:
        print_json(
            {
                "ports": [
                    {
                        "port": port.name,
                        "vendor": port.vendor,
                        "product": port.product,
                        "serial": port.serial,
                        "described": port.described,
                        "about": port.about,
                        "device": port.device or None,
                    }
                    for port in here
                ],
                "devices": {name: one.title for name, one in known_devices().items()},
                "not_public": dict(NOT_PUBLIC),
            }
        )
        return
    rows = [(port.name, _numbers(port), port.about or port.described, port.device) for port in here]
    if rows:
        print_table(("port", "numbers", "identified as", "device"), rows)
    else:
        say("No serial ports found; plug in the logger or its adapter")
    say()
    print_table(("device", "description"), [(name, one.title) for name, one in known_devices().items()])
    for name, text in NOT_PUBLIC.items():
        complain(f"{name}: {text}")


def _numbers(port: "Port") -> str:
    return "" if port.vendor is None else f"{port.vendor:04x}:{port.product or 0:04x}"
