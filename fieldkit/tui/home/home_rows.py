"""The latest flights on the Home page: one row per flight, with its profile and its forecast if there is room."""

from collections.abc import Callable, Sequence

from rich.cells import cell_len
from textual.content import Content

from fieldkit.flight import BY_NAME
from fieldkit.flight.makers import motor_name
from fieldkit.presentation.home_text import build_of, marked_miss, sparkline
from fieldkit.quantities import number
from fieldkit.services.listed_flights import ListedFlight
from fieldkit.settings import Settings
from fieldkit.tui.asking import go_on, or_why
from fieldkit.tui.next.intervals import HeightScale, heading
from fieldkit.tui.resources import IMPORTING, Resources
from fieldkit.tui.widgets.states import CAUTION_COLOR, GOOD_COLOR
from fieldkit.tui.widgets.table import Head

PROFILE_CELLS, MOTOR_CELLS = 16, 10
"""Widths of the sparkline and of the motor of a flight. [cell]"""
TAG_CELLS = 12
"""Width of the tags of a flight. [cell]"""
MAX_BARS = 16
"""Number of latest misses in a trend. [1]"""
MIN_BAR = 20
"""Minimum width of the interval of a forecast. [cell]"""
NORMAL_TABLE, WIDE_TABLE = 70, 96
"""Widths above which a table has room for tags and for profiles, and for the interval of each forecast. [cell]"""
APOGEE = BY_NAME["apogee"]


def listed(
    flights: Sequence[ListedFlight], settings: Settings, width: int
) -> tuple[list[Head], Callable[[ListedFlight, str], Sequence[str]]]:
    """The columns that fit in a width, without those that are empty for all flights, and the cells of a flight and its
    profile, all intervals on one scale."""
    scale = HeightScale.of(((one.interval, one.flight.apogee) for one in flights), settings.target)
    tagged = TAG_CELLS + 1 if width >= NORMAL_TABLE and any(one.flight.tags for one in flights) else 0
    logged = width >= NORMAL_TABLE + tagged and any(one.flight.has_log for one in flights)
    profiles = PROFILE_CELLS if logged else 0
    seen = {
        "when": any(one.flight.date_time for one in flights),
        "miss": any(one.miss is not None for one in flights),
        "tags": tagged > 0,
    }
    others = [head for head in _heads(profiles, 0, scale, settings.units) if seen.get(head.title, True)]
    room = width - sum(head.width + 1 for head in others) - 1
    longest = max((cell_len(build_of(one.flight)) for one in flights), default=0)
    bars = max(MIN_BAR, room - max(6, longest) - 1) if width >= WIDE_TABLE else 0
    heads, cells = _heads(profiles, bars, scale, settings.units), _row(profiles, bars, scale, settings.units)
    if tagged and not bars:  # the rocket as wide as its name, tags as wide as the room
        heads[2], heads[6] = Head("rocket", max(6, min(longest, room))), Head("tags", 0)
    shown = [n for n, head in enumerate(heads) if seen.get(head.title, True)]
    return [heads[n] for n in shown], lambda one, profile: [cells(one, profile)[n] for n in shown]


def _heads(profiles: int, bars: int, scale: HeightScale, system: str) -> list[Head]:
    heads = [Head("id", 5, tail=True), Head("when", 11), Head("rocket", 0), Head("motor", MOTOR_CELLS)]
    heads += [Head("apogee", 7, True), Head("miss", 7, True), Head("tags", TAG_CELLS)]
    heads += [Head("profile", profiles)] if profiles else []
    return [*heads, Head(heading(bars, scale, system), bars)] if bars else heads


def _row(profiles: int, bars: int, scale: HeightScale, system: str) -> Callable[[ListedFlight, str], Sequence[str]]:

    def cells(one: ListedFlight, profile: str) -> Sequence[str]:
        flight, forecast = one.flight, one.forecast
        when = f"{flight.date_time:%m-%d %H:%M}" if flight.date_time else ""
        apogee = "" if flight.apogee is None else number(APOGEE, flight.apogee, system)
        stale = "*" if forecast is not None and forecast.stale and forecast.miss is not None else ""
        computed = one.forecast is None or one.forecast.miss is None
        miss = marked_miss(one.miss, system, inside=_inside(one), computed=computed) + stale
        motor = motor_name(flight.motor, MOTOR_CELLS)
        texts = [flight.flight_id, when, build_of(flight), motor, apogee, miss, " ".join(flight.tags)]
        texts += [profile] if profiles else []
        return [*texts, scale.line(one.interval, flight.apogee, bars)] if bars else texts

    return cells


def _inside(one: ListedFlight) -> bool:
    """Whether a flight is within its interval, or has none."""
    return one.interval is None or one.flight.apogee is None or one.interval[0] <= one.flight.apogee <= one.interval[2]


def trend(flights: Sequence[ListedFlight], rocket: str) -> Content:
    """The misses of a rocket's latest flights as bars, from the first to the last, in the colors of those inside their
    intervals and of those outside; empty for fewer than two."""
    missed = [one for one in flights if one.flight.rocket == rocket and one.miss is not None][:MAX_BARS][::-1]
    if len(missed) < 2:
        return Content()
    bars = sparkline([0.0, *(abs(one.miss or 0.0) for one in missed)], MAX_BARS + 1)[1:]
    colors = [GOOD_COLOR if _inside(one) else CAUTION_COLOR for one in missed]
    return Content.assemble("misses ", *((bar, f"${color}") for bar, color in zip(bars, colors, strict=True)))


def logs_of(resources: Resources, flights: Sequence[ListedFlight]) -> dict[str, str]:
    """The profile of each flight by its id, empty if its log cannot be read or has no altitude. Raises Dropped."""
    with IMPORTING:
        from fieldkit.tui.flights.log_plot import Drawn, drawn  # takes 0.16 s to import

    found: dict[str, str] = {}
    for one in flights:
        go_on()
        log = or_why(lambda id=one.id: drawn(resources.ledger, id, "SI"))()  # type: ignore[misc]  # bound at once
        trace = log.traces.get("altitude") if isinstance(log, Drawn) else None
        found[one.id] = sparkline(trace.values, PROFILE_CELLS) if trace is not None else ""
    return found
