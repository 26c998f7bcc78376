"""A problem with a known exact answer: the paper's rocket, prior and simulator, with more readouts.

Only Cd, alpha and optionally the burn time are random, so the exact posterior follows from the simulator on a grid. An
ensemble of the field's kind, trained on this problem, is compared with it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from fieldkit.inference.network.mixture import Mixture
from fieldkit.model.observations import DECLARED_FIELDS, READOUT_NAMES, Observed, disc
from fieldkit.model.paper_prior_predictive import ALPHA_RANGE, CD_RANGE
from fieldkit.physics import paper
from fieldkit.physics.flight import fly
from fieldkit.shapes import Array, Flags, Float, Int

NOISE: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "apogee": (3.0, 0.0),
        "top_speed": (1.0, 0.0),
        "peak_accel": (0.0, 0.03),
        "avg_accel": (0.0, 0.03),
        "coast_to_apogee": (0.1, 0.0),
    }
)
"""The readouts and the two parts of their standard deviation: a constant in SI, and a fraction of the true value."""
SUBSETS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"apogee": ("apogee",), "apogee, speed": ("apogee", "top_speed"), "all five": tuple(NOISE)}
)
BURN_SD = 0.05
"""Standard deviation of the log burn time at constant impulse, if it is uncertain. [1]"""
NODES = 7
"""Number of nodes of the quadrature over the burn time."""
_MASSES = np.array(list(paper.DRY_MASS.values()))
_BURNS = paper.paper_burns()


@dataclass(frozen=True, slots=True)
class Restricted:
    """Flights of the restricted problem: observed readouts, log drag area and alpha, and the rocket of each."""

    observed: Observed
    truth: Float[Array, "flight 2"]
    motor: Int[Any, "flight"]
    config: Int[Any, "flight"]


def intervals(count: int) -> tuple[Float[Array, "flight 2"], Float[Array, "flight 2"]]:
    """Bounds of the prior of log drag area and alpha. [log m^2], [1]"""
    area = np.log(disc(np.asarray(paper.DIAMETER)))
    ends = np.array([[np.log(cd) + area, alpha] for cd, alpha in zip(CD_RANGE, ALPHA_RANGE, strict=True)])
    low, high = (np.broadcast_to(end, (count, 2)) for end in ends)
    return low, high


def restricted_draws(
    rng: np.random.Generator, count: int, burn_sd: float = 0.0
) -> tuple[Restricted, Float[Array, "flight readout"]]:
    """Flights drawn from the paper's priors with one measurement, and their readouts without noise.

    `burn_sd` is the standard deviation of the log burn time. [1]
    """
    motor, config = rng.integers(len(paper.MOTORS), size=count), rng.integers(len(_MASSES), size=count)
    cd, alpha = rng.uniform(*CD_RANGE, size=count), rng.uniform(*ALPHA_RANGE, size=count)
    stretch = np.exp(burn_sd * rng.normal(size=count)) if burn_sd else np.ones(count)
    clean = _clean(motor, config, cd, alpha, stretch)
    truth = np.stack([np.log(cd * disc(np.asarray(paper.DIAMETER))), alpha], axis=-1)
    return Restricted(measured(rng, clean, motor, config), truth, motor, config), clean


def measured(
    rng: np.random.Generator,
    clean: Float[Array, "flight readout"],
    motor: Int[Any, "flight"],
    config: Int[Any, "flight"],
) -> Observed:
    """The flights with noise on their readouts, in SI."""
    readouts = np.full(clean.shape, np.nan)
    for name, (floor, relative) in NOISE.items():
        column = READOUT_NAMES.index(name)
        spread = floor + relative * clean[:, column]
        readouts[:, column] = clean[:, column] + spread * rng.normal(size=len(clean))
    declared = np.full((len(clean), len(DECLARED_FIELDS)), np.nan)
    declared[:, 0], declared[:, 1] = _MASSES[config], paper.DIAMETER
    return Observed(np.stack([_figures(one) for one in paper.MOTORS])[motor], declared, readouts)


def _clean(motor: Int[Any, "*#draw"], config: Int[Any, "*#draw"], cd: Array, alpha: Array, stretch: Array) -> Array:
    setup = paper.paper_setup(motor, _MASSES[config], cd, alpha, curves=_BURNS)
    readouts = fly(setup.with_changes(burn_stretch=stretch)).readouts()
    return np.stack([readouts[name] for name in READOUT_NAMES], axis=-1)


def _figures(motor: paper.DeclaredMotor) -> Float[Array, "figure"]:
    """The figures of a declared motor, with the impulse of its profile."""
    time = np.linspace(0, motor.burn_time, 4001)
    thrust = np.interp(time, motor.time, motor.thrust)
    weight = thrust / thrust.sum()
    middle = float((weight * time).sum())
    spread = float(np.sqrt((weight * (time - middle) ** 2).sum()))
    timing = [motor.burn_time, motor.burn_time, motor.peak_thrust, middle, spread]
    return np.array([motor.delivered_impulse, *timing, motor.propellant_mass, motor.casing_mass, 0.029])


@dataclass(frozen=True, slots=True)
class Exact:
    """Readouts without noise on a grid of Cd and alpha, for each motor and configuration.

    A node is one of the burn times of the quadrature, and `log_weight` the log of its weight.
    """

    cd: Float[Array, "cell"]
    alpha: Float[Array, "cell"]
    readouts: Float[Array, "motor config node cell readout"]
    log_weight: Float[Array, "node"]

    def log_posterior(self, flights: Restricted, row: int, names: tuple[str, ...]) -> Float[Array, "cell"]:
        """Log posterior probability of each cell given some readouts of one flight. [nat]"""
        grid = self.readouts[flights.motor[row], flights.config[row]]
        each = np.zeros(grid.shape[:-1]) + self.log_weight[:, None]
        for name in names:
            column = READOUT_NAMES.index(name)
            floor, relative = NOISE[name]
            spread = floor + relative * grid[..., column]
            each -= 0.5 * ((flights.observed.readouts[row, column] - grid[..., column]) / spread) ** 2 + np.log(spread)
        log = np.logaddexp.reduce(each, axis=0)
        top = log.max()
        return np.asarray(log - top - np.log(np.exp(log - top).sum()))

    def medians(self, flights: Restricted, row: int, names: tuple[str, ...]) -> Float[Array, "2"]:
        """Posterior medians of Cd and alpha given some readouts of one flight, which minimize the mean absolute error.
        [1]"""
        mass = np.exp(self.log_posterior(flights, row, names))
        return np.array([_median(values, mass) for values in (self.cd, self.alpha)])


def exact(cells: int = 300, burn_sd: float = 0.0) -> Exact:
    """The grid with `cells` per axis, and Gauss-Hermite nodes of the log burn time if its standard
    deviation [1] is above zero."""
    centres = (np.arange(cells) + 0.5) / cells
    cd, alpha = np.meshgrid(CD_RANGE[0] + np.ptp(CD_RANGE) * centres, ALPHA_RANGE[0] + np.ptp(ALPHA_RANGE) * centres)
    cd, alpha = cd.ravel(), alpha.ravel()
    node, weight = np.polynomial.hermite_e.hermegauss(NODES if burn_sd else 1)
    stretch = np.exp(burn_sd * node)[:, None]
    motor, config = (np.arange(n).reshape(shape) for n, shape in ((3, (3, 1, 1, 1)), (2, (1, 2, 1, 1))))
    return Exact(cd, alpha, _clean(motor, config, cd, alpha, stretch), np.log(weight / weight.sum()))


def against_exact(
    flights: Restricted, densities: Mapping[str, Mixture], grid: Exact, count: int = 500
) -> dict[str, dict[str, float]]:
    """Mean absolute errors of an ensemble's median and of the exact one on the first `count` flights, and their
    divergence.

    `kl` is the mean Kullback-Leibler divergence of the ensemble from the exact posterior. [nat]
    """
    return {name: _against(flights, densities[name], grid, SUBSETS[name], count) for name in SUBSETS}


def _against(
    flights: Restricted, density: Mixture, grid: Exact, names: tuple[str, ...], count: int
) -> dict[str, float]:
    area = disc(np.asarray(paper.DIAMETER))
    cells = np.stack([np.log(grid.cd * area), grid.alpha], axis=-1)
    size = np.ptp(CD_RANGE) * np.ptp(ALPHA_RANGE) / len(cells)
    half = np.array([0.5])
    found = np.stack([density.margin(axis).quantiles(half)[:, 0] for axis in (0, 1)], axis=-1)
    found[:, 0] = np.exp(found[:, 0]) / area
    truth = np.stack([np.exp(flights.truth[:, 0]) / area, flights.truth[:, 1]], axis=-1)
    best, divergence = np.empty((count, 2)), np.empty(count)
    for row in range(count):
        log = grid.log_posterior(flights, row, names)
        mass = np.exp(log)
        best[row] = grid.medians(flights, row, names)
        kept: Flags = mass > 1e-12
        one = density.rows([row])
        own = one.log_density(cells[kept][:, None])[:, 0] - np.log(grid.cd[kept]) + np.log(size)
        divergence[row] = float((mass[kept] * (log[kept] - own)).sum())
    errors, least = np.abs(found[:count] - truth[:count]), np.abs(best - truth[:count])
    return {
        "cd_mae": float(errors[:, 0].mean()),
        "alpha_mae": float(errors[:, 1].mean()),
        "cd_mae_exact": float(least[:, 0].mean()),
        "alpha_mae_exact": float(least[:, 1].mean()),
        "kl": float(divergence.mean()),
    }


def _median(values: Float[Array, "cell"], mass: Float[Array, "cell"]) -> float:
    places, which = np.unique(values, return_inverse=True)
    below = np.cumsum(np.bincount(which, mass))
    half = 0.5 * (places[1] - places[0])
    return float(np.interp(0.5, below, places + half))
