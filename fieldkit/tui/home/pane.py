"""The second pane of a large Home page: the selected flight, why it missed, the misses as a trend, its climb."""

from collections.abc import Iterable, Sequence
from functools import partial

from textual.containers import VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.presentation.home_text import flown_lines
from fieldkit.presentation.one_off_text import why
from fieldkit.quantities import measure, number, spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.services.listed_flights import ListedFlight
from fieldkit.tui.comparing import Beside
from fieldkit.tui.flights.log_plot import Drawn, draw_trace
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.misses import draw_misses
from fieldkit.tui.widgets.plots import Plot, draw_in


class Pane(VerticalScroll, can_focus=False):
    """The selected flight; plots are shown when there is something to draw."""

    DEFAULT_CSS = """
    Pane { width: 1fr; border: round $border-blurred; padding: 0 1; margin: 0 1 0 0; border-title-color: $foreground; }
    Pane Static { height: auto; }
    Pane #pane-why { margin: 1 0; }
    Pane Plot { height: 1fr; min-height: 8; max-height: 40; border-top: solid $border-blurred;
        border-title-color: $foreground; }
    """

    def compose(self) -> Iterable[Widget]:
        """From the apogee to the climb."""
        yield Big(id="pane-apogee")
        yield Static("", id="pane-facts")
        yield Static("", id="pane-why")
        yield Plot(id="pane-trend")
        yield Plot(id="pane-climb")

    def show(self, one: ListedFlight | None, flights: Sequence[ListedFlight], beside: Beside, system: str) -> None:
        """Show a flight of some, newest first; None clears the pane."""
        self.border_title = Content("" if one is None else printable(cards.heading(one.flight, one.id)))
        apogee = None if one is None else one.flight.apogee
        self.query_one("#pane-apogee", Big).show("" if apogee is None else number(cards.APOGEE, apogee, system))
        facts = Content("\n".join(map(printable, _facts(one, system)))).stylize("bold")
        self.query_one("#pane-facts", Static).update(facts)
        found = None if one is None else beside.get((one.flight.rocket, one.flight.flight_id))
        self.query_one("#pane-why", Static).update(Content("" if found is None else printable(why(found, system))))
        same = [] if one is None else [other for other in reversed(flights) if other.flight.rocket == one.flight.rocket]
        missed = [(other.flight.flight_id, other.miss) for other in same if other.miss is not None]
        unit = spelled(unit_of(cards.APOGEE, system))
        rocket = "" if one is None else one.flight.rocket
        draw = (
            partial(draw_misses, missed, one.flight.flight_id, system) if one is not None and len(missed) > 1 else None
        )
        draw_in(self, draw, f"Misses of {rocket}, flown minus forecast [{unit}]", "pane-trend")
        self.show_climb(None)

    def show_climb(self, log: Drawn | None) -> None:
        """Show the height in the log of the flight; None if it has none, or while it is being read."""
        trace = log.traces.get("altitude") if log is not None else None
        if log is None or trace is None or len(trace.time) < 2:
            draw_in(self, None, name="pane-climb")
        else:
            draw_in(self, partial(draw_trace, trace, log.events, log.span), trace.title, "pane-climb")


def _facts(one: ListedFlight | None, system: str) -> Iterable[str]:
    if one is None:
        return
    if one.flight.apogee is not None:
        yield from flown_lines(one, system)
    if one.forecast is None and one.miss is not None:
        way = "above" if one.miss >= 0 else "below"
        yield f"{measure(cards.APOGEE, abs(one.miss), system)} {way} what the other flights lead to expect"
    if one.flight.tags:
        yield f"tagged {', '.join(one.flight.tags)}"
