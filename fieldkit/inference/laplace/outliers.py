"""Warnings of outliers: readouts with a low weight in a fit because they are far from their expectation.

Nothing is removed from a fit: each residual follows a Student t and has the corresponding weight
(`fieldkit.inference.laplace.fit.fit_robustly`). A flyer is warned of readouts that are nearly always typing errors.

Derivation: the tail of a Student t; see `smallest_usual_weight`.
"""

from shlex import quote
from typing import Any

import numpy as np

from fieldkit.flight import BY_NAME, CHECKED_TAG, Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.messages import message, of_column
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.shapes import Array, Float, Int

FALSE_ALARMS = 0.01
"""Fraction of good flights with a false warning. [1]"""

MAX_OUTLIER_WEIGHT = 0.25
"""Upper bound of the weight of any outlier; for a single readout with 4 degrees of freedom the bound is 0.20. [1]"""


def outlier_lines(result: Fit) -> tuple[str, ...]:
    """One line for each outlier of a flight that is not tagged `checked`, in the order flown."""
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
    """The threshold below which the weight of any of this number of good readouts falls with probability
    `FALSE_ALARMS`. [1]

    A residual of t standard deviations has the weight (nu + 1) / (nu + t^2), with the degrees of freedom nu of its
    Student t, `tail`. The readouts of a flight are treated as independent (Bonferroni).
    """
    from scipy.special import stdtrit  # takes 0.1 s to import, and most forecasts do not need it

    bound = stdtrit(tail, 1 - FALSE_ALARMS / (2 * np.maximum(readouts, 1)))
    return np.asarray((tail + 1) / (tail + bound**2))


def _line(flight: Flight, readout: str, weight: float) -> str:
    column, name = BY_NAME[readout], flight.flight_id
    value = flight.number(readout)
    found = "" if value is None else f" of {of_column(column, value)}"
    return message(
        f"{flight_label(name)}: {column.title.lower()}{found} is far from what the model expects and has "
        f"{100 * weight:.0f}% of the usual weight; if it is right, `fieldkit tag {quote(name)} {CHECKED_TAG}`"
    )
