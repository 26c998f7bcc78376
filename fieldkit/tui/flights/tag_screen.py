"""Tags of a flight: a list that explains each, and their effect on Cd and the next forecast.

The card next to the tags of a flight: the meaning of the current tag, and the effect of the tags on the forecast.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from textual import events, on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import KNOWN_TAGS, TAGS, Flight
from fieldkit.forecast.prediction import Prediction
from fieldkit.quantities import counted, measure, shown_unit, with_sd
from fieldkit.safe_text import printable
from fieldkit.services.forecasts import predict_plans
from fieldkit.tui.asking import or_why
from fieldkit.tui.help import Help
from fieldkit.tui.next.intervals import IntervalBar, Intervals
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.dialogs import AskText
from fieldkit.tui.widgets.plots import Plot, draw_density
from fieldkit.tui.widgets.table import Head, Table

OWN_TAG_ROW = "another ..."
"""The row for a new tag."""
MAX_NAMED_FLIGHTS = 12
"""Tagged flights that are named individually. [1]"""


@dataclass(frozen=True, slots=True)
class Shift:
    """Results for the rocket with the current tags: Cd, and the next flight on the same motor."""

    forecast: Prediction

    def lines(self, system: str) -> list[tuple[str, str]]:
        """Cd, apogee and their basis."""
        one = self.forecast
        low, middle, high = (measure(cards.APOGEE, float(x), system) for x in one.apogee_quantiles())
        return [
            ("next Cd", with_sd(one.cd.mean(), one.cd.std())),
            ("next apogee", f"{middle}, 90% between {low} and {high}"),
            ("based on", counted(one.rests_on, "normal flight")),
        ]

    def apogee(self, name: str) -> IntervalBar:
        """The next apogee as a line. [m]"""
        return IntervalBar(name, *(float(x) for x in self.forecast.apogee_quantiles()))

    def drag(self, name: str) -> IntervalBar:
        """Cd as a line."""
        return IntervalBar(name, *(float(x) for x in np.quantile(self.forecast.cd, (0.05, 0.5, 0.95))))


class TagCard(VerticalScroll):
    """The current tag above, the effect of all tags of the flight below."""

    DEFAULT_CSS = """
    TagCard { padding: 0 1; }
    TagCard Static { height: auto; margin-bottom: 1; }
    TagCard Plot { height: 24vh; min-height: 9; border-top: solid $border-blurred; border-title-color: $foreground; }
    .-tall TagCard Plot { height: 1fr; max-height: 30; }
    """

    def compose(self) -> Iterable[Widget]:
        """Text and lines; a plot is added below."""
        for name in ("tag", "drag", "apogee"):
            yield Static(id=f"card-{name}")

    def show_tag(self, tag: str, there: bool, bearers: Sequence[str]) -> None:
        """Show the meaning of a tag, whether the flight has it, and which flights of the rocket have it."""
        more = f" and {len(bearers) - MAX_NAMED_FLIGHTS} more" if len(bearers) > MAX_NAMED_FLIGHTS else ""
        pairs = [
            ("meaning", meaning(tag)),
            ("effect", f"a flight with it is {'not' if tag in TAGS else 'still'} used in the model"),
            ("now", "" if tag == OWN_TAG_ROW else "this flight has it" if there else "this flight does not have it"),
            ("flights", ", ".join(bearers[:MAX_NAMED_FLIGHTS]) + more if bearers else ""),
        ]
        self.query_one("#card-tag", Static).update(cards.lines(tag, pairs, 9))

    def show_shift(self, before: Shift, now: Shift, system: str) -> None:
        """Show Cd and the next apogee when the list was opened, and now."""
        same = before.forecast is now.forecast
        for name, title, spelled in (
            ("drag", "Cd of the next flight, 90% interval, ● median", lambda value: f"{value:.2f}"),
            ("apogee", "Apogee of its next flight on this motor", lambda value: measure(cards.APOGEE, value, system)),
        ):
            rows = (
                [getattr(now, name)("with these")]
                if same
                else [getattr(before, name)("before"), getattr(now, name)("now")]
            )
            self.query_one(f"#card-{name}", Static).update(Intervals(tuple(rows), spelled, {}, title))
        plot = next(iter(self.query(Plot)), None)
        if plot is None:
            plot = Plot()
            self.mount(plot)
        plot.border_title = Content("next apogee" + ("" if same else "; outline before"))
        former = None if same else before.forecast.apogee
        unit = shown_unit(cards.APOGEE, system)
        plot.show(
            draw_density(now.forecast.apogee, lambda at: measure(cards.APOGEE, at, system), former=former, unit=unit)
        )


def meaning(tag: str) -> str:
    """The meaning of a tag."""
    own = "type a tag of your own, such as windy" if tag == OWN_TAG_ROW else "your own tag"
    return KNOWN_TAGS.get(tag, own)


class TagScreen(PageScreen):
    """One row per tag; Enter or the space bar adds or removes it, at once and undoable."""

    NAME = "flights"
    ON_ENTER = ("On/off", "Set or clear this tag")
    TITLE = "Tags"
    ABOUT = Help(
        "A tag marks an anomaly. A tagged flight stays in the ledger but is not used in the model. Below the list is "
        "the effect on the rocket's drag and on the forecast of its next flight on the same motor, before your "
        "changes and now. Press u to undo, any number of times.",
        tuple(KNOWN_TAGS.items()),
        ("fieldkit tag FLIGHT TAG", "fieldkit untag FLIGHT TAG", "fieldkit undo"),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "mark", "Mark", tooltip="Set or clear this tag", show=False),
        Binding("escape", "back", "Done", priority=True, tooltip="Back to the flight"),
    ]
    DEFAULT_CSS = """
    TagScreen #which { height: auto; padding: 0 1; text-style: bold; }
    TagScreen #left { width: 1fr; }
    TagScreen TagCard { width: 34%; min-width: 40; display: none; border-left: solid $border-blurred; }
    TagScreen.-wide TagCard { display: block; }
    TagScreen.-wide #means { display: none; }
    TagScreen Table { height: 1fr; min-height: 5; }
    TagScreen.-tall Table { height: 14; margin-bottom: 1; }
    TagScreen #means { height: auto; padding: 0 1; }
    TagScreen #effect { height: auto; max-height: 9; padding: 0 1; border-top: solid $border-blurred; }
    """

    def __init__(self, id: str, flight: Flight) -> None:
        super().__init__()
        self._flight_id, self._flight = id, flight
        self._before: Shift | None = None
        self._now: Shift | None = None
        self._bearers: dict[str, list[str]] = {}
        self._own_tags: list[str] = []

    def body(self) -> Iterable[Widget]:
        """The flight, the tags, the effect; beside them, if there is room, the current tag."""
        yield Static(id="which")
        with Horizontal():
            with Vertical(id="left"):
                yield Table(id="tags", enter=self.ON_ENTER[0])
                yield Static(id="means")
                yield Static("computing the effect of the tags ...", id="effect")
            yield TagCard()

    def on_mount(self) -> None:
        """Focus the list, so that the first key goes to it."""
        self._list(self._flight)
        self.set_focus(self.query_one(Table))

    def reload(self) -> None:
        """Read the flight and the forecasts with its tags."""
        self.ask(self._read, self._have)

    def _read(self) -> tuple[Flight, dict[str, list[str]]]:
        """The flight, and the flights of its rocket by tag."""
        flight = self.resources.ledger.flight(self._flight_id)
        bearers: dict[str, list[str]] = {}
        for one in self.resources.ledger.flights(flight.rocket):
            for tag in one.tags:
                bearers.setdefault(tag, []).append(one.flight_id)
        return flight, bearers

    def _have(self, read: tuple[Flight, dict[str, list[str]]]) -> None:
        flight, self._bearers = read
        self._list(flight)
        self.ask(or_why(partial(self._shift, flight)), self._have_shift, "effect", alone="app")

    def _list(self, flight: Flight) -> None:
        """List the tags, with a mark at those of the flight."""
        self._flight = flight
        self.query_one("#which", Static).update(Content(cards.heading(flight, self._flight_id)))
        new = (tag for tag in flight.tags if tag not in KNOWN_TAGS)
        self._own_tags = list(dict.fromkeys([*self._own_tags, *new]))  # a cleared one can be set again
        rows = {
            tag: ("" if tag == OWN_TAG_ROW else "[x]" if tag in flight.tags else "[ ]", tag, meaning(tag))
            for tag in (*KNOWN_TAGS, *self._own_tags, OWN_TAG_ROW)
        }
        self.query_one(Table).show([Head("on", 3), Head("tag", 15), Head("meaning", 0)], list(rows), rows.__getitem__)
        self._moved()

    def _shift(self, flight: Flight) -> Shift:
        if not flight.motor:
            raise ImpossibleFlight("no forecast of the same flight: its motor is not known")
        plan = Flight(rocket=flight.rocket, config=flight.config, motor=flight.motor, dry_mass=flight.dry_mass)
        (forecast,) = predict_plans(self.resources.ledger, self.resources.motors, [plan], save="nothing")
        return Shift(forecast)

    def _have_shift(self, shift: Shift | str) -> None:
        if isinstance(shift, str):
            self.query_one("#effect", Static).update(Content(printable(shift)))
            return
        self._before, self._now = self._before or shift, shift
        system = self.resources.settings.units
        before, now = self._before.lines(system), shift.lines(system)
        pairs = [
            pair
            for (name, old), (_, new) in zip(before, now, strict=True)
            for pair in ((name, old), (" ", "" if new == old else f"now {new}"))
        ]
        self.query_one("#effect", Static).update(cards.lines("With these tags", pairs, 11))
        self._beside()

    def _beside(self) -> None:
        """Draw the effect of the tags, if there is room."""
        if self.has_class("-wide") and self._before is not None and self._now is not None:
            self.query_one(TagCard).show_shift(self._before, self._now, self.resources.settings.units)

    def on_resize(self, _event: events.Resize) -> None:
        """Draw the pictures if the new size has room for them."""
        self.call_later(self._beside)  # after the screen has its width

    @on(Table.Moved)
    def _moved(self) -> None:
        """Show the meaning of the current tag."""
        tag = self.query_one(Table).current
        self.query_one("#means", Static).update(Content(printable(f"{tag}: {meaning(tag)}")))
        self.query_one(TagCard).show_tag(tag, tag in self._flight.tags, self._bearers.get(tag, []))

    @on(Table.Chosen)
    def action_mark(self) -> None:
        """Add the current tag to the flight, or remove it."""
        tag = self.query_one(Table).current
        if tag == OWN_TAG_ROW:
            self.app.push_screen(AskText("A tag of your own", "", "One word, such as windy."), self._own)
        else:
            self._change(tag)

    def _own(self, text: str | None) -> None:
        if text and text.strip():
            self._change(text.strip())

    def _change(self, tag: str) -> None:
        """Add a tag, or remove it if present; fast keys are handled one after the other."""

        def work() -> None:
            ledger = self.resources.ledger
            there = tag in ledger.flight(self._flight_id).tags
            (ledger.untag if there else ledger.tag)(self._flight_id, tag)

        self.change(work, lambda _: self.field_app.changed())

    def copied(self) -> str:
        """The current tag and its meaning."""
        return self.query_one(Table).current_text()
