"""A view of a log: the whole flight against time with a cursor, and below it columns, readouts and events."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from fieldkit import units
from fieldkit.analysis.whole_flight import FlightCurve
from fieldkit.flight import BY_NAME, LOG_FIGURES
from fieldkit.flight.event_names import event_title
from fieldkit.ledger import Ledger
from fieldkit.quantities import counted, in_system, measure, rounded, spelled, unit_of, with_sd
from fieldkit.safe_text import printable
from fieldkit.services.imports import FileView, FlightView
from fieldkit.services.replay import recording_of
from fieldkit.tui.flights.flights_help import LOG_HELP
from fieldkit.tui.flights.log_plot import ChannelTrace, draw_trace
from fieldkit.tui.help import Help
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.bars import KeyBar
from fieldkit.tui.widgets.dialogs import HelpedModal
from fieldkit.tui.widgets.hanging import Hanging, stacked
from fieldkit.tui.widgets.plots import Plot

CHANNELS = {"height": "apogee", "speed": "top_speed", "acceleration": "peak_accel"}
"""The plots from top to bottom, and the readout with the unit of each."""
STEPS = 120
"""Steps of the cursor from one end to the other. [1]"""
STEPS_TO_EVENT = 0.6
"""An event within this number of steps is named next to the cursor. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class LogLook:
    """One flight of a file: a title, its facts, and its curve, None without samples."""

    title: str
    facts: Hanging
    curve: FlightCurve | None


def looks_at(file: FileView, system: str) -> list[LogLook]:
    """One entry for each flight and each simulation of a file; an entry without a curve if there is none."""
    whole = file_facts(file, system)
    shown = [
        LogLook(
            f"{file.file} · {one.flight.flight_id}" if len(file.shown) > 1 else file.file,
            stacked([_readouts(one, system), _events(one, system), *whole]),
            one.curve,
        )
        for one in file.shown
    ]
    return shown or [LogLook(file.file, stacked(whole), None)]


def look_at_flight(ledger: Ledger, id: str, system: str) -> LogLook | str:
    """The view of the log of a flight in the ledger, or the reason there is none."""
    found = recording_of(ledger, id)
    if found is None or found.reading is None:
        return "this flight has no log with samples"
    one = FlightView(ledger.flight(id), found.recorded)
    return LogLook(id, stacked([_readouts(one, system), _events(one, system)]), one.curve)


def file_facts(file: FileView, system: str) -> list[Hanging]:
    """The reason for the format of a file, its columns, and what would be stored."""
    columns = [
        (
            f"{one.name} [{spelled(one.unit)}]" if one.unit else one.name,
            f"{one.channel.replace('_', ' ') or 'not used as a channel'}, {one.source}",
        )
        for one in file.columns
    ]
    stored = f"{counted(len(file.flights), 'flight')}, {file.rejected} rejected"
    read = [
        ("format", f"{file.title} ({file.format})"),
        ("why", file.why),
        ("rows", f"{file.rows} used, {file.dropped} dropped"),
        ("stores", stored),
    ]
    notes = [("!", in_system(note, system)) for note in file.notes]
    blocks = [cards.lines("How it was read", read), cards.lines("Columns", columns)]
    return blocks + ([cards.lines("Notes", notes)] if notes else [])


def _readouts(one: FlightView, system: str) -> Hanging:
    """The readouts with the device's own values, each with its sensor."""
    rows = []
    for column in LOG_FIGURES:
        found = one.readouts.get(column.name)
        if found is None:
            continue
        unit = unit_of(column, system)
        own, scale = units.unit(column.quantity, column.unit), units.unit(column.quantity, unit)
        value = with_sd(
            scale.from_si(own.to_si(found.value)), scale.difference_from_si(own.difference_to_si(found.sd or 0.0))
        )
        beside = "" if found.stated is None else f"  device: {rounded(scale.from_si(own.to_si(found.stated)))}"
        rows.append((column.title, f"{value} {spelled(unit)}  {found.sensor}{beside}"))
    return cards.lines("Readouts", rows)


