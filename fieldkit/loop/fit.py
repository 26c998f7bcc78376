"""The posterior of a model's terms, its evidence, and what it predicts for flights left out.

At a point the readouts are linear in the terms and in the scatter of single flights (derivatives by
differences of the simulator, all in one batch), so that scatter integrates out exactly, the posterior is
normal, and leaving a flight out is one subtraction (Gauss-Newton and Laplace; Bishop, Pattern Recognition
and Machine Learning, 2006, chapters 3 and 4). The point is moved to the posterior mean a few times. How
large scatter and reading errors are is not known beforehand: both are scaled by factors on a grid, weighed
by the evidence for each.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import erf, log, sqrt

import numpy as np

from fieldkit.loop.model import OBSERVED, OPENING, Data, Model, reading_sd
from fieldkit.loop.spread import TAIL, Spread, apogee_spread
from fieldkit.loop.tangent import Tangent, lean_slope, tangents
from fieldkit.shapes import Array, Flags, Float

SCATTER_SCALES = np.array([0.5, 1.0, 1.6, 2.5, 4.0, 6.5])
"""Scatter of single flights in units of ordinary scatter. [1]"""
READING_SCALES = np.array([0.7, 1.2, 2.0])
"""Reading errors in units of the expected. [1]"""
DOUBTED_SCALES = np.array([1.0, 3.0, 9.0])
"""The same of all but the apogee, where the device is doubted. [1]"""
_LOG_SCATTER_PRIOR = -0.5 * (np.log(SCATTER_SCALES / 2.0) / 0.7) ** 2
_LOG_READING_PRIOR = -0.5 * (np.log(READING_SCALES / 1.0) / 0.4) ** 2
_LOG_DOUBTED_PRIOR = -0.5 * (np.log(DOUBTED_SCALES / 1.0) / 1.0) ** 2
ROUNDS = 5
"""Times the point of linearisation is moved."""
HOPELESS = 8.0
"""Log evidence behind the best of fits made side by side, from which on one is not followed further. [nat]"""
OPENINGS = (0.15, 0.6, 1.2)
"""Opening times from which a fit is begun. [s]"""
ROBUST_ROUNDS = 2
"""Times the point is moved after trust in single flights has settled."""
TRUST_ROUNDS = 2
"""Times trust in single flights is weighed anew about one point."""
FEWEST = 3
"""Flights from which on one may be contradicted by the others."""
UNSEEN = 1e3
"""Standard deviation given to what was not observed."""


@dataclass(frozen=True, slots=True)
class Fit:
    """A normal posterior of the terms for every pair of scales, at the last point of linearisation.

    Axis `scale` runs over the grid of scatter and reading scales, `log_weight` is the log of their
    posterior weight times evidence (unnormalised; its log-sum is the log evidence of the model). `noise` is the
    covariance of each flight's readouts about what the terms say, `sharpness` its inverse.
    """

    model: Model
    data: Data
    tangent: Tangent
    mean: Float[Array, "scale term"]
    precision: Float[Array, "scale term term"]
    gain: Float[Array, "scale term"]
    noise: Float[Array, "scale flight readout readout"]
    sharpness: Float[Array, "scale flight readout readout"]
    log_weight: Float[Array, "scale"]

    @property
    def log_evidence(self) -> float:
        """Log marginal likelihood of the observed readouts. [nat]"""
        return float(np.logaddexp.reduce(self.log_weight))

    @property
    def weights(self) -> Float[Array, "scale"]:
        """Posterior weight of each pair of scales."""
        return np.asarray(np.exp(self.log_weight - np.logaddexp.reduce(self.log_weight)))

    def moments(self) -> tuple[Float[Array, "term"], Float[Array, "term"]]:
        """Posterior mean and standard deviation of every term."""
        weights, variance = self.weights, np.diagonal(np.linalg.inv(self.precision), axis1=1, axis2=2)
        mean = weights @ self.mean
        return mean, np.sqrt(weights @ (variance + (self.mean - mean) ** 2))


def scale_grid(doubtful: bool = False) -> tuple[Float[Array, "scale"], Float[Array, "scale"], Float[Array, "scale"]]:
    """Scatter scale, reading scale and log prior of every pair; `doubtful` as in `Model`."""
    scales = DOUBTED_SCALES if doubtful else READING_SCALES
    scatter, reading = np.meshgrid(SCATTER_SCALES, scales, indexing="ij")
    prior = _LOG_SCATTER_PRIOR[:, None] + (_LOG_DOUBTED_PRIOR if doubtful else _LOG_READING_PRIOR)
    prior = prior - np.logaddexp.reduce(prior.ravel())
    return scatter.ravel(), reading.ravel(), prior.ravel()


def apogee_scale(model: Model) -> Float[Array, "scale"]:
    """Errors of reading the apogee, in units of the expected: those of a doubted device are of the rest alone."""
    reading = scale_grid(model.doubtful)[1]
    return np.ones_like(reading) if model.doubtful else reading


def term_sds(model: Model) -> Float[Array, "scale term"]:
    """Standard deviation of every term before anything was flown, for every pair of scales."""
    scatter, reading, _ = scale_grid(model.doubtful)
    by = {"": np.ones_like(scatter), "scatter": scatter, "reading": reading}
    sds = [term.sd * by[term.rough] for term in model.terms]
    return np.stack(sds, axis=-1) if sds else np.empty((len(scatter), 0))


@dataclass(frozen=True, slots=True)
class Lane:
    """One of several fits made side by side: which terms of a common model it has, and where it begins.

    Of the lanes of one `kind`, those that fall far behind are not followed further.
    """

    terms: tuple[int, ...]
    start: Float[Array, "term"]
    kind: str = ""


def fit(
    model: Model,
    data: Data,
    start: Float[Array, "term"] | None = None,
    rounds: int = ROUNDS,
) -> Fit:
    """The posterior of a model given data, linearised where it ends up; `start` is where to begin.

    Without a start it is begun from several opening times of the parachute, for what that does has a kink
    where ejection meets apogee, and the best is kept.
    """
    every = tuple(range(len(model.terms)))
    at = np.array([term.mean for term in model.terms]) if start is None else np.asarray(start, float)
    starts = [at]
    if start is None and OPENING in model.names:
        place = model.names.index(OPENING)
        starts = [np.where(np.arange(len(at)) == place, seconds, at) for seconds in OPENINGS]
    fits = fit_lanes(model, data, [Lane(every, begin) for begin in starts], lean_slope(model, at), rounds)
    return max(fits, key=lambda result: result.log_evidence)


def fit_lanes(
    model: Model,
    data: Data,
    lanes: Sequence[Lane],
    lean: Float[Array, "flight readout"],
    rounds: int = ROUNDS,
    worth: float = -np.inf,
    tell: Callable[[float], None] | None = None,
) -> list[Fit]:
    """Several fits of parts of a model side by side, terms that a lane lacks being zero in it.

    A lane whose log evidence stays below `worth` is not followed further. `tell` hears the share done.
    """
    parts = [model.only(lane.terms) for lane in lanes]
    at = [np.asarray(lane.start, float) for lane in lanes]
    results: list[Fit | None] = [None] * len(lanes)
    moving = list(range(len(lanes)))
    for turn in range(rounds):
        near = tangents(model, [(lanes[i].terms, at[i]) for i in moving], lean)
        for number, (i, tangent) in enumerate(zip(moving, near, strict=True)):
            if tell:
                tell((turn + (number + 1) / len(moving)) / rounds)
            results[i] = solve(parts[i], data, tangent)
        best = _best(lanes, results)
        moving = [
            i
            for i in moving
            if (turn == 0 or _above(results[i], best[lanes[i].kind] - HOPELESS))
            and _above(results[i], worth)
            and _advance(at, i, results[i])
        ]
        if not moving:
            break
    return [result for result in results if result is not None]


def _best(lanes: Sequence[Lane], results: Sequence[Fit | None]) -> dict[str, float]:
    """The greatest log evidence so far of every kind of lane."""
    best: dict[str, float] = {}
    for lane, result in zip(lanes, results, strict=True):
        if result is not None:
            best[lane.kind] = max(result.log_evidence, best.get(lane.kind, -np.inf))
    return best


def _above(result: Fit | None, log_evidence: float) -> bool:
    return result is not None and result.log_evidence > log_evidence


def _advance(at: list[Array], lane: int, result: Fit | None) -> bool:
    """Move a lane's point towards its posterior mean; False where it is there already."""
    assert result is not None
    terms = result.model.terms
    sds = np.array([term.sd for term in terms])
    wanted = result.mean[int(np.argmax(result.log_weight))]
    target = np.clip(wanted, [term.low for term in terms], [term.high for term in terms])
    move = np.clip(target - at[lane], -2 * sds, 2 * sds)
    if np.all(np.abs(move) < 0.03 * sds):
        return False
    at[lane] = at[lane] + move
    return True


