"""Simulated flights with known drag and thrust, for training and evaluating ensembles."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.model.features import paper_features
from fieldkit.physics import paper
from fieldkit.physics.flight import apogees
from fieldkit.shapes import Array, Float, Int

CD_RANGE = (0.3, 0.9)
"""The paper's prior of Cd, uniform. [1]"""
ALPHA_RANGE = (0.8, 1.2)
"""The paper's prior of the thrust scale, uniform. [1]"""
APOGEE_NOISE = 3.0
"""Standard deviation of an altimeter's apogee in the paper. [m]"""


@dataclass(frozen=True, slots=True)
class PaperDraws:
    """Flights of the paper's rocket drawn from the paper's priors: dry mass [kg], apogee as the altimeter reads it
    [m]."""

    motor: Int[Any, "flight"]
    dry_mass: Float[Array, "flight"]
    apogee: Float[Array, "flight"]
    truth: Float[Array, "flight 2"]
    """Cd and alpha."""

    @property
    def features(self) -> Float[Array, "flight feature"]:
        """Features of the paper's ensemble, in SI."""
        return paper_features(self.apogee, self.motor, self.dry_mass)


def paper_draws(rng: np.random.Generator, count: int) -> PaperDraws:
    """Flights with random Cd, alpha, motor and configuration, and the altimeter's noise on the apogee."""
    motor = rng.integers(len(paper.MOTORS), size=count)
    dry_mass = rng.choice(np.array(list(paper.DRY_MASS.values())), size=count)
    cd, alpha = rng.uniform(*CD_RANGE, size=count), rng.uniform(*ALPHA_RANGE, size=count)
    height = apogees(paper.paper_setup(motor, dry_mass, cd, alpha))
    return PaperDraws(
        motor, dry_mass, height + rng.normal(0.0, APOGEE_NOISE, size=count), np.stack([cd, alpha], axis=-1)
    )
