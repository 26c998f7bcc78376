"""Scores of the model's and its rivals' forecasts on the same flights, including cases in which the model is no better.

All scores are relative to the flown apogee, so a flight to 50 m counts as much as one to 500 m.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fieldkit.forecast.evaluation.forward_in_time import Forecast
from fieldkit.forecast.evaluation.rivals import BAR, LABELS
from fieldkit.forecast.prediction import LEVELS, quantiles
from fieldkit.scoring.bootstrap import ScoreDifference, paired
from fieldkit.scoring.proper_scores import Calibration, calibration, crps, interval_score, pit
from fieldkit.shapes import Array, Flags, Float

OWN_FORECAST = "fieldkit"


@dataclass(frozen=True, slots=True)
class Scores:
    """The scores of one method for each flight: predicted minus flown, CRPS and score of the 90% interval, each
    divided by the flown apogee [1], and whether the flight was in the interval."""

    bias: Float[Array, "flight"]
    crps: Float[Array, "flight"]
    interval: Float[Array, "flight"]
    inside: Flags

    @property
    def error(self) -> Float[Array, "flight"]:
        """Absolute error of the median. [1]"""
        return np.abs(self.bias)


@dataclass(frozen=True, slots=True)
class Tally:
    """The scores of one method as fractions of the flown apogee; `mae` and `bias` in meters."""

    name: str
    flights: int
    median_share: float
    mean_share: float
    mae: float
    bias: float
    median_bias: float
    crps: float
    interval_score: float
    coverage90: float


@dataclass(frozen=True, slots=True)
class Against:
    """Fieldkit and one rival on the flights that both forecast. [1]

    A rival without a spread has its absolute error as CRPS, and an interval of no width.
    """

    rival: str
    error: ScoreDifference
    crps: ScoreDifference
    interval_score: ScoreDifference

    @property
    def flights(self) -> int:
        """Flights that both forecast."""
        return self.error.flights

    @property
    def verdict(self) -> str:
        """`better`, `worse`, or `unclear` by the mean absolute error."""
        return self.error.verdict

    def json(self) -> dict[str, Any]:
        """Every figure, and the verdicts."""
        return {
            "rival": self.rival,
            "name": LABELS[self.rival],
            "flights": self.flights,
            "error": self.error.ours,
            "theirs": self.error.theirs,
            "less": self.error.less,
            "interval": list(self.error.interval),
            "verdict": self.verdict,
            "crps": self.crps.json(),
            "interval_score": self.interval_score.json(),
        }


@dataclass(frozen=True, slots=True)
class ScoreReport:
    """The evaluation of a set of forecasts: every method alone, against each rival, by rocket against the bar, and
    calibration. `crps` is in meters."""

    rows: tuple[Forecast, ...]
    ways: tuple[Tally, ...]
    against: tuple[Against, ...]
    behind: tuple[tuple[str, Against], ...]
    calibration: Calibration
    crps: float

    @property
    def coverage90(self) -> float:
        """Fraction of flights in the model's 90% interval. [1]"""
        return self.ways[0].coverage90 if self.ways else float("nan")

    def json(self) -> dict[str, Any]:
        """The comparison and the calibration as a document."""
        return {
            "rivals": [one.json() for one in self.against],
            "behind_scalar_correction": [{"rocket": rocket, **one.json()} for rocket, one in self.behind],
            "calibration": {
                "pit_counts": list(self.calibration.counts),
                "pit_expected": list(self.calibration.expected),
                "intervals": [asdict(one) for one in self.calibration.intervals],
            },
            "crps_m": self.crps,
        }


def judged_report(rows: Sequence[Forecast]) -> ScoreReport:
    """The full evaluation of forecasts of flown flights."""
    rockets = dict.fromkeys(row.rocket for row in rows)
    own = {rocket: against([row for row in rows if row.rocket == rocket], BAR) for rocket in rockets}
    inside = scores_of_flights(rows, OWN_FORECAST).inside.tolist()
    return ScoreReport(
        tuple(rows),
        tuple(one for name in (OWN_FORECAST, *LABELS) if (one := tally(rows, name)).flights),
        tuple(pair for name in LABELS if (pair := against(rows, name)).flights),
        tuple((rocket, one) for rocket, one in own.items() if one.flights and not one.error.less > 0),
        calibration([pit(row.draws, row.flown) for row in rows], inside={0.9: inside}),
        float(np.mean([crps(row.draws, row.flown) for row in rows])) if rows else float("nan"),
    )


def scores_of_flights(rows: Sequence[Forecast], way: str) -> Scores:
    """Scores of the model (`OWN_FORECAST`) or a rival on the flights with its forecast."""
    flown = np.array([row.flown for row in rows])
    drawn = [row.draws if way == OWN_FORECAST else row.rivals[way] for row in rows]
    ends = [
        row.interval if way == OWN_FORECAST else quantiles(draws, LEVELS)
        for draws, row in zip(drawn, rows, strict=True)
    ]
    low, middle, high = (np.array(ends, float).reshape(-1, 3) / flown[:, None]).T
    return Scores(
        middle - 1,
        np.array([crps(draws / row.flown, 1.0) for draws, row in zip(drawn, rows, strict=True)]),
        np.array([interval_score(*both, 1.0) for both in zip(low, high, strict=True)]),
        (low <= 1) & (high >= 1),
    )


def forecast_by(rows: Sequence[Forecast], way: str) -> list[Forecast]:
    """The flights with a forecast of the model or a rival."""
    return [row for row in rows if way == OWN_FORECAST or way in row.rivals]


def tally(rows: Sequence[Forecast], way: str) -> Tally:
    """The scores of the model or a rival, summarized over the flights with its forecast."""
    both = forecast_by(rows, way)
    name = LABELS.get(way, way)
    if not both:
        return Tally(name, 0, *[float("nan")] * 8)
    found, flown = scores_of_flights(both, way), np.array([row.flown for row in both])
    return Tally(
        name,
        len(both),
        float(np.median(found.error)),
        float(found.error.mean()),
        float((found.error * flown).mean()),
        float((found.bias * flown).mean()),
        float(np.median(found.bias)),
        float(found.crps.mean()),
        float(found.interval.mean()),
        float(found.inside.mean()),
    )


def against(rows: Sequence[Forecast], rival: str) -> Against:
    """Fieldkit and a rival on the flights that both forecast."""
    both = forecast_by(rows, rival)
    ours, theirs = scores_of_flights(both, OWN_FORECAST), scores_of_flights(both, rival)
    return Against(
        rival,
        paired(ours.error, theirs.error),
        paired(ours.crps, theirs.crps),
        paired(ours.interval, theirs.interval),
    )
