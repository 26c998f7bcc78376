"""The log of a flight as plots: its channels against time, with a line at each event."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from fieldkit import units
from fieldkit.flight import BY_NAME
from fieldkit.flight.event_names import event_title
from fieldkit.ledger import Ledger
from fieldkit.quantities import spelled, unit_of
from fieldkit.services.coast_drag import CoastDrag
from fieldkit.services.replay import recording_of
from fieldkit.shapes import Array, Float
from fieldkit.tui.widgets.plots import AXIS, below_line, filled_columns, round_ticks, spaced


@dataclass(frozen=True, slots=True)
class ChannelTrace:
    """One channel of a log, thinned to the resolution of a screen: times [s], and values in the displayed units."""

    title: str
    time: list[float]
    values: list[float]


@dataclass(frozen=True, slots=True)
class Drawn:
    """A log for a plot: its channels, and its events by name; times are on the log's own clock, or from lift-off after
    `from_liftoff`. [s]"""

    device: str
    traces: dict[str, ChannelTrace]
    events: dict[str, float]

    @property
    def span(self) -> tuple[float, float]:
        """From the first sample to the last over all channels, for a common axis. [s]"""
        ends = [(trace.time[0], trace.time[-1]) for trace in self.traces.values() if trace.time]
        return min((first for first, _ in ends), default=0.0), max((last for _, last in ends), default=0.0)

    def from_liftoff(self) -> "Drawn":
        """A copy with time from lift-off, from shortly before lift-off to landing; unchanged if lift-off is unknown.
        [s]"""
        start = self.events.get("liftoff")
        if start is None:
            return self
        end = self.events.get("landing", self.span[1]) + DRAWN_MARGIN
        traces: dict[str, ChannelTrace] = {}
        for name, trace in self.traces.items():
            kept = [
                (t - start, v)
                for t, v in zip(trace.time, trace.values, strict=True)
                if start - DRAWN_MARGIN <= t <= end
            ]
            if kept:
                time, values = zip(*kept, strict=True)
                traces[name] = replace(trace, time=list(time), values=list(values))
        return Drawn(self.device, traces, {name: time - start for name, time in self.events.items()})


DRAWN_MARGIN = 1.0
"""Time to draw before lift-off and after landing. [s]"""
TRACES = ("altitude", "speed", "acceleration")
"""Channels to draw, from top to bottom."""
MAX_DRAG = 4.0
"""Largest drag over its mean that is drawn: what the log does not show is open. [1]"""
POINTS = 400
"""Largest number of samples of a channel that are drawn, more than the widest screen has dots. [1]"""


def drawn(ledger: Ledger, id: str, system: str) -> Drawn | str:
    """The log of a flight as traces from lift-off, or the reason there is nothing to draw."""
    found = recording_of(ledger, id)
    if found is None or found.reading is None:
        return "this flight has no log with samples"
    columns = {"altitude": BY_NAME["apogee"], "speed": BY_NAME["top_speed"], "acceleration": BY_NAME["peak_accel"]}
    climb = found.recorded.climb
    traces: dict[str, ChannelTrace] = {}
    for name, column in columns.items():
        clock = next((one for one in found.reading.clocks if getattr(one, name) is not None), None)
        if clock is not None:
            time, values = clock.time, getattr(clock, name)
        elif climb is not None:
            time, values = climb.time, getattr(climb, "height" if name == "altitude" else name)
        else:
            continue
        good = np.isfinite(values)
        every = max(1, -(-int(good.sum()) // POINTS))  # rounded up
        unit = unit_of(column, system)
        scale = units.unit(column.quantity, unit)
        measured = "" if clock is not None else ", from the heights"
        traces[name] = ChannelTrace(
            f"{name} [{spelled(unit)}]{measured}",
            time[good][::every].tolist(),
            [scale.from_si(value) for value in values[good][::every].tolist()],
        )
    events = {name: event.time for name, event in found.recorded.events.items()}
    return Drawn(found.kind, traces, events).from_liftoff()


def draw_trace(trace: ChannelTrace, events: dict[str, float], span: tuple[float, float], plt: Any, ink: Any) -> None:
    """Draw a channel against the time of the whole log, its thrust, coast and descent in colors of their own, with a
    line at each event and its name below, and round times where there is room."""
    first, last = span
    inside = {name: time for name, time in events.items() if first <= time <= last}
    low, high = min(trace.values), max(trace.values)
    colors = ink.mark, ink.line, ink.text
    columns = np.linspace(first, last, max(2, ink.width - AXIS))  # one sample a column: an area of dots takes too long
    heights = np.interp(columns, trace.time, trace.values)
    below = below_line(heights, high - low, ink)
    tall = filled_columns(below, high - low, ink)
    for color, part in phases(columns, events, colors):
        plt.scatter(
            columns[part][tall[part]].tolist(), below[part][tall[part]].tolist(), marker="░", color=color, fillx=True
        )
    for color, part in phases(np.array(trace.time), events, colors):
        plt.plot(trace.time[part], trace.values[part], marker="braille", color=color)
    for moment in inside.values():
        plt.plot([moment, moment], [low, high], marker="│", color=ink.text)
    ends = {f"T+{last:.0f} s": last}
    named = sorted((time, event_title(name)) for name, time in {**inside, **ends}.items())
    seconds = [(time, f"{time:g}") for time in round_ticks(first, last, ink.width // 12)]
    labels = spaced([*named, *seconds], first, last, ink.width)
    plt.xticks(list(labels), list(labels.values()))
    plt.xlim(first, last)
    at = round_ticks(low, high, max(3, ink.height // 3))
    plt.yticks(at, [f"{value:7g}" for value in at])  # equal widths, so that times are aligned


def phases(
    time: Float[Array, "sample"], events: Mapping[str, float], colors: tuple[Any, Any, Any]
) -> Iterator[tuple[Any, slice]]:
    """The samples up to burnout, up to apogee and after it, each with its color; all of a log without these events are
    of the coast."""
    ends = np.searchsorted(time, [events.get("burnout", -inf), events.get("apogee", inf)], side="right")
    start = 0
    for color, end in zip(colors, (*ends.tolist(), len(time)), strict=True):
        if end > start:
            yield color, slice(start, end)
            start = end


def draw_drag(found: CoastDrag, plt: Any, ink: Any) -> None:
    """Draw drag over the mean of the coast against time from lift-off, with its 90% interval and a line at one."""
    time = found.time.tolist()
    plt.hline(1.0, color=ink.text)
    for edge in (found.low, found.high):
        plt.plot(time, edge.tolist(), marker="braille", color=ink.dim)
    plt.plot(time, found.mean.tolist(), marker="braille", color=ink.line)
    low, high = max(0.0, min(found.low.min(), 0.5)), min(max(found.high.max(), 1.5), MAX_DRAG)
    plt.ylim(low, high)
    at = round_ticks(low, high, max(3, ink.height // 3))
    plt.yticks(at, [f"{value:7g}" for value in at])
    seconds = round_ticks(time[0], time[-1], max(2, ink.width // 12))
    plt.xticks(seconds, [f"{value:g} s" for value in seconds])
