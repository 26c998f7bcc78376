"""The exact posterior of simulated flights with all random inputs integrated out, a lower bound on the error of any
method.

The random inputs of a flight have a normal prior and an exact likelihood (`likelihood`). The posterior is integrated by
importance sampling from a mixture of proposals (Owen and Zhou, Safe and effective importance sampling, 2000), for many
flights at once. It is slow, and used only to evaluate the ensemble.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammaln

from fieldkit.shapes import Array, Float
from studies.exact.likelihood import LATENTS, PARAMETERS, Problem, log_likelihood, misses

ROUNDS = 2
"""Number of adaptations of the proposal."""
STUDENT = 5.0
"""Degrees of freedom of a proposal. [1]"""
STEP = 0.1
"""Finite-difference step for derivatives, in standard deviations. [1]"""
PILOTS = 300
"""Number of prior draws to choose starting points from."""
PEAKS = 5
"""Number of starting points."""
TEMPERATURE = 2.0
"""Divisor of the log likelihoods in the choice of starting points. [1]"""
CLIMBS = 8
"""Number of Gauss-Newton steps."""
PROPOSAL_INFLATION = 1.15
"""Width of a proposal relative to its target. [1]"""
LEAST_SIZE = 60.0
"""Minimum effective number of draws for fitting a proposal: weights are tempered until it is reached. [1]"""


@dataclass(frozen=True, slots=True)
class Draws:
    """Weighted draws of the posterior of every flight, and the log of its evidence."""

    normals: Float[Array, "flight draw latent"]
    weight: Float[Array, "flight draw"]
    log_evidence: Float[Array, "flight"]

    @property
    def size(self) -> Float[Array, "flight"]:
        """Effective number of draws. [1]"""
        return np.asarray(1 / (self.weight**2).sum(axis=1))


@dataclass(frozen=True, slots=True)
class _Proposal:
    """A Student t around a mean for every flight; a normal without degrees of freedom."""

    mean: Float[Array, "flight latent"]
    root: Float[Array, "flight latent latent"]
    student: float

    def draw(self, rng: np.random.Generator, count: int) -> Float[Array, "flight draw latent"]:
        unit = rng.normal(size=(len(self.mean), count, self.mean.shape[1]))
        if self.student:
            unit /= np.sqrt(rng.chisquare(self.student, size=(len(self.mean), count, 1)) / self.student)
        return np.asarray(self.mean[:, None] + unit @ np.swapaxes(self.root, 1, 2))

    def log_density(self, values: Float[Array, "flight draw latent"]) -> Float[Array, "flight draw"]:
        size = self.mean.shape[1]
        unit = (values - self.mean[:, None]) @ np.swapaxes(np.linalg.inv(self.root), 1, 2)
        square = (unit**2).sum(axis=-1)
        log_root = np.log(np.abs(np.diagonal(self.root, axis1=1, axis2=2))).sum(axis=1)[:, None]
        if not self.student:
            return np.asarray(-0.5 * square - 0.5 * size * np.log(2 * np.pi) - log_root)
        half = 0.5 * (self.student + size)
        norm = gammaln(half) - gammaln(0.5 * self.student) - 0.5 * size * np.log(np.pi * self.student)
        return np.asarray(norm - half * np.log1p(square / self.student) - log_root)


def integrate(
    rng: np.random.Generator,
    one: Problem,
    begin: Float[Array, "flight 2"],
    count: int = 2000,
    *,
    fixed: bool = False,
) -> Draws:
    """Weighted draws of the posterior of every flight. The proposals start at `begin`, the normal inputs for Cd and
    alpha.

    With `fixed`, these two inputs do not change, and the evidence is the likelihood of that point.
    """
    free = slice(PARAMETERS if fixed else 0, LATENTS)
    start = np.zeros((len(one), LATENTS))
    start[:, :PARAMETERS] = begin
    normals = [_normal(one, place, free) for place in _starts(rng, one, start, free)]
    proposals = [replace(normal, root=normal.root * PROPOSAL_INFLATION) for normal in normals]
    proposals.append(replace(normals[0], root=normals[0].root * 2 * PROPOSAL_INFLATION))
    proposals += _defences(normals[0])
    for _ in range(ROUNDS):
        values, log_weight = _weighed(rng, one, proposals, start, free, count // 2)
        proposals.append(_fitted(values[..., free], log_weight, normals[0]))
    values, log_weight = _weighed(rng, one, proposals, start, free, count)
    top = log_weight.max(axis=1, keepdims=True)
    weight = np.exp(log_weight - top)
    evidence = np.log(weight.mean(axis=1)) + top[:, 0]
    return Draws(values, weight / weight.sum(axis=1, keepdims=True), evidence)


def _weighed(
    rng: np.random.Generator,
    one: Problem,
    proposals: Sequence[_Proposal],
    start: Float[Array, "flight latent"],
    free: slice,
    count: int,
) -> tuple[Float[Array, "flight draw latent"], Float[Array, "flight draw"]]:
    """New draws, the same number from each proposal, and their log weights.

    Draws used to fit a proposal are not reused: they would bias the evidence low.
    """
    drawn = np.concatenate([proposal.draw(rng, count) for proposal in proposals], axis=1)
    values = np.broadcast_to(start[:, None], (*drawn.shape[:2], LATENTS)).copy()
    values[..., free] = drawn
    prior = -0.5 * (drawn**2 + np.log(2 * np.pi)).sum(axis=-1)
    mixed = np.logaddexp.reduce([proposal.log_density(drawn) for proposal in proposals], axis=0)
    log_weight = prior + log_likelihood(one, values) - mixed + np.log(len(proposals))
    return values, log_weight


def _defences(normal: _Proposal) -> list[_Proposal]:
    """Proposals from the full prior, and from the prior with Cd and alpha near their likely values, which cover all
    mass.

    Without them, part of the evidence is missed if rare scatter occurred.
    """
    size = normal.mean.shape[1]
    whole = np.broadcast_to(np.eye(size), normal.root.shape).copy()
    defences = [_Proposal(np.zeros_like(normal.mean), whole, 0.0)]
    if size == LATENTS:
        mean, root = np.zeros_like(normal.mean), whole.copy()
        mean[:, :PARAMETERS] = normal.mean[:, :PARAMETERS]
        spread = normal.root[:, :PARAMETERS] @ np.swapaxes(normal.root[:, :PARAMETERS], 1, 2)
        root[:, :PARAMETERS, :PARAMETERS] = 1.5 * np.linalg.cholesky(spread)
        defences.append(_Proposal(mean, root, STUDENT))
    return defences


def _starts(
    rng: np.random.Generator, one: Problem, start: Float[Array, "flight latent"], free: slice
) -> list[Float[Array, "flight latent"]]:
    """Starting points: the middle of the prior and likely prior draws.

    Rare events, such as an early ejection, have a zero derivative in the middle of the prior.
    """
    pilots = np.broadcast_to(start[:, None], (len(one), PILOTS, LATENTS)).copy()
    pilots[..., PARAMETERS:] = rng.normal(size=pilots[..., PARAMETERS:].shape)
    if free.start == 0:
        pilots[..., :PARAMETERS] += 0.2 * rng.normal(size=pilots[..., :PARAMETERS].shape)
    log_weight = np.maximum(log_likelihood(one, pilots), -1e6)
    rows = np.arange(len(one))
    chosen = [start]
    for _ in range(PEAKS):
        drawn = np.argmax(log_weight / TEMPERATURE + rng.gumbel(size=log_weight.shape), axis=1)
        log_weight[rows, drawn] = -np.inf
        chosen.append(pilots[rows, drawn])
    return chosen


def _normal(one: Problem, start: Float[Array, "flight latent"], free: slice) -> _Proposal:
    """A proposal around the most likely inputs by Gauss-Newton, with readouts linear there."""
    at = start.copy()
    size = len(range(*free.indices(LATENTS)))
    steps = np.zeros((size + 1, LATENTS))
    steps[1:, free] = STEP * np.eye(size)
    best = np.full(len(at), np.inf)
    kept, slope = at.copy(), np.zeros((len(at), 1, size))
    for _ in range(CLIMBS):
        missed = misses(one, at[:, None] + steps)
        cost = (missed[:, 0] ** 2).sum(axis=-1) + (at[:, free] ** 2).sum(axis=-1)
        better = cost < best
        slope_here = -np.moveaxis(missed[:, 1:] - missed[:, :1], 1, 2) / STEP
        slope = np.where(better[:, None, None], slope_here, slope)
        kept, best = np.where(better[:, None], at, kept), np.minimum(cost, best)
        move = np.linalg.solve(
            np.eye(size) + np.swapaxes(slope_here, 1, 2) @ slope_here,
            (np.einsum("for,fo->fr", slope_here, missed[:, 0]) - at[:, free])[..., None],
        )[..., 0]
        ahead = at.copy()
        ahead[:, free] += np.clip(move, -1.5, 1.5)
        halfway = np.where(better[:, None], ahead, 0.5 * (kept + at))
        at = np.clip(halfway, -6, 6)
    root = np.linalg.cholesky(np.linalg.inv(np.eye(size) + np.swapaxes(slope, 1, 2) @ slope))
    return _Proposal(kept[:, free], root, STUDENT)


def _fitted(
    values: Float[Array, "flight draw latent"], log_weight: Float[Array, "flight draw"], normal: _Proposal
) -> _Proposal:
    """A Student t around the weighted draws so far, shrunk toward the starting one if they are few."""
    mean, root = normal.mean.copy(), normal.root.copy()
    size = mean.shape[1]
    for flight in range(len(mean)):
        weight = _equalized(log_weight[flight])
        mean[flight] = weight @ values[flight]
        off = values[flight] - mean[flight]
        trust = 1 / (1 + 4 * size * (weight**2).sum())
        spread = trust * (off * weight[:, None]).T @ off + (1 - trust) * root[flight] @ root[flight].T
        root[flight] = PROPOSAL_INFLATION * np.linalg.cholesky(spread + 1e-9 * np.eye(size))
    return _Proposal(mean, root, STUDENT)


def _equalized(log_weight: Float[Array, "draw"]) -> Float[Array, "draw"]:
    """Weights tempered by the largest power of 0.8 that gives `LEAST_SIZE` effective draws."""
    log_weight = np.maximum(log_weight - log_weight.max(), -700.0)
    for power in 0.8 ** np.arange(40):
        weight = np.exp(power * log_weight)
        weight /= weight.sum()
        if 1 / (weight**2).sum() >= LEAST_SIZE:
            break
    return np.asarray(weight)
