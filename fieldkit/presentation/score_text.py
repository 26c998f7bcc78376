"""The quality of forecasts, in lines: scores compared with rivals, whether the bar is beaten, calibration."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from fieldkit.forecast.evaluation.rivals import LABELS, MIXTURE
from fieldkit.quantities import ShownUnits, counted
from fieldkit.scoring.bootstrap import MIN_FLIGHTS_FOR_VERDICT

if TYPE_CHECKING:
    from fieldkit.forecast.evaluation.comparison import Against, ScoreReport
    from fieldkit.scoring.bootstrap import ScoreDifference
    from fieldkit.scoring.proper_scores import Calibration
    from fieldkit.services.scores import LedgerScores

MAX_BAR_LENGTH, BRIEF_BAR_LENGTH = 30, 14
"""Longest bars; those beside names leave room for them on a line of 80. [character]"""
HEADERS = ("method", "n", "median", "mean", "bias", "CRPS", "interval", "in 90%")
DIFFERENCE_HEADERS = ("fieldkit is better by", "mean error", "CRPS", "interval")
LEGEND = (
    "In percent of the flown apogee. n: flights; median, mean: absolute errors; bias: median error, + if forecasts are "
    "too high; CRPS, interval: scores of the whole forecast and of its 90% interval, lower is better; in 90%: flights "
    "in that interval."
)
"""The columns of `HEADERS`."""
DIFFERENCE_LEGEND = "90% bootstrap intervals; +: fieldkit's score is lower, *: clearly different"


WAYS: Mapping[str, str] = {
    "uncalibrated": "a simulation as it is",
    "scalar": "a simulation scaled to its flights",
    "last_on_motor": "its last apogee on the motor",
    "flight_before": "the apogee of the flight before",
    "fleet_ratio": "a simulation scaled to all flights",
}
"""The rivals that a flyer can compute, in plain words; of those with one idea the simpler one."""
OWN_FORECASTS = "these forecasts"


def in_brief(found: "ScoreReport", system: str) -> Iterator[str]:
    """The mean miss of forecasts and of simpler methods as bars, the nearest first, and whether they differ clearly."""
    named = {LABELS[way]: text for way, text in WAYS.items()}
    rows = [(found.ways[0], OWN_FORECASTS), *((way, named[way.name]) for way in found.ways if way.name in named)]
    rows = sorted((row for row in rows if row[0].flights == len(found.rows)), key=lambda row: row[0].mae)
    most, width = max(way.mae for way, _ in rows) or 1.0, max(len(text) for _, text in rows)
    yield "Mean miss, beside those of simpler methods"
    for way, text in rows:
        bar = "█" * max(1, round(way.mae / most * BRIEF_BAR_LENGTH))
        yield f"  {text:{width}}  {ShownUnits(system).length(way.mae):>7}  {bar}"
    if few := too_few(found):
        yield few
        return
    for verdict, words in (("better", "Clearly nearer than"), ("worse", "Clearly farther off than")):
        rivals = [WAYS[one.rival] for one in found.against if one.verdict == verdict and one.rival in WAYS]
        if rivals:
            yield f"{words} {', '.join(rivals)}"


def intervals_in_brief(found: "ScoreReport") -> str:
    """How many flights were in their 90% interval, and what that says: `6 of 7 inside the 90% interval: too wide`."""
    (one,) = (one for one in found.calibration.intervals if one.level == 0.9)
    flights = len(found.rows)
    verdict = "as expected" if one.honest else "too narrow" if one.held < one.level else "too wide"
    return f"{round(one.held * flights)} of {flights} inside the 90% interval: {verdict}"


def titles(found: "LedgerScores") -> Iterator[tuple["ScoreReport", str]]:
    """The reports with at least one flight, each with its title."""
    if found.saved is not None:
        yield found.saved, f"Saved forecasts, made before the flight: {len(found.saved.rows)} flown and normal"
    if found.later.rows:
        yield (
            found.later,
            f"Replayed forward in time: {counted(len(found.later.rows), 'flight')}, each forecast from the "
            "earlier flights of its rocket and of all others",
        )
    if found.first.rows:
        yield (
            found.first,
            f"First flights of a rocket: {len(found.first.rows)}, each forecast from earlier flights of other rockets",
        )


def next_lines(found: "LedgerScores") -> Iterator[str]:
    """The coverage of corrected intervals, and what the next forecast is mixed from."""
    if found.corrected:
        yield (
            f"Calibrated on earlier forecasts, the intervals of the last {found.corrected['flights']} would have "
            f"covered {found.corrected['coverage90']:.0%}, uncalibrated {found.corrected['own_coverage90']:.0%}."
        )
    for what, weights in (("Forecasts", found.weights), ("First flights", found.weights_of_first)):
        if weights["fieldkit"] < 1:
            parts = ", ".join(f"{weight:.0%} {LABELS.get(way, way)}" for way, weight in weights.items() if weight)
            yield f"{what} are mixed, because a simpler method scored better on earlier ones: {parts}."


def way_rows(found: "ScoreReport") -> list[tuple[str, ...]]:
    """A row of `HEADERS` for the model and each rival, in percent of the flown apogee: median and mean absolute error,
    median bias, CRPS, score of the 90% interval, and flights inside it."""
    return [
        (
            way.name,
            str(way.flights),
            f"{way.median_share:.1%}",
            f"{way.mean_share:.1%}",
            f"{way.median_bias:+.1%}",
            f"{way.crps:.1%}",
            f"{way.interval_score:.0%}",
            f"{way.coverage90:.0%}",
        )
        for way in found.ways
        if way.name != LABELS[MIXTURE] or not _mixes_nothing(found)
    ]


def difference_rows(found: "ScoreReport") -> list[tuple[str, ...]]:
    """A row of `DIFFERENCE_HEADERS` for each rival: the reduction of a mean score by the model and its 90% bootstrap
    interval, in percent of the flown apogee, with a star if the difference is clear."""
    return [
        (LABELS[one.rival], _between(one.error), _between(one.crps), _between(one.interval_score, 0))
        for one in compared(found)
    ]


def too_few(found: "ScoreReport") -> str:
    """That no rival can be compared because there are too few flights; empty if one can."""
    if any(one.flights >= MIN_FLIGHTS_FOR_VERDICT for one in found.against):
        return ""
    return f"Too few flights to compare the methods: at least {MIN_FLIGHTS_FOR_VERDICT} are needed."


def compared(found: "ScoreReport") -> list["Against"]:
    """The rivals to show: all, but the mixture with them only if it differs from the model's own forecasts."""
    return [one for one in found.against if one.rival != MIXTURE or not _mixes_nothing(found)]


