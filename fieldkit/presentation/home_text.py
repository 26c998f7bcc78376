"""The next flight in words and figures, for the app's Home page."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.columns import WEATHER
from fieldkit.flight.short_name import has_derived_id
from fieldkit.quantities import counted, measure, number, spelled, unit_of

if TYPE_CHECKING:
    from fieldkit.services.launch_day import Overview
    from fieldkit.services.listed_flights import ListedFlight
    from fieldkit.services.saved_forecasts import SavedForecast

APOGEE = BY_NAME["apogee"]
SPARKS = "▁▂▃▄▅▆▇█"


def build_of(flight: Flight) -> str:
    """A rocket with its configuration: `Astra A`."""
    return f"{flight.rocket} {flight.config}".strip() or "Rocket not named"


def next_lines(view: "Overview", system: str) -> Iterator[str]:
    """The next rocket to fly, with its mass if the plan has one."""
    plan = view.plan
    parts = [build_of(plan), measure(BY_NAME["dry_mass"], plan.dry_mass, system)]
    yield ", ".join(part for part in parts if part)


def weather_line(conditions: Flight, system: str) -> str:
    """The weather of the day, `Today: wind 2.1 m/s, 21 °C`, or how to enter it."""
    known = [
        f"{'wind ' if name == 'wind' else ''}{measure(BY_NAME[name], conditions.number(name), system)}"
        for name in WEATHER
        if conditions.number(name) is not None
    ]
    return f"Today: {', '.join(known)}" if known else "Weather today: e to enter it"


def forecast_title(one: "SavedForecast") -> str:
    """Rocket and motor: `Astra A on F24-4W`."""
    made = one.made
    build = f"{made.rocket} {made.payload.get('config', '')}".strip()
    return f"{build} on {made.payload.get('motor', '')}"


def forecast_lines(one: "SavedForecast", system: str) -> Iterator[str]:
    """Details of the forecast apogee: its unit, the interval, when it was saved, whether it is stale."""
    low, _, high = (f"{float(number(APOGEE, value, system)):.0f}" for value in one.interval)
    yield f"{spelled(unit_of(APOGEE, system))} forecast"
    yield f"90% {low}-{high}"
    yield f"saved {one.made.at.astimezone():%m-%d %H:%M}" + (", stale" if one.stale else "")


def flown_title(one: "ListedFlight") -> str:
    """A flight in a line: `12 · Astra B · F39 · 04-18 14:35`, without an id that was derived."""
    name = "" if has_derived_id(one.flight) else one.flight.flight_id
    when = f"{one.flight.date_time:%m-%d %H:%M}" if one.flight.date_time else ""
    return " · ".join(part for part in (name, build_of(one.flight), one.flight.motor, when) if part)


def flown_lines(one: "ListedFlight", system: str) -> Iterator[str]:
    """Details of the flown apogee: its unit, and how it compares with its forecast."""
    yield f"{spelled(unit_of(APOGEE, system))} flown"
    forecast = one.forecast
    if forecast is None or forecast.miss is None or one.flight.apogee is None:
        yield "no forecast was saved for it"
        return
    low, middle, high = forecast.interval
    way = "high" if forecast.miss >= 0 else "low"
    where = "inside" if low <= one.flight.apogee <= high else "OUTSIDE"
    yield f"forecast {number(APOGEE, middle, system)}"
    yield f"{number(APOGEE, abs(forecast.miss), system)} {way}, {where}"


def day_line(flights: "Sequence[ListedFlight]", system: str) -> str:
    """The flights of a day in a line: `3 flights today ▂▅█ 210 to 281 m`."""
    apogees = [one.flight.apogee for one in reversed(flights) if one.flight.apogee is not None]
    today = f"{counted(len(flights), 'flight')} today"
    if not apogees:
        return today if flights else "No flights yet today"
    if len(apogees) == 1:
        return f"{today}, to {measure(APOGEE, apogees[0], system)}"
    ends = f"{number(APOGEE, min(apogees), system)} to {measure(APOGEE, max(apogees), system)}"
    return f"{today}  {sparkline(apogees, len(apogees))}  {ends}"


def sparkline(values: Sequence[float], width: int) -> str:
    """Values as a row of bars scaled from the minimum to the maximum; each bar is the maximum of its values if there
    are many."""
    if not values:
        return ""
    width = min(width, len(values))
    cells = [max(values[len(values) * at // width : len(values) * (at + 1) // width]) for at in range(width)]
    low, high = min(cells), max(cells)
    scale = (len(SPARKS) - 1) / ((high - low) or 1.0)
    return "".join(SPARKS[round((value - low) * scale)] for value in cells)


COMPUTED = "~"
"""Mark of a miss against what the other flights lead to expect, if no forecast was saved."""


def marked_miss(miss: float | None, system: str, *, inside: bool, computed: bool) -> str:
    """A miss [m] with its sign, after the marks of one outside its interval and of one computed from other flights;
    empty for None."""
    if miss is None:
        return ""
    marks = ("" if inside else "!") + COMPUTED * computed
    return f"{marks}{'+' if miss >= 0 else '-'}{number(APOGEE, abs(miss), system)}"
