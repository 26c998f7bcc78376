"""The pictures of the Decide screen: delays around apogee, densities of apogees and points, forecasts and results."""

from collections.abc import Sequence
from dataclasses import replace

from fieldkit.forecast.evaluation.forward_in_time import Forecast
from fieldkit.planning.delay import Delays
from fieldkit.quantities import measure
from fieldkit.services.saved_forecasts import LISTED_STATES, SavedForecast
from fieldkit.shapes import Array, Float
from fieldkit.tui.next.answer import Answer
from fieldkit.tui.next.intervals import IntervalBar, Intervals
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.plots import Marked, draw_density

MAX_DRAWN_FORECASTS = 24
"""Number of latest forecasts to draw."""


def of_delays(answer: Answer, judged: Delays) -> Answer:
    """When each delay fires, relative to apogee, and below it the coast to apogee with the delays."""
    rows = tuple(
        IntervalBar(f"{one.delay:g} s{'' if one.on_sale else '*'}", *one.after_apogee)
        for one in sorted(judged.delays, key=lambda one: one.delay)
        if one.after_apogee is not None
    )
    if not rows:
        return answer
    title = "When each delay fires, 90% of flights, ● median; ◎ is apogee"
    delays = [one.delay for one in judged.delays]
    return replace(
        answer,
        title=title,
        intervals=Intervals(rows, lambda value: f"{value:+.1f} s", {"apogee": 0.0}),
        below="The coast from burnout to apogee; lines are the delays",
        draw=draw_density(judged.coasts, lambda value: f"{value:g} s", ticks=delays),
    )


def of_apogee(answer: Answer, apogee: Float[Array, "draw"], target: float | None, system: str) -> Answer:
    """The density of the apogee at that mass, with the target; without one, at the mass of the plan."""
    marks = [Marked("◎", target)] if target is not None else []
    at = " at that mass; ◎ is the target" if target is not None else ""
    title = f"Apogee on the altimeter{at}; filled 90%, line the median"
    return replace(answer, title=title, draw=draw_density(apogee, lambda height: _height(height, system), *marks))


def of_points(answer: Answer, points: Float[Array, "draw"]) -> Answer:
    """The density of the points of a flight."""
    draw = draw_density(points, lambda value: f"{value:.0f}")
    return replace(answer, title="Points of a flight, fewer are better; filled 90%, line the median", draw=draw)


def saved_forecast_plot(answer: Answer, found: Sequence[SavedForecast], system: str) -> Answer:
    """The saved forecasts, newest first, and the apogees flown."""
    rows = tuple(
        IntervalBar(f"{one.made.at.astimezone():%m-%d} {one.made.payload.get('motor', '')}", *one.interval, one.flown)
        for one in reversed([one for one in found if one.state in LISTED_STATES][-MAX_DRAWN_FORECASTS:])
    )
    return _against_flown(answer, rows, system)


def of_forecasts(answer: Answer, rows: Sequence[Forecast], system: str) -> Answer:
    """Each flight with its forecast from the earlier ones, the newest first."""
    last = [(one, one.corrected or (one.p05, one.p95)) for one in reversed(rows[-MAX_DRAWN_FORECASTS:])]
    drawn = tuple(
        IntervalBar(f"{one.flight_id} {one.motor}", low, one.p50, high, one.flown) for one, (low, high) in last
    )
    return _against_flown(answer, drawn, system)


def _against_flown(answer: Answer, rows: tuple[IntervalBar, ...], system: str) -> Answer:
    if not rows:
        return answer
    title = "Forecast and flown: 90% of flights should fall on the line; ● median, ◆ flown"
    return replace(answer, title=title, intervals=Intervals(rows, lambda height: _height(height, system), {}))


def _height(height: float, system: str) -> str:
    return measure(cards.APOGEE, height, system)
