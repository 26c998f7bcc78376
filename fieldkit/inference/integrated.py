"""The exact posterior of simulated flights, all that is random in them integrated out: what no method can beat.

Everything that a simulated flight draws is a function of standard normal numbers, so its posterior is a density over
these: their prior is normal, their likelihood the noise of the readouts, which is a sum of two Student t rounded to
the device's steps. It is integrated by importance sampling from a mixture of proposals (Owen and Zhou, Safe and
effective importance sampling, 2000), for many flights side by side. Slow, and there to judge the ensemble.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri, stdtr, stdtrit

from fieldkit.inference.measured import GAIN, NOISE, OFFSET
from fieldkit.inference.observed import (
    ALPHA_RANGE,
    ALPHA_SD,
    CD_RANGE,
    DECLARED,
    READOUT_NAMES,
    Observed,
    disc,
    figures,
)
from fieldkit.inference.simulated import STEPS, TAIL, Truth, flown_field
from fieldkit.motors import Motor
from fieldkit.shapes import Array, Float, Int
from fieldkit.simulator.flight import fly
from fieldkit.simulator.motor import Burns, burns

PARAMETERS = 2
"""Of the normal numbers, the first ones: they stand for Cd and alpha."""
DEVICE = 2
"""The next: offset and gain of the accelerometer."""
ROUNDS = 2
"""Times the proposal adapts."""
STUDENT = 5.0
"""Degrees of freedom of a proposal. [1]"""
STEP = 0.1
"""Of the differences that slopes are taken from, in standard deviations. [1]"""
PILOTS = 300
"""Draws of the prior that are looked at for places to climb from."""
PEAKS = 5
"""Of them, those that are climbed from."""
HOT = 2.0
"""By what their log likelihoods are divided when they are chosen. [1]"""
CLIMBS = 8
"""Steps towards the likeliest numbers."""
INFLATED = 1.15
"""A proposal's width over that of what it stands for. [1]"""
LEAST_SIZE = 60.0
"""Effective draws that a proposal is fitted to: weights are evened out until there are as many. [1]"""
_ANGLES = np.linspace(0.0, np.pi / 2, 33)
_REACH = np.sinh(np.linspace(-9.0, 9.0, 721))


class Latent:
    """Stands in for a generator of random numbers: each call takes the next column of given normal numbers."""

    def __init__(self, normals: Float[Array, "draw latent"]) -> None:
        self.normals, self.used = normals, 0

    def _next(self) -> Array:
        self.used += 1
        return self.normals[:, self.used - 1]

    def normal(self, loc: float = 0.0, scale: float = 1.0, size: int = 0) -> Array:
        return loc + scale * self._next()

    def uniform(self, low: float = 0.0, high: float = 1.0, size: int = 0) -> Array:
        return np.asarray(low + (high - low) * ndtr(self._next()))

    def standard_t(self, df: float, size: int = 0) -> Array:
        return np.asarray(stdtrit(df, ndtr(self._next())))


def _count_latents() -> int:
    counter = Latent(np.zeros((1, 64)))
    one = {name: np.ones(1) for name in DECLARED}
    flown_field(counter, np.ones((1, 9)), one, np.ones(1), np.ones(1))
    return PARAMETERS + DEVICE + counter.used


LATENTS = _count_latents()
"""Normal numbers of a flight."""


def parameters(
    normals: Float[Array, "draw latent"], diameter: Float[Array, "draw"]
) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
    """Logarithm of the drag area [log m^2] and alpha [1] that the first two numbers stand for."""
    low, high = np.log(CD_RANGE)
    ends = ndtr((np.array(ALPHA_RANGE) - 1.0) / ALPHA_SD)
    alpha = 1.0 + ALPHA_SD * ndtri(ends[0] + (ends[1] - ends[0]) * ndtr(normals[:, 1]))
    return low + (high - low) * ndtr(normals[:, 0]) + np.log(disc(diameter)), np.asarray(alpha)


