"""The flight under the cursor of the Flights page: its figures and, if there is room, its Cd among those of the same
configuration, and its climb."""

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from textual.containers import VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.safe_text import printable
from fieldkit.tui.flights import logged
from fieldkit.tui.flights.flight_rows import FlightRow
from fieldkit.tui.flights.log_plot import Drawn, draw_trace
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import Hanging, stacked
from fieldkit.tui.widgets.plots import Plot, round_ticks, spaced

MAX_DRAWN_FLIGHTS = 120
"""Number of latest flights of a configuration to draw, more than the card has columns."""


class FlightCard(VerticalScroll):
    """The card next to the table. Plots are added when there is something to draw, so that the first paint does not
    need their library."""

    DEFAULT_CSS = """
    FlightCard Static { height: auto; margin-bottom: 1; }
    FlightCard Plot { height: 22vh; min-height: 10; margin-bottom: 1; border-top: solid $border-blurred;
        border-title-color: $foreground; }
    """

    _shown: str | None = None

    def compose(self) -> Iterable[Widget]:
        """The figures; plots are inserted between them."""
        yield Static(id="card")
        yield Static(id="setup")

    def show(self, row: FlightRow | None, build: Sequence[FlightRow], system: str) -> None:
        """Show a flight, and the flights of its build in the order flown; None for no flight."""
        for name, blocks in (("card", _figures), ("setup", _setup)):
            self.query_one(f"#{name}", Static).update(stacked(blocks(row, system)) if row is not None else "")
        known = [one for one in build if one.drag is not None][-MAX_DRAWN_FLIGHTS:]
        if row is not None and len(known) > 1:
            name = " ".join(part for part in (row.flight.rocket, row.flight.config) if part)
            self._plot("course", f"Cd of {name}, flight by flight", partial(_draw_course, row, known))
        else:
            self._plot("course", "", None)
        before, self._shown = self._shown, row.id if row is not None else None
        if self._shown != before:
            self.show_climb(None)  # until its log is read

    def show_climb(self, log: Drawn | None) -> None:
        """Show the altitude of its log; None if it has none, or while it is being read."""
        trace = log.traces.get("altitude") if log is not None else None
        if log is None or trace is None or len(trace.time) < 2:
            self._plot("climb", "", None)
        else:
            self._plot("climb", trace.title, partial(draw_trace, trace, log.events, log.span))

    def _plot(self, name: str, title: str, draw: Any) -> None:
        plot = next(iter(self.query(f"#{name}").results(Plot)), None)
        if plot is None and draw is not None:
            plot = Plot(id=name)
            self.mount(plot, before="#setup")
        if plot is not None:
            plot.display = draw is not None
            plot.border_title = Content(printable(title))
            plot.show(draw)


def _figures(row: FlightRow, system: str) -> Iterable[Hanging]:
    yield cards.lines(cards.heading(row.flight, row.id), ())
    yield cards.lines("Readouts", cards.readouts(row.flight, system), 20)
    if row.flight.tags:
        yield cards.lines("Tags", cards.tags(row.flight))


def _setup(row: FlightRow, system: str) -> Iterable[Hanging]:
    yield cards.lines("Setup and conditions", cards.circumstances(row.flight, system), 20)
    if row.flight.extra:
        yield cards.lines("Other data", logged.beside(row.flight.extra, system), 20)


def _draw_course(row: FlightRow, known: Sequence[FlightRow], plt: Any, ink: Any) -> None:
    """Draw Cd of each flight in order, with a vertical line at the current one and their ids below."""
    drags = [one.drag or 0.0 for one in known]
    plt.scatter(list(range(len(known))), drags, marker="●", color=ink.line)
    ends = {len(known) - 1, 0}
    here = next((place for place, one in enumerate(known) if one.id == row.id), None)
    if here is not None:
        plt.vline(here, color=ink.mark)
        plt.scatter([here], [drags[here]], marker="●", color=ink.mark)
    places = ([here] if here is not None else []) + sorted(ends - {here})
    labels = spaced([(float(place), printable(known[place].id)) for place in places], 0.0, len(known) - 1.0, ink.width)
    plt.xticks(list(labels), list(labels.values()))
    plt.xlim(-0.5, len(known) - 0.5)
    at = round_ticks(min(drags), max(drags), max(3, ink.height // 2))
    plt.yticks(at, [f"{drag:g}" for drag in at])