def solve(model: Model, data: Data, near: Tangent) -> Fit:
    """The normal posterior for every pair of scales, the readouts linear about a point."""
    prior_mean = np.array([term.mean for term in model.terms])
    prior_precision = 1 / term_sds(model) ** 2
    noise, usable = _noise(model, data, near)
    slope = np.where(usable[..., None], near.slope, 0.0)
    miss = np.where(usable, data.values - near.values, 0.0) + slope @ (near.at - prior_mean)
    sharpness = np.asarray(np.linalg.inv(noise), float)
    weighed = sharpness @ slope
    precision = np.einsum("fot,sfou->stu", slope, weighed, optimize=True)
    diagonal = np.arange(len(model.terms))
    precision[:, diagonal, diagonal] += prior_precision
    gain = np.einsum("fo,sfou->su", miss, weighed)
    offset = np.linalg.solve(precision, gain[..., None])[..., 0]
    _, log_det = np.linalg.slogdet(noise)
    misfit = np.einsum("fo,sfop,fp->s", miss, sharpness, miss, optimize=True) - np.einsum("st,st->s", gain, offset)
    log_terms = np.linalg.slogdet(precision)[1] - np.log(prior_precision).sum(axis=1)
    log_likelihood = -0.5 * (misfit + log_det.sum(axis=1) + log_terms)
    mean = prior_mean + offset
    cut = _log_inside(model, mean, precision)
    log_weight = log_likelihood + scale_grid(model.doubtful)[2] + cut
    return Fit(model, data, near, mean, precision, gain, noise, sharpness, log_weight)


