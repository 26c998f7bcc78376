"""Fit a model to flights: move the point of linearization to the posterior mean.

Derivatives are finite differences of the simulator, computed in one batch. A few Gauss-Newton steps move the point.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.laplace.damped_steps import DampedSteps
from fieldkit.inference.laplace.linearization import Tangent, known_angle_slope, launch_angle_slope, tangents
from fieldkit.inference.laplace.one_offs import one_offs
from fieldkit.inference.laplace.outlier_flights import log_tail
from fieldkit.inference.laplace.outlier_weights import flight_weights, outlier_weights
from fieldkit.inference.laplace.posterior import Fit, probable_scales, solve
from fieldkit.inference.laplace.scale_grids import around_mode
from fieldkit.model.causes import signatures
from fieldkit.model.readout_data import Data
from fieldkit.model.rocket_model import OPENING, Model
from fieldkit.shapes import Array, Float, Int, Integers

ROUNDS = 5
"""Maximum number of Gauss-Newton steps."""
MAX_LOG_EVIDENCE_BEHIND = 8.0
"""A fit is abandoned if its log evidence is this far below the best of the fits run together. [nat]"""
DISTINCT_STEP = 1e-4
"""Minimum difference of a term between two distinct points. [1]"""
OPENINGS = (0.15, 0.6, 1.2)
"""Opening times from which a fit starts. [s]"""
ROBUST_ROUNDS = 2
"""Maximum number of steps after the weights of outliers have converged."""
ONE_OFF_FITS, ONE_OFF_ROUNDS = 2, 2
"""Maximum number of points at which flights are weighted by their probability of being usual ones, and number of
updates of the weights at each. [1]"""
MIN_CHANGE_PROBABILITY = 0.5
"""Probability of a lasting change from which the later flights alone are the usual ones. [1]"""
TRUST_ROUNDS = 4
"""Number of updates of the outliers' weights at one point."""
REFIT_ROUNDS = 4
"""Number of steps of a leave-one-out fit from the point of the full fit."""
PARALLEL_REFITS = 4
"""Number of leave-one-out fits in memory at a time. [1]"""
FLIGHT_WEIGHT_ROUNDS = 1
"""Number of updates of the outlier flights' weights at the first point."""
FLIGHT_WEIGHT_TOLERANCE = 0.15
"""Convergence tolerance of the log weight of a flight; the bound, which is stationary there, is then within 0.01 nat.
[1]"""
MAX_SETTLING_ROUNDS = 4
"""Maximum number of updates of these weights at the last point."""


@dataclass(frozen=True, slots=True)
class Lane:
    """One of several parallel fits: its terms of a common model and its starting point.

    Lanes far behind the best of their `kind` are abandoned. `near` is a known linearization at `start`, which saves the
    simulations of the first step.
    """

    terms: tuple[int, ...]
    start: Float[Array, "term"]
    kind: str = ""
    near: Tangent | None = None


def fit(
    model: Model,
    data: Data,
    start: Float[Array, "term"] | None = None,
    rounds: int = ROUNDS,
    *,
    near: bool = False,
    outlier_flights: bool = False,
) -> Fit:
    """The posterior of a model given data, linearized at its mean; `start` is the starting point, in the units of the
    terms.

    Without one, the best of several fits from different opening times of the parachute is returned, because readouts
    have a kink when ejection is at apogee. With `near`, the fit converges to the tolerance of a forecast. With
    `outlier_flights`, the noise of single flights follows a Student t. Raises ImpossibleFlight for a flight without a
    dry mass.
    """
    every = tuple(range(len(model.terms)))
    at = np.array([term.mean for term in model.terms]) if start is None else np.asarray(start, float)
    starts = [at]
    if start is None and OPENING in model.names:
        place = model.names.index(OPENING)
        starts = [np.where(np.arange(len(at)) == place, seconds, at) for seconds in OPENINGS]
    lanes = [Lane(every, begin) for begin in starts]
    weight = np.ones(len(data.seen)) if outlier_flights else None
    fits = fit_lanes(model, data, lanes, launch_angle_slope(model, at), rounds, near=near, flight_weight=weight)
    return max(fits, key=lambda result: result.log_evidence)


