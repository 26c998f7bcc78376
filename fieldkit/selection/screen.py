"""Screening of an effect's places before a fit, with readouts linear around a smaller model.

An effect is simulated once for each start, acting on every flight. In a place it acts on some of them, by their
weights, and the change in evidence follows in closed form from the smaller model's fit (a normal linear model with a
few more parameters; Bishop, Pattern Recognition and Machine Learning, 2006, section 3.5). So more places cost
multiplications, not simulations.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.laplace.linearization import Tangent, tangents
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import Term
from fieldkit.physics.effect import Effect
from fieldkit.selection.candidates import Candidate, Place
from fieldkit.shapes import Array, Float

PLACE_WINDOW = 3.0
"""Places of an effect below these log posterior odds against the best (one in twenty) are not fitted. [nat]"""
NEGLIGIBLE_SCALE_WEIGHT = 1e-4
"""Pairs of scales below this posterior weight are left out. [1]"""
MAX_PLACES = 4
"""Maximum number of places of an effect to fit. [1]"""

Columns = Mapping[tuple[int, float], tuple[Float[Array, "flight readout"], Float[Array, "flight readout"]]]
"""By effect and start: the shift of the readouts by the effect, and their derivative with respect to its strength."""


@dataclass(frozen=True, slots=True)
class Screened:
    """The candidates of every effect to fit, each with its promising starts.

    `steps` are the readouts around each of these starts, by place, from the smaller model and the separate simulation
    of the effect, so that the first step of a fit needs no further simulations.
    """

    families: dict[str, list[Candidate]]
    steps: dict[tuple[Place, float], Tangent]


def screened(
    families: Mapping[str, Sequence[Candidate]], near: Fit, worth: Mapping[str, float] | None = None
) -> Screened:
    """The candidates to fit.

    The prior of omitted places is added to the fitted ones in proportion to their probability. Effects whose log Bayes
    factor against the model is below their `worth` are left out.
    """
    columns = _columns(families, near)
    found = {}
    for name, family in families.items():
        scored = [_scored(one, columns, near) for one in family]
        whole = np.logaddexp.reduce([score for score, _ in scored])
        if worth is None or whole > worth.get(name, -np.inf):
            found[name] = _worth_a_fit(scored, float(whole))
    kept = [one for family in found.values() for one in family]
    return Screened(
        found, {(one.place, start): _about(one, start, columns, near) for one in kept for start in one.starts}
    )


def _about(one: Candidate, start: float, columns: Columns, near: Fit) -> Tangent:
    """The readouts around a start of a candidate, based on the smaller model's."""
    slope, shift = _added(one, start, columns, near)
    base = near.tangent
    at = np.concatenate([base.at, _begins(one, start)])
    return Tangent(at, base.values + shift, np.concatenate([base.slope, slope], axis=-1), base.scatter_slope)


def _worth_a_fit(family: Sequence[tuple[float, Candidate]], whole: float) -> list[Candidate]:
    order = sorted(family, key=lambda pair: -pair[0])
    kept = [(score, one) for score, one in order if score > order[0][0] - PLACE_WINDOW][:MAX_PLACES]
    others = whole - float(np.logaddexp.reduce([score for score, _ in kept]))
    return [replace(one, log_share=one.log_share + others) for _, one in kept]


def _columns(families: Mapping[str, Sequence[Candidate]], near: Fit) -> Columns:
    """Simulations of every effect at each of its starts, acting fully on every flight."""
    model, base = near.model, tuple(range(len(near.model.terms)))
    wide, lanes, keys = model, [], []
    wanted: dict[int, tuple[Term, tuple[float, ...]]] = {}
    for family in families.values():
        for one in family:
            if isinstance(bends := one.terms[0].bends, Effect):
                wanted.setdefault(id(bends), (one.terms[0], one.starts))
    for key, (term, starts) in wanted.items():
        lacks = isinstance(term.bends, Effect) and term.bends.lacks
        every = (term.weight != 0).astype(float) if lacks else np.ones(len(model.flights))
        wide = wide.with_terms(replace(term, weight=every))
        for start in starts:
            lanes.append(((*base, len(wide.terms) - 1), np.array([*near.tangent.at, start])))
            keys.append((key, start))
    found = tangents(wide, lanes, near.tangent.scatter_slope[..., -1]) if lanes else []
    return {key: _moved(tangent, near) for key, tangent in zip(keys, found, strict=True)}


def _moved(tangent: Tangent, near: Fit) -> tuple[Array, Array]:
    usable = near.data.seen & np.isfinite(near.tangent.values)
    shift = np.where(usable, np.nan_to_num(tangent.values - near.tangent.values), 0.0)
    return shift, np.where(usable, tangent.slope[..., -1], 0.0)


