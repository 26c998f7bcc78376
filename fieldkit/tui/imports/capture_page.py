"""Capture: a logger on a serial port, downloaded or recorded; every byte is saved before it is interpreted.

The Capture page before a capture: what to do, earlier captures, and the loggers that can be captured.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Event as Flag
from typing import Any, ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Static

from fieldkit import capture
from fieldkit.capture import Ended, Port, Progress, captured, known_devices
from fieldkit.capture.protocol import known_device
from fieldkit.errors import CaptureTrouble
from fieldkit.flight import BY_NAME
from fieldkit.paths import capture_folder
from fieldkit.presentation.capture_text import counts, event_line
from fieldkit.quantities import counted, measure, number, spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.services.imports import Receipt, bring_in
from fieldkit.services.pickers import OfferedAnswer
from fieldkit.tui.help import Help
from fieldkit.tui.imports.day_setup import ask_setup, setup_of_day
from fieldkit.tui.imports.import_look import by_keys
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.bars import shortened
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.dialogs import AskText, AskYes
from fieldkit.tui.widgets.hanging import Hanging, hanging, stacked
from fieldkit.tui.widgets.plots import Plot
from fieldkit.tui.widgets.table import Head, Table

MAX_CAPTURES = 8
"""Number of earlier captures that are listed, the newest first. [1]"""
STEPS = (
    ("1", "Plug in the logger or its adapter; r lists its port above."),
    ("2", "Enter captures from the port. h names the device first if it only answers commands."),
    ("3", "At the end you are asked whether to import its flights; k ends a stream."),
)
"""The steps of a capture: number and text."""


@dataclass(frozen=True, slots=True)
class Ready:
    """Earlier captures as name and state, the newest first, and the names and titles of known devices."""

    captures: tuple[tuple[str, str], ...]
    devices: tuple[tuple[str, str], ...]


def ready_in(folder: Path) -> Ready:
    """The latest captures in a folder, and the known devices."""
    files = captured.captures(folder)[: -MAX_CAPTURES - 1 : -1]
    states = tuple((file.name, _state(file)) for file in files)
    return Ready(states, tuple((name, device.title) for name, device in known_devices().items()))


def _state(file: Path) -> str:
    """The size of a capture and whether it is complete, or why it cannot be read."""
    try:
        one = captured.read_capture(file)
    except CaptureTrouble as error:
        return str(error)
    return f"{counted(len(one.raw), 'byte')}, " + ("complete" if one.whole else "INCOMPLETE; C continues the newest")


def ready_text(ready: Ready) -> Hanging:
    """The steps of a capture, earlier captures, and known devices."""
    blocks = [cards.lines("How to capture", list(STEPS), 2)]
    if ready.captures:
        blocks.append(cards.lines("Earlier captures", list(ready.captures), 26))
    blocks.append(cards.lines("Loggers that can be captured", list(ready.devices), 20))
    return stacked(blocks)


MAX_DRAWN_ALTITUDES = 600
"""Number of latest altitudes of a telemetry stream that are drawn. [1]"""
MAX_LOG_LINES = 50
"""Number of lines in the event log, of which the last few are visible."""


class CaptureScreen(PageScreen):
    """The ports above, the capture below."""

    NAME = "serial"
    ON_ENTER = ("Capture", "Read the logger on this port")
    TITLE = "Capture"
    ROW_REQUESTS = ("ports",)
    ABOUT = Help(
        "Plug in the logger or its adapter; Enter captures from the port under the cursor. Nothing on a logger is ever "
        "changed or erased. At the end you are asked whether to import its flights.",
        (
            ("saved", "Every byte, before it is decoded, so a pulled cable loses nothing: C continues, k ends."),
            ("port", "The port's name in the operating system."),
            ("description", "The maker of the chip, and the logger if the USB numbers identify it."),
            (
                "device",
                "The protocol to use; empty: recognized by the USB numbers or by listening. Choose it with h if the "
                "logger only answers commands.",
            ),
            ("altitude", "The current altitude of a telemetry stream, and the highest so far."),
        ),
        ("fieldkit capture --list", "fieldkit capture [PORT] [--device NAME]", "fieldkit capture --resume"),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("k", "stop", "Stop", tooltip="End the capture"),
        Binding("h", "device", "Device", tooltip="Choose the device on the port"),
        Binding("C", "resume", "Continue", tooltip="Continue the newest unfinished capture"),
        Binding("r", "look", "Reload", tooltip="List the ports again"),
    ]
    DEFAULT_CSS = """
    CaptureScreen #ports { height: 8; }
    CaptureScreen #live { height: 1fr; padding: 0 1; border-top: solid $border-blurred;
        border-title-color: $foreground; }
    CaptureScreen #happened { height: auto; max-height: 4; scrollbar-size-vertical: 1; }
    CaptureScreen.-tall #happened { max-height: 8; }
    CaptureScreen #events { height: auto; }
    CaptureScreen #ready { height: 1fr; }
    CaptureScreen #steps { height: auto; }
    CaptureScreen.-started #ready { display: none; }
    CaptureScreen #count, CaptureScreen #now, CaptureScreen #heights { display: none; }
    CaptureScreen.-started #count, CaptureScreen.-started #now, CaptureScreen.-started #heights { display: block; }
    CaptureScreen #count { height: 1; text-style: bold; }
    CaptureScreen #now { height: 3; }
    CaptureScreen #big { width: 34; color: $accent; }
    CaptureScreen #state { width: 1fr; }
    CaptureScreen #heights { height: 1fr; }
    CaptureScreen.-wide #body { layout: horizontal; }
    CaptureScreen.-wide #ports { width: 1fr; height: 1fr; }
    CaptureScreen.-wide #live { width: 1fr; }
    CaptureScreen.-wide #ports, CaptureScreen.-wide #live { border: round $border-blurred; }
    CaptureScreen #ports { border-title-color: $foreground; }
    """

    @dataclass
    class Happened(Message):
        """An event that a capture reports; None if the capture failed."""

        event: Any

    def __init__(self) -> None:
        super().__init__()
        self._device: str | None = None
        self._stop = Flag()
        self._capturing = False
        self._events: list[str] = []
        self._heights: list[float] = []
        self._highest = float("-inf")

    def body(self) -> Iterable[Widget]:
        """The ports and the capture."""
        yield Table(
            id="ports",
            classes="framed",
            empty="no serial port; plug in the logger, then press r",
            enter=self.ON_ENTER[0],
        )
        with Vertical(id="live"):
            with VerticalScroll(id="happened", can_focus=False):
                yield Static("", id="events")
            with VerticalScroll(id="ready", can_focus=False):
                yield Static("", id="steps")
            yield Static("", id="count")
            with Horizontal(id="now"):
                yield Big(id="big")
                yield Static("", id="state")
            yield Plot(id="heights")

    def on_mount(self) -> None:
        """Focus the ports."""
        self.set_focus(self.query_one(Table))
        self.query_one("#ports").border_title, self.query_one("#live").border_title = "Ports", "Capture"
        self._say("Enter to capture; every byte is saved before it is decoded")

    def on_unmount(self) -> None:
        """End the capture with the app."""
        self._stop.set()

    def reload(self) -> None:
        """List the ports."""
        self.action_look()

    def action_look(self) -> None:
        """List the ports again."""

        self.ask(lambda: capture.ports(), self._listed, "ports")
        self.ask(partial(ready_in, capture_folder()), self._have_ready, "ready")

    def _have_ready(self, ready: Ready) -> None:
        self.query_one("#steps", Static).update(ready_text(ready))

    def _listed(self, ports: list[Port]) -> None:
        def cells(port: Port) -> list[str]:
            numbers = "" if port.vendor is None else f"{port.vendor:04x}:{port.product or 0:04x}"
            return [port.name, numbers, port.about or port.described, self._device or port.device]

        heads = [Head("port", 16), Head("numbers", 9), Head("description", 0), Head("device", 14)]
        self.query_one(Table).show(heads, ports, cells)

    @on(Table.Chosen)
    def _capture(self, message: Table.Chosen) -> None:
        self._begin(message.key)

    def action_resume(self) -> None:
        """Continue the newest unfinished capture."""
        self._begin(None)

    def _begin(self, port: Port | None) -> None:
        """Start capturing from a port, or continue an unfinished capture."""
        if self._capturing:
            self.complain("a capture is running; k ends it")
            return
        self._capturing, self._heights, self._highest = True, [], float("-inf")
        self._stop.clear()
        self.add_class("-started")
        self._nothing_yet()
        self.ask(partial(self._follow, port, self._device), self._ended, "capture")

    def _nothing_yet(self) -> None:
        """Clear the previous capture."""
        self.query_one(Big).show("")
        for place in ("#count", "#state"):
            self.query_one(place, Static).update("")
        self.query_one(Plot).display = False

    def _follow(self, port: Port | None, device: str | None) -> Ended | None:
        """Capture from a port, or continue the newest unfinished capture; report each event to the screen, and return
        the last one. Raises CaptureTrouble or PortTrouble."""
        try:
            if port is not None:
                events = capture.capture(port, device, folder=capture_folder(), stop=self._stop.is_set)
            elif (file := capture.unfinished(capture_folder())) is not None:
                events = capture.resume(file, device=device, stop=self._stop.is_set)
            else:
                raise CaptureTrouble("no unfinished capture to continue")
            for event in events:
                self.post_message(self.Happened(event))
        except Exception:
            self.post_message(self.Happened(None))
            raise
        return event  # type: ignore[return-value]  # a capture ends with it or raises

    @on(Happened)
    def _happened(self, message: Happened) -> None:
        """Show one event."""
        if message.event is None:
            self._capturing = False
        elif isinstance(message.event, capture.Progress):
            self._progress(message.event)
        elif line := event_line(message.event):
            self._say(f"! {line}" if isinstance(message.event, capture.Lost) else line)

    def _say(self, text: str) -> None:
        self._events = [*self._events, printable(text).replace("--device", "h")][-MAX_LOG_LINES:]
        self.query_one("#events", Static).update(hanging(map(shortened, self._events)))
        self.query_one("#happened").scroll_end(animate=False)

    def _progress(self, progress: Progress) -> None:
        """Show counts, the fraction done, and the altitude if a stream contains it."""
        parts = counts(progress)
        if progress.fraction is not None:
            bar = "█" * round(progress.fraction * 20)
            parts.append(f"[{bar:20}] {progress.fraction:.0%}")
        self.query_one("#count", Static).update(Content("   ".join(parts)))
        sample, system = progress.sample, self.resources.settings.units
        if sample is None:
            return
        self._heights = [*self._heights, sample.altitude][-MAX_DRAWN_ALTITUDES:]
        self._highest = max(self._highest, sample.altitude)
        self.query_one(Big).show(number(cards.APOGEE, sample.altitude, system))
        highest = measure(cards.APOGEE, self._highest, system)
        speed = measure(BY_NAME["top_speed"], sample.speed, system)
        lines = [f"{spelled(unit_of(cards.APOGEE, system))} now, highest {highest}", speed, printable(sample.state)]
        self.query_one("#state", Static).update(Content("\n".join(line for line in lines if line)))
        heights = [float(number(cards.APOGEE, one, system)) for one in self._heights]
        self.query_one(Plot).display = True
        self.query_one(Plot).show(partial(_draw_heights, heights))

    def _ended(self, end: Ended | None) -> None:
        """Show how it ended, and ask whether to import its flights."""
        self._capturing = False
        if end is None or not end.bytes:
            self._say("nothing received")
            return
        whole = "complete" if end.whole else "INCOMPLETE; C to continue"
        size = f"{counted(end.samples, 'sample')}, {counted(end.bytes, 'byte')}, {whole}"
        self._say(f"{end.why}: {size}; saved in {end.file}")
        question = f"{end.file.name}: {size}.\nImport its flights?"
        ask = partial(self.app.push_screen, AskYes(question), partial(self._answered, end))
        self.show_in_front(ask, f"The capture has ended, {whole.split(';')[0]}. 7 to import its flights")

    def _answered(self, end: Ended, yes: bool | None) -> None:
        """Ask for values that the logger lacks, with defaults from the open forecast."""

        def store(given: dict[str, object]) -> None:
            self.ask(partial(self._store, end, given), self._stored, "store")

        if yes:
            self.ask(partial(setup_of_day, self.resources), lambda known: ask_setup(self, known, store), "setup")

    def _store(self, end: Ended, given: dict[str, object]) -> Receipt:
        motors = self.resources.motors
        return bring_in(self.resources.ledger, [end.file], motors.complaint, motors=motors, defaults=given)

    def _stored(self, receipt: Receipt) -> None:
        self.show_notice(f"Imported {len(receipt.ids)}, {counted(receipt.duplicates, 'duplicate')}. u to undo")
        for row in receipt.rejected:
            self.complain(f"{row.file}: {by_keys(row.error)}")
        for line in receipt.implausible:
            self.complain(line)
        self.field_app.changed()

    def action_stop(self) -> None:
        """End the capture."""
        self._stop.set()

    def action_device(self) -> None:
        """Choose the device on the port."""
        picks = [OfferedAnswer(name, device.title) for name, device in capture.known_devices().items()]
        about = "The device on the port; ↓ chooses one. Empty: recognize it."
        self.app.push_screen(AskText("Device", self._device or "", about, picks, _check_device), self._named)

    def _named(self, text: str | None) -> None:
        if text is None:
            return
        self._device = text.strip() or None
        self.action_look()

    def copied(self) -> str:
        """The events so far."""
        return "\n".join(self._events)


def _check_device(name: str) -> None:
    """Raises PortTrouble for a device that is not known; an empty name means that it is recognized."""
    if name.strip():
        known_device(name)


def _draw_heights(heights: list[float], plt: Any, ink: Any) -> None:
    """Draw the received altitudes, the newest on the right."""
    plt.plot(heights, marker="braille", color=ink.line)
    plt.xfrequency(0)
