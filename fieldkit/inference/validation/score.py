"""Evaluation of an ensemble on held-out simulated flights."""

from typing import TYPE_CHECKING, Any

import numpy as np

from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

LEVELS = {"one_sd": 1.0, "50": 0.67449, "90": 1.64485}
"""Intervals by name: half widths in standard deviations, as for a normal distribution."""


def score(
    ensemble: "Ensemble", features: Float[Array, "flight feature"], truth: Float[Array, "flight output"]
) -> dict[str, Any]:
    """Errors of the mean and coverage of the spread, for each output by name, in its unit."""
    mean, spread = ensemble(features)
    error = mean - truth
    return {
        name: {
            "mae": float(np.abs(error[:, column]).mean()),
            "standard_error": float(np.abs(error[:, column]).std() / np.sqrt(len(error))),
            "rmse": float(np.sqrt((error[:, column] ** 2).mean())),
            "bias": float(error[:, column].mean()),
            "coverage": {
                level: float((np.abs(error[:, column]) <= reach * spread[:, column]).mean())
                for level, reach in LEVELS.items()
            },
        }
        for column, name in enumerate(ensemble.outputs)
    }
