"""The two cards of the Home page: the open forecast, and the last flight with its forecast."""

from collections.abc import Iterable, Sequence
from datetime import date
from typing import TYPE_CHECKING, Any

from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Static

from fieldkit.flight import BY_NAME
from fieldkit.presentation import home_text
from fieldkit.quantities import number
from fieldkit.safe_text import printable
from fieldkit.tui.next.intervals import IntervalBar, bar
from fieldkit.tui.widgets.big import Big

if TYPE_CHECKING:
    from fieldkit.services.launch_day import Overview

APOGEE = BY_NAME["apogee"]


class HomeCard(Vertical):
    """A heading, a large number with text beside it, an interval, a last line. They are mounted when there is something
    to show, so that the first rows of the page do not wait for them."""

    DEFAULT_CSS = """
    HomeCard { width: 1fr; height: 1fr; border: round $border-blurred; padding: 0 1; margin: 0 1;
        border-title-color: $foreground; border-subtitle-color: $foreground; }
    HomeCard > Static { height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; }
    HomeCard > .heading { text-style: bold; }
    HomeCard > .bar { color: $accent; }
    HomeCard Horizontal { height: 3; }
    HomeCard Horizontal > .words { width: 1fr; height: 3; padding: 0 0 0 2; }
    HomeCard.-plain Horizontal, HomeCard.-plain .bar { display: none; }
    HomeCard.-plain > .last { height: auto; text-wrap: wrap; }
    """
    interval: IntervalBar | None = None

    def __init__(self, **rest: Any) -> None:
        super().__init__(**rest)
        self._big = Big()
        self._heading, self._words, self._bar, self._last = (
            Static("", classes=name) for name in ("heading", "words", "bar", "last")
        )

    def _fill(self) -> None:
        """Mount the contents, from top to bottom."""
        if not self.children:
            self.mount(self._heading, Horizontal(self._big, self._words), self._bar, self._last)

    def say(self, heading: str, last: str = "") -> None:
        """Show only text: no number is known."""
        self._fill()
        self.add_class("-plain")
        self.interval = None
        self._heading.update(lines(heading))
        self._last.update(lines(last))

    def figure(self, heading: str, value: str, words: Iterable[str], interval: IntervalBar | None, last: str) -> None:
        """Show a number, the text beside it, and its interval."""
        self._fill()
        self.remove_class("-plain")
        self._heading.update(lines(heading))
        self._big.show(value)
        self._words.update(lines("\n".join(words)))
        self._last.update(lines(last))
        self.interval = interval
        self.on_resize()

    def on_resize(self) -> None:
        """Draw the interval as wide as the card."""
        width = self.size.width - 2
        row = self.interval
        self._bar.update(Content(bar(row, *row.ends, width) if row is not None and width > 10 else ""))


def lines(text: str) -> Content:
    """A text of several lines as content, safe for a terminal."""
    return Content("\n".join(printable(line) for line in text.splitlines()))


class NextCard(HomeCard):
    """The next flight."""

    def on_mount(self) -> None:
        """Set the title."""
        self.border_title = "Next flight"

    def show(self, view: "Overview | None", system: str) -> None:
        """Show the open forecast, else the rocket to plan."""
        self.border_subtitle = ""
        if view is None:
            self.say("No rocket yet. Choose a first step below and press Enter.")
            return
        weather = home_text.weather_line(view.weather, system)
        forecast = view.forecast
        if forecast is None:
            heading = "\n".join(home_text.next_lines(view, system))
            self.say(heading, f"No open forecast. f to choose a motor, then Enter to save its forecast.\n{weather}")
            return
        low, middle, high = forecast.interval
        title, words = home_text.forecast_title(forecast), home_text.forecast_lines(forecast, system)
        big = number(APOGEE, middle, system)
        self.border_subtitle = "Flown? a to add it"
        self.figure(title, big, words, IntervalBar("", low, middle, high), weather)


class LastCard(HomeCard):
    """The last flight."""

    def on_mount(self) -> None:
        """Set the title."""
        self.border_title = "Last flight"

    def show(self, view: "Overview | None", system: str, today: date) -> None:
        """Show the last flight with its forecast, and the flights of the day in one line."""
        last = view.last if view is not None else None
        self.display = view is not None
        if view is None or last is None or last.flight.apogee is None:
            self.say("Nothing has flown yet.")
            return
        forecast, apogee = last.forecast, last.flight.apogee
        interval = IntervalBar("", *forecast.interval, flown=apogee) if forecast is not None else None
        words: Sequence[str] = list(home_text.flown_lines(last, system))
        title, day = home_text.flown_title(last), home_text.day_line(view.on(today), system)
        self.figure(title, number(APOGEE, apogee, system), words, interval, day)
