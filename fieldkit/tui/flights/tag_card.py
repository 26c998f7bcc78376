"""The card next to the tags of a flight: the meaning of the current tag, and the effect of the tags on the forecast."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from textual.containers import VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.flight import KNOWN_TAGS, TAGS
from fieldkit.forecast.prediction import Prediction
from fieldkit.quantities import counted, measure, with_sd
from fieldkit.tui.next.intervals import IntervalBar, Intervals
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.plots import Plot, draw_density

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
            ("Cd", with_sd(one.cd.mean(), one.cd.std())),
            ("next apogee", f"{middle}, 90% between {low} and {high}"),
            ("based on", counted(one.rests_on, "clean flight")),
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
    TagCard Plot { height: 24vh; min-height: 12; border-top: solid $border-blurred; border-title-color: $foreground; }
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
            ("drag", "Cd of the rocket, 90% interval, ● median", lambda value: f"{value:.2f}"),
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
        plot.border_title = Content("next apogee with these tags" + ("" if same else "; outline before"))
        former = None if same else before.forecast.apogee
        plot.show(draw_density(now.forecast.apogee, lambda at: measure(cards.APOGEE, at, system), former=former))


def meaning(tag: str) -> str:
    """The meaning of a tag."""
    own = "type a tag of your own, such as windy" if tag == OWN_TAG_ROW else "your own tag"
    return KNOWN_TAGS.get(tag, own)
