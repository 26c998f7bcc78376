"""A flight that was just saved: forecast against flown, Cd before and after, the next forecast, what to do next."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.presentation.after_flight_text import outcome_facts, suggestion_line
from fieldkit.quantities import measure, number, shown_unit
from fieldkit.safe_text import printable
from fieldkit.services.after_flight import Outcome, outcome
from fieldkit.services.next_suggestion import Suggestion, suggestion
from fieldkit.services.saved_forecasts import SavedForecast, list_forecasts
from fieldkit.tui.next.intervals import IntervalBar, Intervals
from fieldkit.tui.resources import Resources
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import hanging
from fieldkit.tui.widgets.plots import Marked, Plot, draw_density

DrawPlot = Callable[[Any, Any], Any]
MAX_EARLIER = 24
"""Number of earlier forecasts drawn. [1]"""
WORKING_TEXT = "comparing with the forecast ..."
NO_FORECAST = "No forecast to compare with: without a motor and a dry mass the flight has no Cd."


@dataclass(frozen=True, slots=True)
class AfterFlight:
    """A flight compared with its forecast, what to do next, and the earlier forecasts of its rocket that have flown."""

    outcome: Outcome
    next: Suggestion
    earlier: tuple[SavedForecast, ...]


def after_flight(resources: Resources, flight: Flight) -> AfterFlight | None:
    """All contents of the card of a saved flight; None if there is nothing to compare it with."""
    ledger, motors = resources.ledger, resources.motors
    found = outcome(ledger, motors, flight)
    if found is None:
        return None
    forecasts = list_forecasts(ledger, motors, flight.rocket)
    flown = tuple(one for one in forecasts if one.flown is not None and one.flight != flight)
    return AfterFlight(found, suggestion(ledger, motors, resources.settings, found, forecasts), flown)


class AfterCard(VerticalScroll, can_focus=True):
    """Replaces the form until Enter starts the next flight; `text` is the card as text, to be copied."""

    DEFAULT_CSS = """
    AfterCard { height: 1fr; border: round $border; padding: 0 1; display: none; }
    AfterCard Static { height: auto; }
    AfterCard Horizontal { height: auto; }
    AfterCard Big { margin: 0 2 0 0; }
    AfterCard .facts { width: 1fr; }
    AfterCard > .bars, AfterCard > .next { margin-top: 1; }
    AfterCard > .hill { height: 1fr; min-height: 10; max-height: 24; margin-top: 1; display: none;
        border-top: solid $border-blurred; border-title-color: $foreground; }
    AfterCard > .earlier { margin-top: 1; display: none; }
    .-high AfterCard > .hill, .-tall AfterCard > .hill, .-lofty AfterCard > .hill { display: block; }
    .-tall AfterCard > .earlier, .-lofty AfterCard > .earlier { display: block; }
    """
    enter = "Add another"
    """What Enter does, for the key bar."""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f", "app.fly", "Fly", tooltip="Choose a motor and save its forecast")
    ]
    text = ""
    _drawn: tuple[Callable[[str], None], ...] = ()

    def compose(self) -> ComposeResult:
        """From the comparison to the suggestion, and below it the next flight and earlier ones."""
        yield Static("", classes="heading")
        with Horizontal():
            yield Big()
            yield Static("", classes="facts")
        yield Static("", classes="bars")
        yield Static("", classes="next")
        yield Plot(classes="hill")
        yield Static("", classes="earlier")

    def on_mount(self) -> None:
        """Set the titles of the plot and the card."""
        self.query_one(
            Plot
        ).border_title = "The next flight: filled 90%, line the median; ◆ this flight, outline its forecast"
        self.border_subtitle = "Enter to add the next flight"

    def saved(self, id: str, flight: Flight, system: str) -> None:
        """Show the flight itself, as soon as it is in the ledger."""
        self._drawn = (partial(self._show_flight, id, flight),)
        self.redraw(system)
        self.scroll_home(animate=False, immediate=True)

    def show(self, found: AfterFlight | None, system: str) -> None:
        """Show the comparison, once it is computed."""
        self._drawn = (*self._drawn[:1], partial(self._show_outcome, found))
        self.redraw(system)

    def redraw(self, system: str) -> None:
        """Show the same in the units of a system."""
        for draw in self._drawn:
            draw(system)

    def _show_flight(self, id: str, flight: Flight, system: str) -> None:
        self.border_title = Content(printable(f"Saved {flight_label(id)}"))
        heading = cards.heading(flight.with_changes(date_time=None), "")
        self._put(".heading", Content(heading).stylize("bold"))
        self.query_one(Big).show(number(cards.APOGEE, flight.apogee, system) if flight.apogee is not None else "")
        for place in (".bars", ".next", ".earlier"):
            self._put(place, "")
        self._put(".facts", WORKING_TEXT)
        self._hill(None)
        self.text = heading

    def _show_outcome(self, found: AfterFlight | None, system: str) -> None:
        if found is None:
            self._put(".facts", NO_FORECAST)
            return
        outcome = found.outcome
        facts = [("Flown", measure(cards.APOGEE, outcome.flight.apogee, system)), *outcome_facts(outcome, system)]
        advice = suggestion_line(found.next, system)
        self._put(".facts", cards.lines("", facts))
        rows = [
            IntervalBar("forecast", *outcome.forecast, outcome.flight.apogee),
            IntervalBar("next", *outcome.next_flight),
        ]
        self._put(".bars", _drawn(rows, system, "90% interval, ● median, ◆ flown"))
        self._put(".next", hanging([f"Suggested  {advice}"]))
        flown = outcome.flight.apogee
        marks = [Marked("◆", flown)] if flown is not None else []
        after, before, unit = outcome.after.apogee, outcome.before.apogee, shown_unit(cards.APOGEE, system)
        self._hill(draw_density(after, partial(_height, system), *marks, former=before, unit=unit))
        if found.earlier:
            self._put(".earlier", _drawn(_rows(found.earlier), system, "Earlier forecasts of this rocket"))
        self.text = "\n".join([self.text, cards.as_text("", facts), advice])

    def _hill(self, draw: DrawPlot | None) -> None:
        plot = self.query_one(Plot)
        plot.show(draw)
        plot.visible = draw is not None

    def _put(self, place: str, content: object) -> None:
        self.query_one(place, Static).update(content)  # type: ignore[arg-type]  # text or what draws itself


def _rows(earlier: Sequence[SavedForecast]) -> list[IntervalBar]:
    """Newest first."""
    return [
        IntervalBar(
            f"{one.flight.flight_id if one.flight else ''} {one.made.payload.get('motor', '')}",
            *one.interval,
            one.flown,
        )
        for one in reversed(earlier[-MAX_EARLIER:])
    ]


def _drawn(rows: Sequence[IntervalBar], system: str, title: str) -> Intervals:
    return Intervals(tuple(rows), partial(_height, system), {}, title)


def _height(system: str, height: float) -> str:
    return measure(cards.APOGEE, height, system)