def _events(one: FlightView, system: str) -> Hanging:
    """The events in their order, seconds from lift-off, and the height at each."""
    rows = []
    for event in one.events:
        at = "" if event.altitude is None else f"  {measure(BY_NAME['apogee'], event.altitude, system)}"
        rows.append((event_title(event.name), f"T{event.time:+.2f} s{at}  {event.sensor}"))
    return cards.lines("Events", rows)


class LogView(HelpedModal[None]):
    """The log of a flight, or of several, one at a time."""

    DEFAULT_CSS = """
    LogView { background: $background; }
    LogView > Vertical { background: $surface; border: solid $border; }
    LogView #cursor { height: 1; padding: 0 1; text-wrap: nowrap; text-overflow: ellipsis; }
    LogView Plot { height: 1fr; min-height: 4; border-top: solid $border-blurred; border-title-color: $foreground; }
    LogView VerticalScroll { height: 7; padding: 0 1; border-top: solid $border-blurred; }
    LogView.-low VerticalScroll { display: none; }
    LogView.-low Plot.-other, LogView.-high Plot.-other { display: none; }
    LogView.-facts Plot { display: none; }
    LogView.-facts VerticalScroll { height: 1fr; display: block; }
    """
    VERTICAL_BREAKPOINTS = [(0, "-low"), (34, "-high"), (44, "-tall")]  # noqa: RUF012  # as Textual has it
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("left", "step(-1)", "Earlier", show=False),
        Binding("right", "step(1)", "Time", key_display="←→", tooltip="Move in time; with Shift ten steps"),
        Binding("shift+left,ctrl+left", "step(-10)", "Much earlier", show=False),
        Binding("shift+right,ctrl+right", "step(10)", "Much later", show=False),
        Binding("home", "event(-1)", "Previous event", show=False),
        Binding("end", "event(1)", "Events", key_display="Home End", tooltip="The next event; Home previous"),
        Binding("v", "channel", "Plot", tooltip="Height, speed or acceleration; a tall screen shows all"),
        Binding("tab", "facts", "Plot/facts", key_display="Tab", priority=True, tooltip="The plot or its facts alone"),
        Binding("up", "scroll_by(-1)", "Up", show=False),
        Binding("down", "scroll_by(1)", "Facts", key_display="↑↓", tooltip="Scroll the facts"),
        Binding("pageup", "flight(-1)", "Previous flight", show=False),
        Binding("pagedown", "flight(1)", "Flights", key_display="PgDn", tooltip="The next flight; PgUp previous"),
        Binding("y", "copy", "Copy", show=False),
        Binding("escape", "dismiss", "Close"),
    ]

    def __init__(self, looks: Sequence[LogLook], system: str) -> None:
        super().__init__()
        self._looks, self._system = looks, system
        self._place, self._moment, self._channel = 0, 0.0, 0

    def compose(self) -> ComposeResult:
        """The cursor's values, the plots, the facts."""
        with Vertical() as frame:
            frame.border_title = Content(printable(self._looks[0].title))
            yield Static("", id="cursor")
            for name in CHANNELS:
                yield Plot(id=f"look-{name}")
            with VerticalScroll(can_focus=False):
                yield Static("", id="facts")
            yield KeyBar()

    def explained(self) -> tuple[str, Help]:
        """The plots, the facts and the keys."""
        return "Log", LOG_HELP

    def on_mount(self) -> None:
        """Show the first flight."""
        self._show()

    @property
    def _look(self) -> LogLook:
        return self._looks[self._place]

    def _show(self) -> None:
        """Show the current flight, the cursor at its apogee."""
        look = self._look
        self.query_one(Vertical).border_title = Content(printable(look.title))
        self.query_one("#facts", Static).update(look.facts)
        self.set_class(look.curve is None, "-facts")
        if look.curve is not None:
            self._moment = look.curve.events.get("apogee", float(look.curve.time[0]))
        self._draw()

    def _draw(self) -> None:
        """Draw the curves with the cursor, and show the values there."""
        curve = self._look.curve
        if curve is None:
            self.query_one("#cursor", Static).update("no samples in this file")
            return
        for number, name in enumerate(CHANNELS):
            self.query_one(f"#look-{name}").set_class(number != self._channel, "-other")
        span = float(curve.time[0]), float(curve.time[-1])
        parts = [f"T{self._moment:+.2f} s" + ("" if curve.from_liftoff else " on the log's clock")]
        for name, here in zip(CHANNELS, curve.at(self._moment), strict=True):
            unit = unit_of(BY_NAME[CHANNELS[name]], self._system)
            scale = units.unit(BY_NAME[CHANNELS[name]].quantity, unit)
            trace = channel(curve, name, self._system)
            plot = self.query_one(f"#look-{name}", Plot)
            plot.border_title = Content(trace.title)
            plot.show(_with_cursor(trace, curve.events, span, self._moment))
            parts.append(f"{scale.from_si(here):.1f} {spelled(unit)}")
        step = (span[1] - span[0]) / STEPS
        near = STEPS_TO_EVENT * step
        parts += [event_title(name) for name, moment in curve.events.items() if abs(moment - self._moment) < near]
        self.query_one("#cursor", Static).update(Content(printable("  ".join(parts))).stylize("bold"))

    def action_step(self, by: int) -> None:
        """Move the cursor."""
        curve = self._look.curve
        if curve is not None:
            first, last = float(curve.time[0]), float(curve.time[-1])
            self._moment = min(max(self._moment + by * (last - first) / STEPS, first), last)
            self._draw()

    def action_channel(self) -> None:
        """Show the next plot; a tall screen shows all."""
        self._channel = (self._channel + 1) % len(CHANNELS)
        self._draw()

    def action_event(self, by: int) -> None:
        """Move the cursor to the previous or next event."""
        curve = self._look.curve
        if curve is None:
            return
        moments = sorted(one for one in curve.events.values() if curve.time[0] <= one <= curve.time[-1])
        beyond = [one for one in moments if (one - self._moment) * by > 1e-6]
        if beyond:
            self._moment = beyond[0] if by > 0 else beyond[-1]
            self._draw()

    def action_flight(self, by: int) -> None:
        """Show the previous or next flight of the file."""
        self._place = (self._place + by) % len(self._looks)
        self._show()

    def action_facts(self) -> None:
        """Enlarge the plots or the facts."""
        if self._look.curve is not None:
            self.toggle_class("-facts")

    def action_scroll_by(self, lines: int) -> None:
        """Scroll the facts."""
        self.query_one(VerticalScroll).scroll_relative(y=lines, animate=False)

    def action_copy(self) -> None:
        """Copy the facts as text."""
        self.app.copy_to_clipboard(f"{self._look.title}\n\n{self._look.facts}")


