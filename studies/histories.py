"""Every rocket of a ledger: the effect in its history, and the improvement of later forecasts.

Each flight is forecast from the earlier ones only, by the plain model and by the model after the loop on the earlier
flights. The loop runs again before every flight, without information from later ones.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.evaluation.comparison import judged_report
from fieldkit.forecast.evaluation.forward_in_time import Forecast
from fieldkit.forecast.predict import predict
from fieldkit.model.readout_data import observe
from fieldkit.motors import Found
from fieldkit.physics.history import history_of
from fieldkit.progress import ReportProgress, no_op
from fieldkit.safe_text import as_markdown
from fieldkit.scoring.bootstrap import LEVELS, resampled
from fieldkit.selection.diagnose import Diagnosis, diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.unexplained import leftover
from fieldkit.shapes import Array, Float

MIN_CLEAN_FLIGHTS = 4
"""Minimum number of clean flights with an apogee for the loop. [1]"""
DRAWS = 600


@dataclass(frozen=True, slots=True)
class RocketHistory:
    """One rocket: the verdict from all its flights, and the relative errors of later forecasts.

    `before` and `after` are forecast over flown apogee, minus one; `inside` is whether the flight was in the 90%
    interval, before and after; `verdicts` are the verdict at each of these flights.
    """

    rocket: str
    flights: int
    effect: str
    place: str
    before: Float[Array, "later"]
    after: Float[Array, "later"]
    inside: Float[Array, "2 later"]
    verdicts: tuple[str, ...]


def histories(
    rockets: Mapping[str, Sequence[tuple[Flight, Found]]], on_progress: ReportProgress = no_op
) -> list[RocketHistory]:
    """Every rocket with enough flights, most flights first."""
    known = {name: flown for name, flown in rockets.items() if len(_clean(flown)) >= MIN_CLEAN_FLIGHTS}
    found = []
    for number, (name, flown) in enumerate(known.items()):

        def report_flight(flight: str, fraction: float, name: str = name, number: int = number) -> None:
            on_progress(f"{name} {flight}", (number + fraction) / len(known))

        found.append(_history(name, flown, report_flight))
    return sorted(found, key=lambda one: -one.flights)


def _clean(flown: Sequence[tuple[Flight, Found]]) -> list[int]:
    return [row for row, (flight, _) in enumerate(flown) if flight.clean and flight.apogee is not None]


def _history(rocket: str, flown: Sequence[tuple[Flight, Found]], on_progress: ReportProgress) -> RocketHistory:
    clean = _clean(flown)
    rows = []
    for place, row in enumerate(clean[MIN_CLEAN_FLIGHTS:], start=MIN_CLEAN_FLIGHTS):
        on_progress(flown[row][0].flight_id, place / len(clean))
        rows.append(_forecast(flown[:row], flown[row]))
    whole = _close(flown)
    columns = np.array([row[:4] for row in rows], float).reshape(-1, 4).T
    verdicts = tuple(row[4] for row in rows)
    return RocketHistory(rocket, len(clean), whole.effect, _where(whole), columns[0], columns[1], columns[2:], verdicts)


def _close(flown: Sequence[tuple[Flight, Found]]) -> Diagnosis:
    """The loop on these flights."""
    flights, found = [flight for flight, _ in flown], [motor for _, motor in flown]
    used_in_fit = [flight.clean and flight.apogee is not None for flight in flights]
    history = history_of(flights, found, used_in_fit=used_in_fit)
    return diagnose(rocket_model(history), observe(history))


def _forecast(
    before: Sequence[tuple[Flight, Found]], flown: tuple[Flight, Found]
) -> tuple[float, float, bool, bool, str]:
    """The error of a flight's forecast without and with the loop on the earlier flights, and the verdict."""
    flight, motor = flown
    assert flight.apogee is not None
    plan = (flight.unflown(), motor)
    diagnosis = _close(before)
    (plain,) = predict(before, [plan], draws=DRAWS)
    (closed,) = predict(before, [plan], Assumed(diagnosis.averaged), draws=DRAWS)
    one, other = (forecast.apogee_quantiles() for forecast in (plain, closed))
    return (
        one[1] / flight.apogee - 1,
        other[1] / flight.apogee - 1,
        one[0] <= flight.apogee <= one[2],
        other[0] <= flight.apogee <= other[2],
        diagnosis.effect,
    )