def _noise(model: Model, data: Data, near: Tangent) -> tuple[Array, Flags]:
    """Covariance of each flight's readouts for every pair of scales, and which of them can be compared."""
    scatter_scale, reading_scale, _ = scale_grid(model.doubtful)
    usable = data.seen & np.isfinite(near.values)
    spread = np.where(usable[..., None], near.scatter_slope, 0.0)
    shared = np.einsum("fos,fps->fop", spread, spread)
    own = np.where(usable, data.sd, UNSEEN) ** 2
    scale = np.repeat(reading_scale[:, None], len(OBSERVED), axis=1)
    scale[:, 0] = apogee_scale(model)
    unit = np.where(usable, scale[:, None] ** 2, 1.0)
    diagonal = (own * unit)[..., None] * np.eye(len(OBSERVED))
    return (scatter_scale[:, None, None, None] ** 2 * shared + diagonal) / data.trust[:, None, None], usable


def _log_inside(model: Model, mean: Array, precision: Array) -> Array:
    """Log of posterior over prior mass inside the bounds of terms that have any, one term at a time."""
    bounded = [i for i, term in enumerate(model.terms) if np.isfinite(term.low) or np.isfinite(term.high)]
    total = np.zeros(len(mean))
    if not bounded:
        return total
    sds = np.sqrt(np.diagonal(np.linalg.inv(precision), axis1=1, axis2=2))
    for i in bounded:
        term = model.terms[i]
        prior = _mass(term.low, term.high, term.mean, term.sd)
        total += [
            log(max(_mass(term.low, term.high, m, s), 1e-12) / prior)
            for m, s in zip(mean[:, i], sds[:, i], strict=True)
        ]
    return total


def _mass(low: float, high: float, mean: float, sd: float) -> float:
    """Share of a normal distribution between two bounds."""
    return 0.5 * (erf((high - mean) / (sd * sqrt(2))) - erf((low - mean) / (sd * sqrt(2))))


@dataclass(frozen=True, slots=True)
class LeftOut:
    """What a fit says of each flight when that flight is left out of it.

    For every pair of scales: mean and variance of the compared apogee, and the log weight of the pair
    (times the evidence of the other flights). The variance is scaled as the others' apogees ask (`spread`).
    `distance` is how far the flight's readouts lie from what the others say of them, squared, in standard
    deviations (Mahalanobis), `residual` each readout's own distance, flown less expected.
    """

    mean: Float[Array, "scale flight"]
    variance: Float[Array, "scale flight"]
    log_weight: Float[Array, "scale flight"]
    distance: Float[Array, "scale flight"]
    residual: Float[Array, "scale flight readout"]
    spread: Spread


