"""The rows of the Flights page: a flight with its results, the columns, and the text that a filter searches."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from fieldkit.flight import Flight
from fieldkit.flight.makers import motor_name
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.presentation.home_text import marked_miss
from fieldkit.quantities import number
from fieldkit.services.saved_forecasts import by_flight, list_forecasts
from fieldkit.tui.next.intervals import Bounds, HeightScale, heading
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.table import Head

WITH_FORECASTS, TIGHT = 98, 76
"""Minimum widths of a table with forecasts drawn next to all figures, and next to the most important ones: those on
screens of 100 columns, and of 120 with the card beside it. [cell]"""
MAX_ROCKET, MAX_TAGS = 12, 15
"""Maximum widths of a rocket's name where the date is written in full, and of tags next to drawn forecasts: the longest
tag that fieldkit knows. [cell]"""
MIN_DRAWN = 10
"""Minimum width of a drawn forecast. [cell]"""


@dataclass(slots=True, eq=False)
class FlightRow:
    """A flight with its results; `place` is its index in the order flown, `miss` is flown minus forecast [m]; `drag`
    (Cd [1]) and `thrust` (relative to the certified one [1]) are added later.

    `drag` stays None without a diameter. `stale` means that inputs of the `forecast` had changed when the flight was
    added.
    """

    id: str
    place: int
    flight: Flight
    miss: float | None = None
    stale: bool = False
    forecast: Bounds | None = None
    hay: str = ""
    """The text that a filter searches."""
    drag: float | None = None
    thrust: float | None = None
    expected: Bounds | None = None
    """The apogee to expect from the other flights, in place of a forecast. [m]"""

    @property
    def interval(self) -> Bounds | None:
        """The saved forecast, or else what the other flights lead to expect. [m]"""
        return self.forecast or self.expected

    @property
    def gap(self) -> float | None:
        """Flown minus the middle of `interval`. [m]"""
        if self.miss is not None or self.expected is None or self.flight.apogee is None:
            return self.miss
        return self.flight.apogee - self.expected[1]

    @property
    def inside(self) -> bool:
        """Whether it flew within its interval, or has none."""
        apogee = self.flight.apogee
        return self.interval is None or apogee is None or self.interval[0] <= apogee <= self.interval[2]


@dataclass(frozen=True, slots=True)
class Shown:
    """A column of the table: heading, width, text of a row, and sort key."""

    title: str
    width: int
    text: Callable[[FlightRow, str], str]
    order: Callable[[FlightRow], Any]
    right: bool = False
    falls: bool = False
    """Whether the first sort by this column puts the largest first."""
    name: str = ""
    """Its name at every width, if its heading depends on the width."""

    @property
    def key(self) -> str:
        """The name by which the order of the table is kept when other columns fit."""
        return self.name or self.title


def _number(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _miss(row: FlightRow, system: str) -> str:
    return marked_miss(row.gap, system, inside=row.inside, computed=row.miss is None) + "*" * row.stale


def _date(form: str) -> Callable[[FlightRow, str], str]:
    return lambda row, _: f"{row.flight.date_time:{form}}" if row.flight.date_time else ""


def columns(
    width: int,
    scale: HeightScale,
    system: str = "SI",
    *,
    beside: bool = False,
    rocket: int = MAX_ROCKET,
    tags: int = 0,
) -> list[Shown]:
    """The columns that fit: narrow screens shorten the date, the rocket and the tags; with enough room, the forecast
    and the flown apogee are drawn on a scale; a narrow table `beside` the card of a flight has this too, without alpha
    if the tags leave no room for both. `rocket` and `tags` are the lengths of the longest rocket's name and of the
    longest tags. [cell]"""
    brief = beside and TIGHT <= width < WITH_FORECASTS
    wide, tight = width >= 134, width < TIGHT
    timed = width >= 108
    motor = 14 if wide else 6 if tight else 8
    fitted = max(len("rocket") + 1, min(rocket, MAX_ROCKET))
    shown = [
        Shown("id", 4 if not wide else 8, lambda r, _: r.flight.flight_id, lambda r: r.place),
        Shown(
            "date",
            16 if timed else 5 if tight or brief else 10,
            _date("%Y-%m-%d %H:%M" if timed else "%m-%d" if tight or brief else "%Y-%m-%d"),
            lambda r: (r.flight.date_time or datetime.min, r.place),
            falls=True,
        ),
        Shown(
            "rocket",
            14 if wide else 6 if tight else min(fitted, 8) if brief else 0 if width >= WITH_FORECASTS else fitted,
            lambda r, _: r.flight.rocket,
            lambda r: r.flight.rocket.lower(),
        ),
        Shown(
            "config" if wide else "cfg",
            8 if wide else 3,
            lambda r, _: r.flight.config,
            lambda r: r.flight.config,
            name="config",
        ),
        Shown("motor", motor, lambda r, _: motor_name(r.flight.motor, motor), lambda r: r.flight.motor),
        Shown(
            "apogee",
            9 if wide else 7,
            lambda r, s: number(cards.APOGEE, r.flight.apogee, s) if r.flight.apogee is not None else "",
            lambda r: r.flight.apogee or 0.0,
            right=True,
            falls=True,
        ),
        Shown("Cd", 5 if not tight else 4, lambda r, _: _number(r.drag, ".2f"), lambda r: r.drag or 0.0, right=True),
        Shown(
            "α" if tight or brief else "thrust",
            4 if tight or brief else 6,
            lambda r, _: _number(r.thrust, ".2f"),
            lambda r: r.thrust or 0.0,
            right=True,
            name="alpha",
        ),
        Shown(
            "miss",
            6 if tight or brief else 7,
            _miss,
            lambda r: abs(r.gap) if r.gap is not None else -1.0,
            right=True,
            falls=True,
        ),
        Shown("tags", 0, lambda r, _: " ".join(r.flight.tags), lambda r: " ".join(r.flight.tags)),
    ]
    for drawn in (shown, [one for one in shown if one.key != "alpha"]) if brief else (shown,):
        left = width - sum(one.width + 1 for one in drawn) - 2
        room = left - max(len("tags") + 1, min(tags, MAX_TAGS)) if brief else int(left * 2 / 5)
        if room >= MIN_DRAWN and (brief or width >= WITH_FORECASTS):
            return [*drawn, _drawn(room, scale, system)]
    return shown


def _drawn(room: int, scale: HeightScale, system: str) -> Shown:
    """Forecasts and flown apogees on a scale in a width. [cell]"""
    return Shown(
        heading(room - 1, scale, system),  # and the arrow of a sorted column
        room,
        lambda r, _: scale.line(r.interval, r.flight.apogee, room),
        lambda r: r.interval[1] if r.interval is not None else -1.0,
        name="forecast",
    )


def read_rows(ledger: Ledger, motors: Catalogue) -> list[FlightRow]:
    """Every flight in the order flown, with its saved forecast and the error of that."""
    flights = ledger.flights()
    forecasts = by_flight(list_forecasts(ledger, motors))
    rows = []
    for place, (id, flight) in enumerate(zip(ledger.ids(flights), flights, strict=True)):
        one = forecasts.get((flight.rocket, flight.flight_id))
        row = FlightRow(id, place, flight, hay=haystack(id, flight))
        if one:
            row.miss, row.stale, row.forecast = one.miss, one.stale, one.interval
        rows.append(row)
    return rows


def scale_of(rows: Iterable[FlightRow], target: float | None) -> HeightScale:
    """The scale of all forecasts and flown apogees. [m]"""
    return HeightScale.of(((row.interval, row.flight.apogee) for row in rows), target)


def haystack(id: str, flight: Flight) -> str:
    """The text of a flight that a filter searches."""
    when = flight.date_time.isoformat(" ") if flight.date_time else ""
    texts = (id, flight.rocket, flight.config, flight.motor, flight.site, when, *flight.tags, flight.notes)
    return " ".join(texts).lower()


def headings(shown: Sequence[Shown], place: int, *, falls: bool) -> list[Head]:
    """The headings of some columns, with an arrow at the one at a place, which determines the order."""
    arrow = "▼" if falls else "▲"
    return [
        Head(one.title + (arrow if number == place else ""), one.width, one.right, tail=one.title == "id")
        for number, one in enumerate(shown)
    ]


def same_build(rows: Iterable[FlightRow], row: FlightRow) -> list[FlightRow]:
    """The flights of the same rocket in the same configuration."""
    name = (row.flight.rocket, row.flight.config)
    return [one for one in rows if (one.flight.rocket, one.flight.config) == name]