def _where(diagnosis: Diagnosis) -> str:
    if diagnosis.effect == "unexplained":
        return leftover(diagnosis).in_words
    return ", ".join(f"{trial.candidate.place}" for trial in diagnosis.accepted)


def page(found: Sequence[RocketHistory], forecasts: Sequence[Forecast], *, unnamed: bool = False) -> str:
    """The histories as a page of Markdown; `unnamed` numbers the rockets and omits which flights an effect is in.

    `forecasts` are those of every flight from the earlier ones, by the model and its rivals.
    """
    return "\n".join([*_lines(found, unnamed), *_learning(forecasts)]) + "\n"


def _learning(forecasts: Sequence[Forecast]) -> Iterator[str]:
    """The gain from using earlier flights, for all rockets with two of them."""
    if not forecasts:
        return
    found = judged_report(forecasts)
    yield ""
    yield fill(
        f"All {len(forecasts)} flights with at least one earlier normal flight of their rocket, forecast from those "
        "and from the earlier flights of all other rockets, compared with simpler methods (`fieldkit score`):",
        118,
    )
    yield ""
    yield "| method | flights | median error | mean error | CRPS |"
    yield "|---|---|---|---|---|"
    for way in found.ways:
        yield f"| {way.name} | {way.flights} | {way.median_share:.1%} | {way.mean_share:.1%} | {way.crps:.1%} |"
    yield ""
    yield f"Of these flights, {found.coverage90:.0%} are in the 90% interval."


def _lines(found: Sequence[RocketHistory], unnamed: bool) -> Iterator[str]:
    yield "# Effects in real histories"
    yield ""
    yield fill(
        f"Every rocket with at least {MIN_CLEAN_FLIGHTS} normal flights that have an apogee. The verdict is the "
        f"loop's on all of them. Each flight after the first {MIN_CLEAN_FLIGHTS} is forecast from the earlier ones "
        "only: without a correction (*before*), and with what the loop finds in those earlier flights (*after*). "
        "Errors are fractions of the flown apogee.",
        118,
    )
    yield ""
    if not found:
        yield "No rocket has enough flights."
        return
    headers = "rocket", "flights", "verdict", "later flights", "error before", "after", "in the 90% interval", "after"
    yield f"| {' | '.join(headers)} |"
    yield f"|{'---|' * len(headers)}"
    for number, one in enumerate(found, start=1):
        verdict = one.effect if unnamed or not one.place else f"{one.effect}: {as_markdown(one.place)}"
        name = f"{number}" if unnamed else as_markdown(one.rocket)
        yield _row(name, one.flights, verdict, one.before, one.after, one.inside)
    before, after = (np.concatenate([getattr(one, name) for one in found]) for name in ("before", "after"))
    inside = np.hstack([one.inside for one in found])
    yield _row("**all**", sum(one.flights for one in found), "", before, after, inside)
    yield ""
    yield from _totals(found, before, after)


def _row(name: str, flights: int, verdict: str, before: Array, after: Array, inside: Array) -> str:
    if not len(before):
        return f"| {name} | {flights} | {verdict} | 0 | | | | |"
    shares = (np.abs(before).mean(), np.abs(after).mean(), inside[0].mean(), inside[1].mean())
    return (
        f"| {name} | {flights} | {verdict} | {len(before)} | {' | '.join(f'{fraction:.0%}' for fraction in shares)} |"
    )


def _totals(found: Sequence[RocketHistory], before: Array, after: Array) -> Iterator[str]:
    if not len(before):
        return
    old, new = np.abs(before), np.abs(after)
    yield fill(
        f"Over {len(old)} later flights the mean error is {old.mean():.1%} before and {new.mean():.1%} after, the "
        f"median error {np.median(old):.1%} and {np.median(new):.1%}. {_changed(found, old, new)}",
        118,
    )


def _changed(found: Sequence[RocketHistory], old: Array, new: Array) -> str:
    named = np.array([name not in ("none", "unexplained") for one in found for name in one.verdicts])
    if not named.any():
        return "For none of them had the loop named an effect; what changes is the average over improbable ones."
    rise = (new - old)[named]
    low, high = 100 * np.quantile(rise[resampled(len(rise))].mean(axis=1), LEVELS)
    return (
        f"For {named.sum()} of them the loop had found an effect in the earlier flights: their mean error is "
        f"{old[named].mean():.1%} before and {new[named].mean():.1%} after, a change of {100 * rise.mean():+.1f} "
        f"percentage points (90% bootstrap interval {low:+.1f} to {high:+.1f})."
    )