def normals_of(
    values: Float[Array, "*draw flight 2"], diameter: Float[Array, "flight"]
) -> Float[Array, "*draw flight 2"]:
    """The two normal numbers that stand for a logarithm of drag area and an alpha."""
    low, high = np.log(CD_RANGE)
    ends = ndtr((np.array(ALPHA_RANGE) - 1.0) / ALPHA_SD)
    cd = (values[..., 0] - np.log(disc(diameter)) - low) / (high - low)
    alpha = (ndtr((values[..., 1] - 1.0) / ALPHA_SD) - ends[0]) / (ends[1] - ends[0])
    return np.asarray(ndtri(np.clip(np.stack([cd, alpha], axis=-1), 1e-9, 1 - 1e-9)))


@cache
def _sum_table() -> Float[Array, "angle reach"]:
    """Distribution of cos(a) t + sin(a) t' for two Student t, on a grid of angles and values."""
    nodes = stdtrit(TAIL, (np.arange(300) + 0.5) / 300)
    rows = [stdtr(TAIL, _REACH)]
    rows += [stdtr(TAIL, (_REACH[:, None] - np.cos(a) * nodes) / np.sin(a)).mean(axis=1) for a in _ANGLES[1:-1]]
    return np.stack([*rows, stdtr(TAIL, _REACH)])


def _below(values: Array, floor: Array, share: Array) -> Array:
    """Probability that noise of these two parts is below a value."""
    table = _sum_table()
    size = np.hypot(floor, share)
    place = np.arctan2(share, floor) / _ANGLES[1]
    row = np.clip(place.astype(int), 0, len(_ANGLES) - 2)
    part = place - row
    column = np.clip(np.arcsinh(values / size) / 9.0, -1, 1) * 360 + 360
    left = np.clip(column.astype(int), 0, 719)
    step = column - left
    low = table[row, left] * (1 - step) + table[row, left + 1] * step
    high = table[row + 1, left] * (1 - step) + table[row + 1, left + 1] * step
    return np.asarray(low * (1 - part) + high * part)


@dataclass(frozen=True, slots=True)
class Problem:
    """Flights whose posteriors are wanted: as observed, and which of the curves each burnt along."""

    observed: Observed
    curves: Burns
    row: Int[Any, "flight"]

    def __len__(self) -> int:
        return len(self.row)


def problem(truth: Truth, observed: Observed, motors: Sequence[Motor]) -> Problem:
    """Simulated flights as observed, all circumstances declared, with their motors found by their figures."""
    known = {figures(motor).tobytes(): number for number, motor in enumerate(motors)}
    row = np.array([known[np.ascontiguousarray(one).tobytes()] for one in truth.motor])
    flown, place = np.unique(row, return_inverse=True)
    return Problem(observed, burns([motors[number] for number in flown], steps=STEPS), place)


def _clean(one: Problem, normals: Float[Array, "flight draw latent"]) -> tuple[Observed, dict[str, Array]]:
    """What was observed, and what the device would show without noise and with endless digits; [flight * draw].

    nan where there is nothing to show, and throughout where nothing lifted.
    """
    flights, draws, _ = normals.shape
    flat = normals.reshape(flights * draws, -1)
    spread = np.repeat(np.arange(flights), draws)
    observed = one.observed.rows(spread)
    declared = {name: observed.given(name) for name in DECLARED}
    area, alpha = parameters(flat, declared["diameter"])
    setup = flown_field(Latent(flat[:, PARAMETERS + DEVICE :]), observed.motor, declared, np.exp(area), alpha)
    flown = fly(setup.with_changes(burns=one.curves, motor=one.row[spread]))
    clean = {name: flown.readouts()[name] for name in READOUT_NAMES}
    lifted = (flown.lift_off > 0) & (clean["apogee"] > 5.0) & (clean["top_speed"] > 3.0)
    offset, gain = OFFSET * flat[:, PARAMETERS], 1 + GAIN * flat[:, PARAMETERS + 1]
    clean["top_speed"] = (clean["top_speed"] + offset * clean["burn_time"]) * gain
    clean["peak_accel"] = (clean["peak_accel"] + offset) * gain
    return observed, {name: np.where(lifted, value, np.nan) for name, value in clean.items()}