def leave_one_out(result: Fit) -> LeftOut:
    """Predictions of every flight from all the others, exactly as far as the readouts are linear.

    With a flight's slopes A, its noise N and the covariance P of the terms, G = A P A' is what all flights, itself
    included, leave open of its readouts. From r, the miss of the mean, follow without another solution in the terms:
    the error of the others' forecast, e = (1 - G / N)^-1 r, its inverse covariance (1 - G / N)' / N, and the mean and
    covariance of anything else that the others say (Woodbury's identity).
    """
    near, data, model = result.tangent, result.data, result.model
    usable = data.seen & np.isfinite(near.values)
    prior_mean = np.array([term.mean for term in model.terms])
    slope = np.where(usable[..., None], near.slope, 0.0)
    miss = np.where(usable, data.values - near.values, 0.0) + slope @ (near.at - prior_mean)
    covariance = np.asarray(np.linalg.inv(result.precision), float)
    offset = result.mean - prior_mean
    readouts = slope.shape[1]
    spread = slope @ covariance[:, None]
    still_open = spread @ np.swapaxes(slope, 1, 2)
    kept = np.eye(readouts) - still_open @ result.sharpness
    missed = miss - np.einsum("fot,st->sfo", slope, offset)
    error = np.linalg.solve(kept, missed[..., None])[..., 0]
    surprise = np.einsum("sfop,sfp->sfo", result.sharpness, missed)
    distance = (error * surprise).sum(axis=-1)
    others = np.linalg.solve(kept, result.noise)
    own = -0.5 * (distance + np.linalg.slogdet(others)[1])
    residual = error / np.sqrt(np.diagonal(others, axis1=2, axis2=3))
    log_weight = result.log_weight[:, None] - own

    apogee = near.slope[:, 0]
    ties = np.einsum("ft,sfot->sfo", apogee, spread)
    pulled = np.einsum("sfo,sfo->sf", ties, np.einsum("sfop,sfp->sfo", result.sharpness, error))
    mean = near.values[:, 0] + apogee @ (prior_mean - near.at) + offset @ apogee.T - pulled
    known = np.einsum("ft,stu,fu->sf", apogee, covariance, apogee, optimize=True)
    known += np.einsum("sfo,sfop,sfp->sf", ties, result.sharpness, np.linalg.solve(kept, ties[..., None])[..., 0])
    scattered = _own_variance(result)
    lies = _apogee_spread(data, mean, known, scattered, log_weight)
    variance = known + lies.mean_square_without * scattered
    return LeftOut(mean, variance, log_weight, distance, residual, lies)


def _apogee_spread(data: Data, mean: Array, known: Array, own: Array, log_weight: Array) -> Spread:
    """The scatter of apogees beside what the scales make of it, by flights left out."""
    weight = np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0))
    middle = (weight * mean).sum(axis=0)
    between = (weight * (mean - middle) ** 2).sum(axis=0)
    seen = data.seen[:, 0]
    error = np.where(seen, data.values[:, 0] - middle, 0.0)
    return apogee_spread(error, (weight * known).sum(axis=0) + between, (weight * own).sum(axis=0), seen)


def fit_robustly(model: Model, data: Data) -> Fit:
    """As `fit`, with less trust in flights that the others contradict.

    Each flight is trusted as a Student t distribution with `TAIL` degrees of freedom would: by the expected
    weight (nu + k) / (nu + d^2) of a flight with k readouts at distance d (Lange, Little and Taylor, 1989).
    Fewer than `FEWEST` flights cannot outvote one, and all are trusted.
    """
    result = fit(model, data)
    if np.count_nonzero(data.seen.any(axis=1)) < FEWEST:
        return result
    for _ in range(ROBUST_ROUNDS):
        for _ in range(TRUST_ROUNDS):
            result = solve(model, _trusted(result), result.tangent)
        result = _followed(result)
    return result


def _trusted(result: Fit) -> Data:
    """The data with every flight trusted by how well the others foretell it."""
    readouts = result.data.seen.sum(axis=1)
    distance = result.weights @ leave_one_out(result).distance
    trust = np.where(readouts > 0, (TAIL + readouts) / (TAIL + distance), 1.0)
    return replace(result.data, trust=np.clip(trust, 0.02, 1.2))


def _followed(result: Fit) -> Fit:
    """The fit linearised anew where its posterior lies; itself where that is where it was linearised."""
    at, lean = [result.tangent.at], result.tangent.scatter_slope[..., -1]
    if not _advance(at, 0, result):
        return result
    (near,) = tangents(result.model, [(tuple(range(len(at[0]))), at[0])], lean)
    return solve(result.model, result.data, near)


def _own_variance(result: Fit) -> Array:
    """Variance of a flight's compared apogee about its expectation: scatter and reading. [scale flight]"""
    scatter_scale, reading_scale = scale_grid(result.model.doubtful)[0], apogee_scale(result.model)
    spread = result.tangent.scatter_slope[:, 0]
    reading = own_reading_sd(np.exp(result.tangent.values[:, 0]))
    return np.asarray(scatter_scale[:, None] ** 2 * (spread**2).sum(axis=-1) + (reading_scale[:, None] * reading) ** 2)


def own_reading_sd(apogee: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Expected error of reading an apogee [m] off the altimeter, as a ratio."""
    raw = np.full((*apogee.shape, len(OBSERVED)), 1.0)
    raw[..., 0] = apogee
    return reading_sd(raw)[..., 0]
