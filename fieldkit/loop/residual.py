"""What the plain model gets wrong, and what the errors go together with."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.flight import CONDITIONS
from fieldkit.loop.diagnose import Diagnosis
from fieldkit.loop.model import OBSERVED, groups
from fieldkit.loop.score import forecasts_of
from fieldkit.loop.trial import Trial
from fieldkit.shapes import Array, Float
from fieldkit.simulator.field import recorded


@dataclass(frozen=True, slots=True)
class Pattern:
    """How strongly residuals go together with a column of the flights.

    `statistic` is Spearman's rank correlation for numbers and Kruskal and Wallis' H for groups; `p` is
    corrected for the number of columns looked at (Benjamini and Hochberg, 1995).
    """

    against: str
    statistic: float
    p: float

    def json(self) -> dict[str, Any]:
        """The keys of the contract."""
        return {"against": self.against, "statistic": self.statistic, "p": self.p}


@dataclass(frozen=True, slots=True)
class Spread:
    """How one readout's residuals are distributed, in units of their expected scatter.

    `bias` and `spread` are mean and standard deviation (0 and 1 where the model is right), `autocorrelation`
    is between one flight and the next; nan where fewer than three flights have the readout.
    """

    readout: str
    flights: int
    bias: float
    spread: float
    autocorrelation: float


def readout_residuals(diagnosis: Diagnosis) -> Float[Array, "flight readout"]:
    """Every readout of every flight less its forecast from the other flights, in expected standard deviations.

    nan where it was not recorded or does not teach.
    """
    left_out = diagnosis.base.left_out
    weight = forecasts_of(left_out).weight
    residual = np.einsum("sf,sfo->fo", weight, left_out.residual)
    return np.where(diagnosis.data.seen, residual, np.nan)


def residuals(diagnosis: Diagnosis) -> Float[Array, "flight"]:
    """The apogee's residuals alone."""
    return readout_residuals(diagnosis)[:, 0]


def spreads(diagnosis: Diagnosis) -> list[Spread]:
    """Bias, spread and autocorrelation in time of every readout that was recorded."""
    rows = []
    for name, column in zip(OBSERVED, readout_residuals(diagnosis).T, strict=True):
        error = column[np.isfinite(column)]
        if not len(error):
            continue
        varied = len(error) > 2 and error.std() > 0
        follow = float(np.corrcoef(error[:-1], error[1:])[0, 1]) if varied and len(error) > 3 else float("nan")
        rows.append(
            Spread(name, len(error), float(error.mean()), float(error.std()) if varied else float("nan"), follow)
        )
    return rows


def fingerprint(trial: Trial) -> dict[str, float]:
    """What an effect at its fitted strength does to each readout, averaged over the flights it acts on.

    By ratio (0.05 is 5 % more) for all but apogee to ejection, which is in seconds.
    """
    fit = trial.fit
    mean, _ = fit.moments()
    last = len(fit.model.terms) - 1
    acts = fit.model.terms[last].weight != 0
    shift = fit.tangent.slope[acts][..., last].mean(axis=0) * mean[last]
    return {name: float(value) for name, value in zip(OBSERVED, shift, strict=True)}


def patterns(diagnosis: Diagnosis) -> list[Pattern]:
    """Every column against the residuals, the most telling first."""
    from scipy.stats import false_discovery_control, kruskal, spearmanr

    model, error = diagnosis.model, residuals(diagnosis)
    seen = np.isfinite(error)
    found: list[tuple[str, float, float]] = []
    for name, values in _numbers(diagnosis).items():
        both = seen & np.isfinite(values)
        if both.sum() >= 5 and len(np.unique(values[both])) > 2:
            test = spearmanr(values[both], error[both])
            found.append((name, float(test.statistic), float(test.pvalue)))
    for name in ("motor", "config", "site"):
        kinds = np.array(groups(model.flights, model.found, name))[seen]
        parts = [error[seen][kinds == kind] for kind in np.unique(kinds)]
        if len(parts) > 1 and min(len(part) for part in parts) >= 2:
            grouped = kruskal(*parts)
            found.append((name, float(grouped.statistic), float(grouped.pvalue)))
    if not found:
        return []
    corrected = false_discovery_control([p for *_, p in found])
    rows = [Pattern(name, statistic, float(p)) for (name, statistic, _), p in zip(found, corrected, strict=True)]
    return sorted(rows, key=lambda row: row.p)


def _numbers(diagnosis: Diagnosis) -> dict[str, Array]:
    flights = diagnosis.model.flights
    hours = [f.date_time.hour + f.date_time.minute / 60 if f.date_time else np.nan for f in flights]
    numbers = {column.header: recorded(flights, column.name) for column in CONDITIONS}
    speed = np.exp(diagnosis.base.fit.tangent.values[:, 1])
    return numbers | {
        "flight_number": np.arange(len(flights), dtype=float),
        "hour": np.array(hours, float),
        "expected_top_speed_mps": speed,
    }