def log_likelihood(one: Problem, normals: Float[Array, "flight draw latent"]) -> Float[Array, "flight draw"]:
    """Log probability of what was observed of every flight, given the numbers that made it."""
    observed, clean = _clean(one, normals)
    total = np.where(np.isfinite(clean["apogee"]), 0.0, -np.inf)
    for name, (low, high) in _bins(observed).items():
        both = np.isfinite(low) & np.isfinite(clean[name])
        middle = np.where(both, clean[name], 1.0)
        share, floor = NOISE[name].share * np.abs(middle), np.full(len(middle), NOISE[name].floor)
        ends = [_below(np.where(both, end, 1.0) - middle, floor, share) for end in (low, high)]
        told = np.log(np.maximum(ends[1] - ends[0], 1e-300))
        total += np.where(both, told, np.where(np.isfinite(low), -np.inf, 0.0))
    return np.asarray(total.reshape(normals.shape[:2]))


def _misses(one: Problem, normals: Float[Array, "flight draw latent"]) -> Float[Array, "flight draw readout"]:
    """Observed less shown, in standard deviations of a normal about as wide as the noise; 0 where not recorded."""
    observed, clean = _clean(one, normals)
    found = [np.zeros(len(observed))]
    for name, (low, high) in _bins(observed).items():
        noise = NOISE[name]
        size = np.sqrt(1.3 * (noise.floor**2 + (noise.share * clean[name]) ** 2) + (high - low) ** 2 / 12)
        found.append(np.nan_to_num((0.5 * (low + high) - clean[name]) / size))
    return np.clip(np.stack(found, axis=-1), -30, 30).reshape(*normals.shape[:2], -1)


def _bins(observed: Observed) -> dict[str, tuple[Array, Array]]:
    """Between what each readout was before it was rounded; nan where it was not recorded.

    Average acceleration is speed over burn time, so it narrows down the burn time.
    """
    found = {}
    for name in READOUT_NAMES:
        value, half = observed.readout(name), 0.5 * NOISE[name].step
        if name != "avg_accel" and np.isfinite(value).any():
            found[name] = (value - half, value + half)
    if "burn_time" in found and "top_speed" in found:
        average, half = observed.readout("avg_accel"), 0.5 * NOISE["avg_accel"].step
        (slow, fast), (short, long) = found["top_speed"], found["burn_time"]
        with np.errstate(divide="ignore", invalid="ignore"):
            narrow = np.fmax(short, slow / (average + half)), np.fmin(long, fast / np.maximum(average - half, 1e-6))
        agrees = narrow[1] > narrow[0]
        found["burn_time"] = (np.where(agrees, narrow[0], short), np.where(agrees, narrow[1], long))
    return found


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
    """A Student t about a mean, for every flight; without degrees of freedom a normal."""

    mean: Float[Array, "flight latent"]
    root: Float[Array, "flight latent latent"]
    student: float

    def draw(self, rng: np.random.Generator, count: int) -> Float[Array, "flight draw latent"]:
        unit = rng.normal(size=(len(self.mean), count, self.mean.shape[1]))
        if self.student:
            unit /= np.sqrt(rng.chisquare(self.student, size=(len(self.mean), count, 1)) / self.student)
        return np.asarray(self.mean[:, None] + unit @ np.swapaxes(self.root, 1, 2))

    def log_density(self, values: Float[Array, "flight draw latent"]) -> Float[Array, "flight draw"]:
        from scipy.special import gammaln

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
    """Weighted draws of the posterior of every flight, begun where these numbers of Cd and alpha are.

    With `fixed` the two stay there, and the evidence is the likelihood of that point alone.
    """
    free = slice(PARAMETERS if fixed else 0, LATENTS)
    start = np.zeros((len(one), LATENTS))
    start[:, :PARAMETERS] = begin
    normals = [_normal(one, place, free) for place in _starts(rng, one, start, free)]
    proposals = [replace(normal, root=normal.root * INFLATED) for normal in normals]
    proposals.append(replace(normals[0], root=normals[0].root * 2 * INFLATED))
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
    """Fresh draws, as many of each proposal, and their log weights.

    Draws that a proposal was fitted to are not used again: with them the evidence would come out low.
    """
    drawn = np.concatenate([proposal.draw(rng, count) for proposal in proposals], axis=1)
    values = np.broadcast_to(start[:, None], (*drawn.shape[:2], LATENTS)).copy()
    values[..., free] = drawn
    prior = -0.5 * (drawn**2 + np.log(2 * np.pi)).sum(axis=-1)
    mixed = np.logaddexp.reduce([proposal.log_density(drawn) for proposal in proposals], axis=0)
    log_weight = prior + log_likelihood(one, values) - mixed + np.log(len(proposals))
    return values, log_weight