def channel(curve: FlightCurve, name: str, system: str) -> ChannelTrace:
    """The height, speed or acceleration of a curve by its name in `CHANNELS`, in the units of a system."""
    column = BY_NAME[CHANNELS[name]]
    unit = unit_of(column, system)
    scale = units.unit(column.quantity, unit)
    values = {"height": curve.height, "speed": curve.speed, "acceleration": curve.acceleration}[name]
    title = f"{name} [{spelled(unit)}]"
    return ChannelTrace(title, curve.time.tolist(), [scale.from_si(float(value)) for value in values])


def draw_height(curve: FlightCurve, system: str) -> Callable[[Any, Any], None]:
    """Draws the height of a flight with its events."""
    span = float(curve.time[0]), float(curve.time[-1])
    return partial(draw_trace, channel(curve, "height", system), dict(curve.events), span)


def _with_cursor(
    trace: ChannelTrace, events: Mapping[str, float], span: tuple[float, float], moment: float
) -> Callable[[Any, Any], None]:
    """Draws a channel with its events, and a line at the cursor."""

    def draw(plt: Any, ink: Any) -> None:
        draw_trace(trace, dict(events), span, plt, ink)
        plt.plot([moment, moment], [min(trace.values), max(trace.values)], marker="┃", color=ink.text)

    return draw
