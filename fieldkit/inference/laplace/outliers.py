"""Outliers by name: the readouts of a fit that hardly count, because they lie far from what the model expects.

Nothing is removed from a fit: each residual follows a Student t, and counts with the weight that it leaves it
(`fieldkit.inference.laplace.fit.fit_robustly`). A flyer is warned of those that are nearly always a typing error.
"""

from typing import Any

import numpy as np

from fieldkit.flight import BY_NAME, CHECKED_TAG, Flight
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.shapes import Array, Float, Int

FALSE_ALARMS = 0.01
"""Fraction of good flights with an outlier that is reported. [1]"""

MAX_OUTLIER_WEIGHT = 0.25
"""Weight that every outlier is below: of a lone readout with 4 degrees of freedom the bound is 0.20. [1]"""


def outlier_lines(result: Fit) -> tuple[str, ...]:
    """A line for each outlier of a flight that is not tagged `checked`, in the order flown."""
    data = result.data
    if not (data.seen & (data.trust < MAX_OUTLIER_WEIGHT)).any():
        return ()
    usual = smallest_usual_weight(data.seen.sum(axis=1), result.model.hyperprior.tail)
    return tuple(
        _line(result.model.flights[row], OBSERVED_READOUTS[column], float(data.trust[row, column]))
        for row, column in np.argwhere(data.seen & (data.trust < usual[:, None])).tolist()
        if CHECKED_TAG not in result.model.flights[row].tags
    )


def smallest_usual_weight(readouts: Int[Any, "flight"], tail: float) -> Float[Array, "flight"]:
    """The weight below which one of so many good readouts of a flight falls with probability `FALSE_ALARMS`. [1]

    A residual of t standard deviations has the weight (nu + 1) / (nu + t^2), nu being the degrees of freedom of the
    Student t it follows, `tail`; the readouts of a flight count as independent (Bonferroni).
    """
    from scipy.special import stdtrit  # a tenth of a second, which most forecasts need not pay

    bound = stdtrit(tail, 1 - FALSE_ALARMS / (2 * np.maximum(readouts, 1)))
    return np.asarray((tail + 1) / (tail + bound**2))


def _line(flight: Flight, readout: str, weight: float) -> str:
    column, name = BY_NAME[readout], flight.flight_id
    value = flight.number(readout)
    found = "" if value is None else f" of {float(column.render(value)):.4g} {column.unit}"
    return (
        f"flight {name}: {column.title.lower()}{found} is far from what the model expects and counts for "
        f"{100 * weight:.0f} % of a usual one; if it is right, `fieldkit tag {name} {CHECKED_TAG}`"
    )