def fit_lanes(
    model: Model,
    data: Data,
    lanes: Sequence[Lane],
    angle_slope: Float[Array, "flight readout"],
    rounds: int = ROUNDS,
    on_progress: Callable[[float], None] | None = None,
    *,
    near: bool = False,
    flight_weight: Float[Array, "flight"] | None = None,
    scales: Int[Integers, "scale"] | None = None,
) -> Iterator[Fit]:
    """Several fits of parts of a model in parallel, in the order of their lanes; terms that a lane lacks are zero in
    it.

    `angle_slope` is from `launch_angle_slope`. `on_progress` is called with the fraction done. With an initial
    `flight_weight` [1], the noise of single flights follows a Student t. `scales` are the scales that matter at the
    first point, by default all. Raises ImpossibleFlight for a flight without a dry mass.
    """
    parts = [model.only(lane.terms) for lane in lanes]
    walks = [DampedSteps(np.asarray(lane.start, float)) for lane in lanes]
    results: list[Fit | None] = [None] * len(lanes)
    moving = list(range(len(lanes)))
    joined: dict[int, int] = {}
    first = -1 if all(lane.near for lane in lanes) else 0
    for turn in range(first, rounds):
        along = [lane.near for lane in lanes if lane.near]
        if turn >= 0:
            along = tangents(model, [(lanes[i].terms, walks[i].at) for i in moving], angle_slope)
        for number, (i, tangent) in enumerate(zip(moving, along, strict=True)):
            if on_progress:
                on_progress((turn - first + (number + 1) / len(moving)) / (rounds - first))
            known = results[i]
            if known is None:
                results[i] = _first_fit(parts[i], data, tangent, flight_weight, scales)
            else:
                results[i] = _moved(known, tangent)
        best = _best(lanes, results)
        moving = [
            i
            for i in moving
            if (turn <= 0 or _above(results[i], best[lanes[i].kind] - MAX_LOG_EVIDENCE_BEHIND))
            and (walks[i].advance(results[i], near=near) or turn < 0)
        ]
        joined |= _joined(lanes, walks, moving)
        moving = [i for i in moving if i not in joined]
        if not moving:
            break
    return _each_settled(results, joined)


def _each_settled(results: list[Fit | None], joined: Mapping[int, int]) -> Iterator[Fit]:
    """The settled fit of every lane, one at a time: those of a search would take much memory together."""
    shared: dict[int, Fit] = {}
    for lane, result in enumerate(results):
        results[lane] = None
        if lane in joined:
            found = shared[joined[lane]]  # an earlier lane
        elif result is not None:
            found = _settled(result)
        else:
            continue
        if lane in joined.values():
            shared[lane] = found
        yield found


def _first_fit(
    model: Model,
    data: Data,
    tangent: Tangent,
    flight_weight: Float[Array, "flight"] | None,
    scales: Int[Integers, "scale"] | None,
) -> Fit:
    """The posterior at the first point, after a few updates of the weights of outlier flights."""
    found = solve(model, data, tangent, flight_weight, scales)
    for _ in range(FLIGHT_WEIGHT_ROUNDS if flight_weight is not None else 0):
        found = _moved(found, tangent)
    return found


def _moved(known: Fit, tangent: Tangent) -> Fit:
    """The posterior at another point, with only the scales that matter."""
    weight = None if known.flight_weight is None else flight_weights(known)
    return solve(known.model, known.data, tangent, weight, probable_scales(known))


def _settled(result: Fit, scales: Int[Integers, "scale"] | None = None) -> Fit:
    """The fit with converged weights of outlier flights and all pairs of scales, or `scales`."""
    for _ in range(MAX_SETTLING_ROUNDS):
        if result.flight_weight is None:
            break
        weight = flight_weights(result)
        if np.max(np.abs(np.log(weight / result.flight_weight)), initial=0.0) < FLIGHT_WEIGHT_TOLERANCE:
            break
        result = solve(result.model, result.data, result.tangent, weight, probable_scales(result))
    if result.scales is None and scales is None:
        return result
    return solve(result.model, result.data, result.tangent, result.flight_weight, scales)


def _joined(lanes: Sequence[Lane], walks: Sequence[DampedSteps], moving: Sequence[int]) -> dict[int, int]:
    """Lanes at the same point as an earlier lane with the same terms, each with that lane: both would take the same
    steps."""
    first: dict[tuple[object, ...], int] = {}
    places = {i: (lanes[i].terms, lanes[i].kind, *np.round(walks[i].at / DISTINCT_STEP).tolist()) for i in moving}
    return {i: first[place] for i, place in places.items() if first.setdefault(place, i) != i}


def _best(lanes: Sequence[Lane], results: Sequence[Fit | None]) -> dict[str, float]:
    """The highest log evidence so far for every kind of lane."""
    best: dict[str, float] = {}
    for lane, result in zip(lanes, results, strict=True):
        if result is not None:
            best[lane.kind] = max(result.log_evidence, best.get(lane.kind, -np.inf))
    return best


def _above(result: Fit | None, log_evidence: float) -> bool:
    return result is not None and result.log_evidence > log_evidence


def refits_without(whole: Fit, rows: Sequence[int], scales: Int[Integers, "scale"] | None = None) -> Iterator[Fit]:
    """Fits without each of some flights, a few in parallel, starting from the fit to all of them, for some pairs of
    scales (by default all). Raises ImpossibleFlight for a flight without a dry mass."""
    for begin in range(0, len(rows), PARALLEL_REFITS):
        yield from _refits_together(whole, rows[begin : begin + PARALLEL_REFITS], scales)


