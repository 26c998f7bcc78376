"""Draws of the exact posterior of a rocket's flights and of its next flight, and those of the fit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import FittedForecast, fly_ahead, learn
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import Model, base_model
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.simulated_readouts import bent
from fieldkit.motors import Found
from fieldkit.physics.history import flown_and_planned
from fieldkit.shapes import Array, Float
from studies.reference_posterior import hamiltonian
from studies.reference_posterior.readouts import Readouts
from studies.reference_posterior.target import Target, target

CHAINS = 128
WARM_UP = 150
TRANSITIONS = 300
"""Number of transitions of each chain during warm-up, and after it."""
MIN_EFFECTIVE_DRAWS = 700
"""Minimum effective number of draws of the slowest figure: the error of a 5% quantile is then 2.5% of the 90% interval.
[1]"""
STARTING_WIDTH = 1.3
"""Width of the chains' starting points relative to the fit's posterior. [1]"""
FIGURES = ("log_apogee", "log_cd", "log_alpha")
"""Of the next flight: log of its apogee [m], and of the rocket's Cd and thrust factor on it, without scatter. [1]"""


@dataclass(frozen=True, slots=True)
class Case:
    """Flights of a rocket, its next flight, the hyperprior, and information from other rockets about the shared
    terms."""

    flown: tuple[tuple[Flight, Found], ...]
    plan: tuple[Flight, Found]
    hyperprior: Hyperprior
    shared: SharedPrior | None = None

    def model(self) -> Model:
        """The model of all flights, including the next one at the end."""
        return base_model(flown_and_planned(self.flown, [self.plan]), self.hyperprior, self.shared)


@dataclass(frozen=True, slots=True)
class SampledPosterior:
    """Draws of the posterior of terms and scales, and the convergence of the chains.

    `r_hat` and `effective` are the worst of the figures: split R-hat, and the effective number of draws.
    """

    terms: Float[Array, "draw term"]
    scales: Float[Array, "draw 3"]
    r_hat: float
    effective: float
    acceptance: float


def fitted(case: Case) -> Fit:
    """The fit used in forecasts."""
    model = replace(case.model().part(slice(0, len(case.flown))), coarse=True)
    return fit_robustly(model, observe(model.history, case.hyperprior))


def target_of(case: Case, result: Fit, readouts: Readouts | None = None) -> Target:
    """The exact posterior density of a case; its force uses readouts linear at the fit's last point."""
    return target(replace(result.model, coarse=False), result.data, _middle(result), readouts)


def sampled(case: Case, result: Fit, density: Target, rng: np.random.Generator) -> SampledPosterior:
    """Draws of an exact posterior from all chains in the order drawn.

    Positions are scaled by the approximate width of the posterior (a constant mass matrix). Chains that did not mix
    continue with the exact force from their last positions, and their earlier draws are dropped.
    """
    scatter, reading, _ = result.model.hyperprior.scales()
    every = scatter, reading, result.model.hyperprior.motor_scales()
    scales = (float(np.exp(result.weights @ np.log(each))) for each in every)
    middle = density.coordinates(_middle(result), *scales)
    root = np.linalg.inv(np.linalg.cholesky(density.curvature(middle)))

    def run(target: Target, position: Float[Array, "chain dimension"]) -> tuple[SampledPosterior, Array]:
        def whitened(at: Array) -> tuple[Array, Array]:
            log_density, force = target(middle + at @ root)
            return log_density, force @ root.T

        chains = hamiltonian.sample(whitened, _inside(whitened, position), WARM_UP, TRANSITIONS, rng)
        return _sampled(case, target, chains, middle + chains.positions @ root), chains.positions[-1]

    found, last = run(density, rng.normal(size=(CHAINS, density.dimension)) * STARTING_WIDTH)
    return found if found.effective > MIN_EFFECTIVE_DRAWS else run(replace(density, exact_force=True), last)[0]


def _sampled(
    case: Case, density: Target, chains: hamiltonian.Chains, at: Float[Array, "iteration chain dimension"]
) -> SampledPosterior:
    point = density.point(at.reshape(-1, density.dimension))
    scales = np.stack([point.scatter_scale, point.reading_scale, point.motor_scale], axis=-1)
    watched = np.concatenate([_shared_figures(case, point.terms), np.log(scales)], axis=1).reshape(*at.shape[:2], -1)
    figures = [watched[..., i] for i in range(watched.shape[-1])]
    return SampledPosterior(
        point.terms,
        scales,
        max(hamiltonian.split_r_hat(one) for one in figures),
        min(hamiltonian.effective_size(one) for one in figures),
        chains.acceptance,
    )


def next_flight(
    case: Case, terms: Float[Array, "draw term"], scales: Float[Array, "draw 3"], seed: int
) -> Float[Array, "draw figure"]:
    """`FIGURES` of the next flight, simulated with posterior draws; its scatter depends only on the seed."""
    plan = case.model().part(slice(len(case.flown), None))
    rng = np.random.default_rng(seed)
    heaviest = max(motor.motor.loaded_mass for _, motor in case.flown)
    fitted = FittedForecast(plan, terms.mean(axis=0), terms, scales, len(case.flown), heaviest, "field", rng)
    return _figures(fitted)


def summary_of_fit(case: Case, draws: int, seed: int) -> Float[Array, "draw figure"]:
    """`FIGURES` of the next flight from the fit's forecast."""
    return _figures(
        learn(
            flown_and_planned(case.flown, [case.plan]),
            Assumed(shared=case.shared, hyperprior=case.hyperprior),
            draws=draws,
            seed=seed,
        )
    )


def _middle(result: Fit) -> Float[Array, "term"]:
    low, high = (np.array([getattr(term, end) for term in result.model.terms]) for end in ("low", "high"))
    return np.asarray(np.clip(result.moments()[0], low, high))


def _shared_figures(case: Case, terms: Float[Array, "draw term"]) -> Float[Array, "draw 3"]:
    """Log Cd and log alpha of the rocket on the next flight, and the discrepancy of its apogee. [1]"""
    plan = case.model().part(slice(len(case.flown), None))
    return np.concatenate([bent(plan, terms, name) for name in ("drag", "thrust", "apogee")], axis=1)


def _figures(fitted: FittedForecast) -> Float[Array, "draw figure"]:
    (prediction,) = fly_ahead(fitted)
    apogee = np.log(np.maximum(prediction.true_apogee, 1.0))
    return np.stack([apogee, *(bent(fitted.model, fitted.values, name)[:, 0] for name in ("drag", "thrust"))], axis=-1)


def _inside(density: hamiltonian.Density, start: Float[Array, "chain dimension"]) -> Float[Array, "chain dimension"]:
    """Starts with a nonzero density: the others are moved toward the middle."""
    for _ in range(20):
        outside = ~np.isfinite(density(start)[0])
        if not outside.any():
            break
        start = np.where(outside[:, None], 0.7 * start, start)
    return start


def quantiles(figures: Float[Array, "draw figure"], levels: Sequence[float] = (0.05, 0.5, 0.95)) -> Array:
    """Quantiles of each figure. [level figure]"""
    return np.asarray(np.quantile(figures, levels, axis=0))