def _defences(normal: _Proposal) -> list[_Proposal]:
    """The prior, whole, and with Cd and alpha about where they are likely: no mass is out of reach of both.

    Without them a share of the evidence is missed where what happens to few flights happened.
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
    """Where to climb from: the middle of the prior, and likely ones among some draws of it.

    What happens to few flights, such as an early ejection, has no slope in the middle of the prior.
    """
    pilots = np.broadcast_to(start[:, None], (len(one), PILOTS, LATENTS)).copy()
    pilots[..., PARAMETERS:] = rng.normal(size=pilots[..., PARAMETERS:].shape)
    if free.start == 0:
        pilots[..., :PARAMETERS] += 0.2 * rng.normal(size=pilots[..., :PARAMETERS].shape)
    log_weight = np.maximum(log_likelihood(one, pilots), -1e6)
    rows = np.arange(len(one))
    chosen = [start]
    for _ in range(PEAKS):
        drawn = np.argmax(log_weight / HOT + rng.gumbel(size=log_weight.shape), axis=1)
        log_weight[rows, drawn] = -np.inf
        chosen.append(pilots[rows, drawn])
    return chosen


def _normal(one: Problem, start: Float[Array, "flight latent"], free: slice) -> _Proposal:
    """About the likeliest numbers, by Gauss and Newton; readouts linear in the numbers there."""
    at = start.copy()
    size = len(range(*free.indices(LATENTS)))
    steps = np.zeros((size + 1, LATENTS))
    steps[1:, free] = STEP * np.eye(size)
    best = np.full(len(at), np.inf)
    kept, slope = at.copy(), np.zeros((len(at), 1, size))
    for _ in range(CLIMBS):
        misses = _misses(one, at[:, None] + steps)
        cost = (misses[:, 0] ** 2).sum(axis=-1) + (at[:, free] ** 2).sum(axis=-1)
        better = cost < best
        slope_here = -np.moveaxis(misses[:, 1:] - misses[:, :1], 1, 2) / STEP
        slope = np.where(better[:, None, None], slope_here, slope)
        kept, best = np.where(better[:, None], at, kept), np.minimum(cost, best)
        move = np.linalg.solve(
            np.eye(size) + np.swapaxes(slope_here, 1, 2) @ slope_here,
            (np.einsum("for,fo->fr", slope_here, misses[:, 0]) - at[:, free])[..., None],
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
    """A Student t about the weighted draws so far, shrunk to the one of the start by how few they are."""
    mean, root = normal.mean.copy(), normal.root.copy()
    size = mean.shape[1]
    for flight in range(len(mean)):
        weight = _evened(log_weight[flight])
        mean[flight] = weight @ values[flight]
        off = values[flight] - mean[flight]
        trust = 1 / (1 + 4 * size * (weight**2).sum())
        spread = trust * (off * weight[:, None]).T @ off + (1 - trust) * root[flight] @ root[flight].T
        root[flight] = INFLATED * np.linalg.cholesky(spread + 1e-9 * np.eye(size))
    return _Proposal(mean, root, STUDENT)


def _evened(log_weight: Float[Array, "draw"]) -> Float[Array, "draw"]:
    """Weights to the largest power of 0.8 that leaves `LEAST_SIZE` effective draws."""
    log_weight = np.maximum(log_weight - log_weight.max(), -700.0)
    for power in 0.8 ** np.arange(40):
        weight = np.exp(power * log_weight)
        weight /= weight.sum()
        if 1 / (weight**2).sum() >= LEAST_SIZE:
            break
    return np.asarray(weight)
