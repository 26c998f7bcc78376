"""What the plain model gets wrong, and what the errors go together with."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.flight import CONDITIONS
from fieldkit.loop.diagnose import Diagnosis
from fieldkit.loop.model import groups
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


def residuals(diagnosis: Diagnosis) -> Float[Array, "flight"]:
    """Flown less forecast log apogee of every flight left out, in forecast standard deviations; nan if not seen."""
    forecast = diagnosis.forecasts_before
    mean = (forecast.weight * forecast.mean).sum(axis=0)
    variance = (forecast.weight * (forecast.sd**2 + (forecast.mean - mean) ** 2)).sum(axis=0)
    error = (diagnosis.data.values[:, 0] - mean) / np.sqrt(variance)
    return np.where(diagnosis.data.seen[:, 0], error, np.nan)


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
