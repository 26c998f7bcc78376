"""Hamiltonian Monte Carlo on many chains at once, with a force that need not be the exact gradient.

Leapfrog steps preserve volume and are reversible for any force that depends only on the position. With the exact energy
in the acceptance step, the density stays invariant: an approximate gradient lowers only the acceptance rate (Neal, MCMC
Using Hamiltonian Dynamics, 2011, section 5.5; Zhang, Shahbaba and Zhao, Hamiltonian Monte Carlo Acceleration Using
Surrogate Functions, 2017).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, pi

import numpy as np

from fieldkit.shapes import Array, Flags, Float

Density = Callable[[Array], tuple[Array, Array]]
"""Log density and force at positions, `[chain dimension]` to `[chain]` and `[chain dimension]`."""

ACCEPTANCE = 0.7
"""Target acceptance rate for choosing the step size during warm-up. [1]"""
MIN_STEP = 0.2
"""Minimum step size: smaller steps do not reduce the error of the force. [1]"""


@dataclass(frozen=True, slots=True)
class Chains:
    """Positions after warm-up, the fraction of proposals accepted, and the step size. [1]"""

    positions: Float[Array, "iteration chain dimension"]
    acceptance: float
    step: float


@dataclass(frozen=True, slots=True)
class _State:
    position: Float[Array, "chain dimension"]
    log_density: Float[Array, "chain"]
    force: Float[Array, "chain dimension"]

    def where(self, taken: Flags, other: "_State") -> "_State":
        """The other state if it was accepted, otherwise this one."""
        return _State(
            np.where(taken[:, None], other.position, self.position),
            np.where(taken, other.log_density, self.log_density),
            np.where(taken[:, None], other.force, self.force),
        )


def sample(
    density: Density, start: Float[Array, "chain dimension"], warm_up: int, draws: int, rng: np.random.Generator
) -> Chains:
    """Chains from `start`, for a density about as wide in every direction as a standard normal one.

    The step size is adapted only during warm-up (Robbins and Monro, 1951). Raises ValueError if the density at a start
    is zero.
    """
    state = _State(start, *density(start))
    if not np.isfinite(state.log_density).all():
        raise ValueError("found a start outside the support of the density, expected one inside it")
    step, accepted = 0.5, []
    positions = np.empty((draws, *start.shape))
    for turn in range(warm_up + draws):
        state, chance = _transition(density, state, step * rng.uniform(0.8, 1.2), rng)
        if turn < warm_up:
            step = max(step * float(np.exp((chance - ACCEPTANCE) * 2 / np.sqrt(turn + 4))), MIN_STEP)
        else:
            accepted.append(chance)
            positions[turn - warm_up] = state.position
    return Chains(positions, float(np.mean(accepted)), float(step))


def _transition(density: Density, state: _State, step: float, rng: np.random.Generator) -> tuple[_State, float]:
    """One trajectory of every chain, at most a quarter of a period long, and the number accepted."""
    momentum = np.asarray(rng.normal(size=state.position.shape), float)
    before: Array = state.log_density - 0.5 * (momentum**2).sum(axis=1)
    end = state
    for _ in range(int(rng.integers(1, ceil(pi / 2 / step) + 1))):
        half = np.asarray(momentum + 0.5 * step * end.force)
        position = end.position + step * half
        end = _State(position, *density(position))
        momentum = np.asarray(half + 0.5 * step * end.force)
    gained = end.log_density - 0.5 * (momentum**2).sum(axis=1) - before
    chance = np.exp(np.minimum(np.where(np.isfinite(gained), gained, -np.inf), 0.0))
    return state.where(rng.uniform(size=len(chance)) < chance, end), float(chance.mean())


def split_r_hat(values: Float[Array, "iteration chain"]) -> float:
    """Convergence of one figure, each chain in halves: 1 if they agree (Gelman et al., BDA3, 2013, section 11.4)."""
    half = len(values) // 2
    parts = np.concatenate([values[:half], values[half : 2 * half]], axis=1)
    within = parts.var(axis=0, ddof=1).mean()
    between = parts.mean(axis=0).var(ddof=1)
    return float(np.sqrt((half - 1) / half + between / within))


def effective_size(values: Float[Array, "iteration chain"]) -> float:
    """Effective number of draws for the mean, by Geyer's initial monotone sequence over all chains. [1]"""
    count, chains = values.shape
    centred = values - values.mean()
    covariance = np.array(
        [(centred[: count - lag] * centred[lag:]).sum() / (count * chains) for lag in range(count // 2)]
    )
    pairs = (covariance[: len(covariance) // 2 * 2].reshape(-1, 2) / covariance[0]).sum(axis=1)
    positive = pairs[: int(np.argmax(pairs <= 0))] if (pairs <= 0).any() else pairs
    return float(count * chains / max(2 * np.minimum.accumulate(positive).sum() - 1, 1 / np.log10(count * chains)))