def _scored(one: Candidate, columns: Columns, near: Fit) -> tuple[float, Candidate]:
    """A candidate's log posterior weight from its best start, up to a constant of its family, and the starts to
    keep."""
    scores = [_gain(one, *_added(one, start, columns, near), start, near) + one.log_share for start in one.starts]
    kept = [start for start, score in zip(one.starts, scores, strict=True) if score > max(scores) - PLACE_WINDOW]
    return max(scores), replace(one, starts=tuple(kept))


def _added(
    one: Candidate, start: float, columns: Columns, near: Fit
) -> tuple[Float[Array, "flight readout own"], Float[Array, "flight readout"]]:
    """A candidate's effect on the readouts around a start: the derivatives with respect to its terms, and the shift."""
    bends = one.terms[0].bends
    if not isinstance(bends, Effect):
        slope = np.stack([_plain_slope(term, near) for term in one.terms], axis=-1)
        return slope, np.zeros(slope.shape[:2])
    shift, own = columns[id(bends), start]
    weight = np.stack([term.weight for term in one.terms], axis=-1)
    return own[..., None] * weight[:, None, :], shift * weight.sum(axis=-1)[:, None]


def _begins(one: Candidate, start: float) -> Float[Array, "own"]:
    """The terms of a candidate at a start: strengths of an effect all at the start, those of a pattern at their
    mean."""
    if all(isinstance(term.bends, Effect) for term in one.terms):
        return np.full(len(one.terms), start)
    return np.array([start, *(term.mean for term in one.terms[1:])])


def _plain_slope(term: Term, near: Fit) -> Float[Array, "flight readout"]:
    """The effect of a unit of a term that acts on the same property as a term of the plain model on every flight."""
    usable = near.data.seen & np.isfinite(near.tangent.values)
    if term.bends in OBSERVED_READOUTS:
        return np.where(usable, term.weight[:, None] * (np.array(OBSERVED_READOUTS) == term.bends), 0.0)
    row = next(i for i, own in enumerate(near.model.terms) if own.bends == term.bends and np.all(own.weight == 1))
    return np.where(usable, near.tangent.slope[..., row] * term.weight[:, None], 0.0)


def _gain(
    one: Candidate,
    slope: Float[Array, "flight readout own"],
    shift: Float[Array, "flight readout"],
    start: float,
    near: Fit,
) -> float:
    """Log Bayes factor of a model with the candidate against the one without, for linear readouts. [nat]

    Around the start `x0` the readouts are the smaller model's plus `shift + slope (x - x0)`.
    """
    scales = np.flatnonzero(near.weights > NEGLIGIBLE_SCALE_WEIGHT)
    told, covariance, sharpness = near.told, near.covariance[scales], near.told.sharpness[scales]
    own_mean = np.array([term.mean for term in one.terms])
    expected = shift + slope @ (own_mean - _begins(one, start))
    weighed = sharpness @ slope  # scale flight readout own
    ties = np.einsum("fot,sfok->stk", told.slope, weighed, optimize=True)
    miss = told.miss - expected
    before, _ = _left(told.miss, sharpness, told.slope, covariance)
    after, moved = _left(miss, sharpness, told.slope, covariance)
    score = np.einsum("sfok,fo->sk", weighed, miss) - np.einsum("stk,st->sk", ties, moved)
    explained = np.einsum("stk,stu,sul->skl", ties, covariance, ties, optimize=True)
    information = np.einsum("fok,sfol->skl", slope, weighed, optimize=True) - explained
    precision = information + np.diag([1 / term.sd**2 for term in one.terms])
    raised = (score * np.linalg.solve(precision, score[..., None])[..., 0]).sum(axis=1)
    log_det = np.linalg.slogdet(precision)[1] + 2 * sum(np.log(term.sd) for term in one.terms)
    gain = 0.5 * (before - after + raised - log_det)
    return float(np.logaddexp.reduce(near.log_weight[scales] + gain) - near.log_evidence)


def _left(miss: Array, sharpness: Array, slope: Array, covariance: Array) -> tuple[Array, Array]:
    """Squared standardized residuals after the smaller model's terms are refitted, and the shift of its terms."""
    weighed = (sharpness @ miss[..., None])[..., 0]
    pull = weighed.reshape(len(weighed), -1) @ slope.reshape(miss.size, -1)
    moved = (covariance @ pull[..., None])[..., 0]
    return (miss * weighed).sum(axis=(1, 2)) - (pull * moved).sum(axis=1), moved