def _mixes_nothing(found: "ScoreReport") -> bool:
    """Whether the mixture gave every flight the model's own forecast."""
    return all(one.crps.interval == (0.0, 0.0) for one in found.against if one.rival == MIXTURE)


def verdict_lines(found: "ScoreReport") -> Iterator[str]:
    """The rivals with a clearly larger mean absolute error, those with a clearly smaller one, and the others."""
    for verdict, words in (
        ("better", "Better than"),
        ("worse", "WORSE than"),
        ("unclear", "Not clearly different from"),
    ):
        named = [LABELS[one.rival] for one in compared(found) if one.verdict == verdict]
        if named:
            yield f"{words}: {'; '.join(named)}."


def _between(one: "ScoreDifference", digits: int = 1) -> str:
    low, high = one.interval
    mark = "" if one.verdict == "unclear" else "*"
    return f"{100 * low:+.{digits}f} to {100 * high:+.{digits}f}{mark or ' '}"


def behind_the_bar(found: "ScoreReport") -> Iterator[str]:
    """The rockets on which the scalar correction is not beaten, with both mean errors."""
    for rocket, one in found.behind:
        chance = ", which may be chance" if one.verdict != "worse" else ""
        yield f"Not better than the scalar correction on {rocket or 'no rocket'}: {_errors(one)}{chance}."


def _errors(one: "Against") -> str:
    return f"{one.error.ours:.1%} against {one.error.theirs:.1%} on {counted(one.flights, 'flight')}"


def histogram(found: "Calibration") -> Iterator[str]:
    """PITs as bars that should have equal lengths, and the fraction of flights in each interval."""
    low, high = found.expected
    count = sum(found.counts)
    yield (
        "Flights by place in their forecast, from 0% (lower than all its simulations) to 100%: a tenth in each row, "
        f"{low:.0f} to {high:.0f} by chance"
    )
    longest = max(*found.counts, 1)
    for place, number in enumerate(found.counts):
        bar = "█" * round(MAX_BAR_LENGTH * number / longest)
        note = "" if low <= number <= high else "  too few" if number < low else "  too many"
        yield f"  {place * 10:3d}-{place * 10 + 10:3d}%  {bar} {number}{note}"
    for one in found.intervals:
        least, most = one.expected
        verdict = "as expected" if one.honest else "too narrow" if one.held < one.level else "too wide"
        yield (
            f"  {one.level:.0%} interval: contains {one.held:.0%} of {counted(count, 'flight')}, {least:.0%} to "
            f"{most:.0%} by chance: {verdict}"
        )
