"""The features of a flight for an ensemble: one function each, used in training and in the field."""

from typing import Any

import numpy as np

from fieldkit.physics import paper
from fieldkit.shapes import Array, Float, Int

PAPER_FEATURES = ("apogee_m", "motor_index", "dry_mass_kg", "total_impulse_ns", "burn_time_s")
"""The five features of the reference paper, in order."""


def paper_features(
    apogee: Float[Array, "flight"], motor: Int[Any, "flight"], dry_mass: Float[Array, "flight"]
) -> Float[Array, "flight feature"]:
    """The paper's features from apogee [m], the paper's index of the motor, and dry mass [kg].

    Total impulse [N s] and burn time [s] are the values the paper gives for the motor.
    """
    impulse = np.array([declared.total_impulse for declared in paper.MOTORS])
    burn_time = np.array([declared.burn_time for declared in paper.MOTORS])
    return np.stack([apogee, np.asarray(motor, float), dry_mass, impulse[motor], burn_time[motor]], axis=-1)