def _refits_together(whole: Fit, rows: Sequence[int], scales: Int[Integers, "scale"] | None) -> Iterator[Fit]:
    every = tuple(range(len(whole.model.terms)))
    angle_slope = known_angle_slope(whole.model, whole.tangent)
    likely = probable_scales(whole)
    found = [solve(whole.model, _unseen(whole.data, row), whole.tangent, whole.flight_weight, likely) for row in rows]
    walks = [DampedSteps(whole.tangent.at) for _ in rows]
    moving = list(range(len(rows)))
    for _ in range(REFIT_ROUNDS):
        moving = [i for i in moving if walks[i].advance(found[i])]
        if not moving:
            break
        for i, tangent in zip(
            moving, tangents(whole.model, [(every, walks[i].at) for i in moving], angle_slope), strict=True
        ):
            found[i] = _moved(found[i], tangent)
    return (_settled(one, scales) for one in found)


def _unseen(data: Data, row: int) -> Data:
    """Data without a flight."""
    seen = data.seen.copy()
    seen[row] = False
    return replace(data, seen=seen)


def fit_robustly(model: Model, data: Data, *, causes: bool = False) -> Fit:
    """As `fit`, with a Student t instead of a normal distribution for each residual, so that outliers count less.

    A Student t is a normal whose precision is Gamma distributed; the factors are integrated by variational Bayes, for
    each residual separately from the terms: the expected precision of one with k = 1 is (nu + 1) / (nu + E[e^2] /
    variance) (Lange, Little and Taylor, 1989; Bishop, 2006, section 10.1). A residual is the part of a readout that
    terms and scatter do not explain, so a misread peak does not make its flight's apogee an outlier. The log evidence
    is a lower bound. With `causes`, every flight has the weight of its probability of being one of the rocket's usual
    ones (`fieldkit.inference.laplace.one_offs`). The result has finer grids of scales than the fit. Raises
    ImpossibleFlight for a flight without a dry mass.
    """
    result = fit(model, data, near=True)
    for _ in range(ROBUST_ROUNDS):
        for _ in range(TRUST_ROUNDS):
            result = solve(model, replace(data, trust=outlier_weights(result)), result.tangent)
        result = _followed(result)
    mixture = np.zeros(len(data.seen))
    if causes:
        result, mixture = _without_one_offs(result)
    fine = _finely(result, documents=True)
    return _bounded(replace(fine, log_weight=fine.log_weight + mixture.sum()))


def _finely(result: Fit, *, documents: bool) -> Fit:
    """The fit with finer grids of scales, that of documents only if `documents`."""
    model = result.model
    if model.hyperprior.motors:
        return around_mode(result, documents=documents)
    return solve(replace(model, hyperprior=model.hyperprior.refined()), result.data, result.tangent)


def _without_one_offs(result: Fit) -> tuple[Fit, Float[Array, "flight"]]:
    """The fit with flights weighted by their probability of being usual ones, and what each adds to the log evidence.
    [nat]"""
    for _ in range(ONE_OFF_FITS):
        result = _finely(result, documents=False)  # how much flights scatter decides which of them are unusual
        known = signatures(result.model, result.tangent.at, result.tangent.values, result.data.seen)
        for _ in range(ONE_OFF_ROUNDS):
            found = one_offs(result, known=known)
            data = replace(result.data, normal=found.weight)
            result = solve(result.model, data, result.tangent)
            result = solve(result.model, replace(data, trust=outlier_weights(result)), result.tangent)
            if found.changed > MIN_CHANGE_PROBABILITY:
                return _followed(result), found.log_mixture
        moved = _followed(result)
        if moved is result:
            break
        result = moved
    return result, found.log_mixture


def robust_at(model: Model, data: Data, near: Tangent) -> Fit:
    """As `fit_robustly`, linear around a known point: the weights of outliers are found there, without simulations."""
    result = solve(model, data, near)
    for _ in range(TRUST_ROUNDS):
        result = solve(model, replace(data, trust=outlier_weights(result)), near)
    return _bounded(result)


def _bounded(result: Fit) -> Fit:
    """The fit with the lower bound of the log evidence of Student t residuals, in place of that of normal residuals
    with the outliers' variances."""
    data = result.data
    compared = np.isfinite(result.tangent.values) & data.seen
    tail = log_tail(data.trust.ravel(), compared.ravel().astype(int), result.model.hyperprior.tail)
    return replace(result, log_weight=result.log_weight + tail.sum())


def _followed(result: Fit) -> Fit:
    """The fit relinearized at its posterior mean, or the fit itself if it is linearized there."""
    walk, angle_slope = DampedSteps(result.tangent.at), known_angle_slope(result.model, result.tangent)
    if not walk.advance(result, near=True):
        return result
    (near,) = tangents(result.model, [(tuple(range(len(walk.at))), walk.at)], angle_slope)
    return solve(result.model, result.data, near)
