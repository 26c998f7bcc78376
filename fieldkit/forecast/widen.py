"""Intervals after a residual that nothing accounts for: as much wider as flights left out show that they must be."""

from collections.abc import Sequence

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.predict import declared_places, forecast_model
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.leave_one_out import leave_one_out
from fieldkit.model.readout_data import Data, observe
from fieldkit.motors import Found
from fieldkit.scoring.score import forecasts_of
from fieldkit.selection.candidates import Place
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.unexplained import Leftover, leftover

MAX_LEFT_OUT_SDS = 4.0
"""Standard deviations beyond which a left-out flight counts no more: it may be an accident. [1]"""


def widening(flights: Sequence[Flight], found: Sequence[Found], data: Data, pattern: Sequence[Place] = ()) -> float:
    """How much further flights left out lie from their forecasts than these claim, at least 1. [1]

    The forecasts are those of the model that predicts, with `pattern` alone accepted; the distances are of its mixture,
    as standard deviations of a normal with the same probability, and their root mean square is what comes back.
    """
    from scipy.special import ndtri

    model = forecast_model(flights, found, (*pattern, *declared_places(flights, pattern)))
    result = fit_robustly(model, observe(flights, [bool(row.any()) for row in data.seen], model.hyperprior))
    below = forecasts_of(leave_one_out(result)).below(data.values[:, 0])[data.seen[:, 0]]
    distance = np.clip(ndtri(np.clip(below, 1e-9, 1 - 1e-9)), -MAX_LEFT_OUT_SDS, MAX_LEFT_OUT_SDS)
    return max(1.0, float(np.sqrt((distance**2).mean()))) if len(distance) else 1.0


def widened_leftover(diagnosis: Diagnosis) -> Leftover:
    """What a diagnosis leaves unexplained, and how much wider forecasts are for it."""
    model = diagnosis.model
    return leftover(diagnosis, widening(model.flights, model.found, diagnosis.data, diagnosis.pattern))
