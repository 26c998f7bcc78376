"""An ensemble of the field's kind trained on the restricted problem, whose exact answer is known."""

from typing import Any

import numpy as np

from fieldkit.inference.network.ensemble import Ensemble
from fieldkit.inference.network.mixture import logits, mixture
from fieldkit.inference.training.density import Batch, TrainingPlan, fit, member_outputs
from fieldkit.inference.training.fit import TrainingProgress, one_thread
from fieldkit.inference.validation.field import evaluate
from fieldkit.model.field_features import features, shown
from fieldkit.model.observations import READOUT_NAMES
from fieldkit.shapes import Array, Float
from studies.validation.restricted import (
    BURN_SD,
    SUBSETS,
    Restricted,
    against_exact,
    exact,
    intervals,
    measured,
    restricted_draws,
)

PLAN = TrainingPlan(epochs=20)
CELLS_UNCERTAIN = 150
"""Points along each axis of the grid if the burn time is integrated over."""


def train_restricted(
    *,
    seed: int = 1,
    n_train: int = 200_000,
    plan: TrainingPlan = PLAN,
    judged: int = 500,
    burn_sd: float = 0.0,
    progress: TrainingProgress | None = None,
) -> dict[str, Any]:
    """Train on the restricted problem, and return the distance of the ensemble from the exact posterior.

    `judged` is the number of new flights on which they are compared, and `burn_sd` the standard deviation of the log
    burn time. [1]
    """
    rng = np.random.default_rng(seed)
    flights, clean = restricted_draws(rng, n_train, burn_sd)
    with one_thread(seed):
        members, mean, sd = fit(lambda: _batch(rng, flights, clean), plan, progress)
    fresh, _ = restricted_draws(rng, judged, burn_sd)
    densities = {
        name: mixture(member_outputs(members, mean, sd, features(fresh.observed.only(*kept))), *intervals(judged))
        for name, kept in SUBSETS.items()
    }
    grid = exact(CELLS_UNCERTAIN, burn_sd) if burn_sd else exact()
    return against_exact(fresh, densities, grid, judged)


def evaluate_with_exact(ensemble: Ensemble, rng: np.random.Generator) -> dict[str, Any]:
    """The figures of a field ensemble's card, and the distance of its kind from exact posteriors."""
    seed = ensemble.card["seed"]
    return evaluate(ensemble, rng) | {
        "restricted": train_restricted(seed=seed),
        "restricted_burn_uncertain": train_restricted(seed=seed, burn_sd=BURN_SD),
    }


def _batch(rng: np.random.Generator, flights: Restricted, clean: Float[Array, "flight readout"]) -> Batch:
    """A new measurement of the flights, each with one of the subsets of readouts."""
    whole = measured(rng, clean, flights.motor, flights.config)
    kept = np.array([[name in names for name in READOUT_NAMES] for names in SUBSETS.values()])
    which = rng.integers(len(kept), size=len(clean))
    observed = whole.with_readouts(np.where(kept[which], whole.readouts, np.nan))
    arrays = features(observed), logits(flights.truth, *intervals(len(clean))), shown(whole)
    return Batch(*(np.asarray(array, np.float32) for array in arrays))
