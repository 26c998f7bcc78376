"""How forecasts compare with simpler ways on the same flights, and where they are no better.

The bar is the scalar correction: anyone can multiply a simulation by what the flights so far made of it.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fieldkit.forecast.evaluation.forward_in_time import Forecast
from fieldkit.scoring.bootstrap import Interval, ends_of, resampled
from fieldkit.scoring.proper_scores import Calibration, calibration, crps, pit
from fieldkit.shapes import Array, Float

RIVALS = {
    "certified": "uncalibrated",
    "persistence": "flight before",
    "scaled": "scalar correction",
}
"""Fields of `Forecast` and what they are called."""
BAR = "scaled"
FEWEST = 5
"""Flights from which on an interval over flights is told. [1]"""


@dataclass(frozen=True, slots=True)
class Against:
    """Fieldkit and one rival on the same flights.

    Errors are the mean of |forecast less flown| over flown [1]; `less` is by how much ours is smaller, with its 90 %
    bootstrap interval over the flights, and so is `crps_less` [m], of the flights where the rival has a spread; one
    without is scored by its absolute error.
    """

    rival: str
    flights: int
    error: float
    theirs: float
    less: float
    interval: Interval
    crps_less: float
    crps_interval: Interval

    @property
    def verdict(self) -> str:
        """`better`, `worse`, or `unclear` by these flights."""
        low, high = self.interval
        if self.flights < FEWEST or not low * high > 0:
            return "unclear"
        return "better" if low > 0 else "worse"

    def json(self) -> dict[str, Any]:
        """Every figure, and the verdict."""
        return {**asdict(self), "name": RIVALS[self.rival], "verdict": self.verdict}


@dataclass(frozen=True, slots=True)
class Report:
    """How good a set of forecasts was: against each rival, by rocket against the bar, and calibrated or not."""

    rows: tuple[Forecast, ...]
    against: tuple[Against, ...]
    behind: tuple[tuple[str, Against], ...]
    calibration: Calibration
    crps: float

    def json(self) -> dict[str, Any]:
        """The same as a document."""
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


def judged_report(rows: Sequence[Forecast]) -> Report:
    """Everything that is said of forecasts that were flown."""
    rockets = dict.fromkeys(row.rocket for row in rows)
    own = {rocket: against([row for row in rows if row.rocket == rocket], BAR) for rocket in rockets}
    drawn = [(row.draws, row.flown) for row in rows if row.draws is not None]
    return Report(
        tuple(rows),
        tuple(one for name in RIVALS if (one := against(rows, name)).flights),
        tuple((rocket, one) for rocket, one in own.items() if one.flights and not one.less > 0),
        calibration([pit(draws, flown) for draws, flown in drawn]),
        float(np.mean([crps(draws, flown) for draws, flown in drawn])) if drawn else float("nan"),
    )


def against(rows: Sequence[Forecast], rival: str) -> Against:
    """Fieldkit and a rival on the flights of which both have a forecast."""
    both = [row for row in rows if np.isfinite(getattr(row, rival))]
    flown = np.array([row.flown for row in both])
    ours = np.abs(np.array([row.p50 for row in both]) - flown) / flown
    theirs = np.abs(np.array([getattr(row, rival) for row in both]) - flown) / flown
    proper = np.array([_crps_less(row, rival) for row in both if row.draws is not None])
    return Against(
        rival,
        len(both),
        float(ours.mean()) if both else float("nan"),
        float(theirs.mean()) if both else float("nan"),
        *_mean(theirs - ours),
        *_mean(proper),
    )


def _crps_less(row: Forecast, rival: str) -> float:
    assert row.draws is not None
    theirs = row.spreads.get(rival, np.array([getattr(row, rival)]))
    return crps(theirs, row.flown) - crps(row.draws, row.flown)


def _mean(values: Float[Array, "flight"]) -> tuple[float, Interval]:
    """A mean over flights and its bootstrap interval."""
    if not len(values):
        return float("nan"), (float("nan"), float("nan"))
    return float(values.mean()), ends_of(values[resampled(len(values))].mean(axis=1))
