"""Screening of an effect's places before a fit, with readouts linear around a smaller model.

An effect is simulated once for each start, acting on every flight. In a place it acts on some of them, by their
weights, and the change in evidence follows in closed form from the smaller model's fit. So
more places cost multiplications, not simulations. Derivation: `fieldkit.inference.evidence`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.evidence import normal_posterior
from fieldkit.inference.laplace.linearization import Tangent, known_angle_slope, tangents
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

Columns = Mapping[tuple[Effect, float], tuple[Float[Array, "flight readout"], Float[Array, "flight readout"]]]
"""By effect and start: the shift of the readouts by the effect, and their derivative with respect to its strength."""


@dataclass(frozen=True, slots=True)
class Screened:
    """The candidates of every effect to fit, each with its promising starts.

    `steps` are the readouts around each of these starts, by place, from the smaller model and the separate simulation
    of the effect, so that the first step of a fit needs no further simulations. `columns` are these simulations.
    """

    families: dict[str, list[Candidate]]
    steps: dict[tuple[Place, float], Tangent]
    columns: Columns


def screened(
    families: Mapping[str, Sequence[Candidate]], near: Fit, worth: Mapping[str, float] | None = None
) -> Screened:
    """The candidates to fit.

    The prior of omitted places is added to the fitted ones in proportion to their probability. Effects whose log Bayes
    factor against the model is below their `worth` are left out. Raises ImpossibleFlight for a flight without a dry
    mass.
    """
    columns = _columns(families, near)
    found = {}
    for name, family in families.items():
        scored = _scored(family, columns, near)
        whole = np.logaddexp.reduce([score for score, _ in scored])
        if worth is None or whole > worth.get(name, -np.inf):
            found[name] = _worth_a_fit(scored, float(whole))
    kept = [one for family in found.values() for one in family]
    steps = {(one.place, start): _about(one, start, columns, near) for one in kept for start in one.starts}
    return Screened(found, steps, columns)


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
    return [replace(one, log_fraction=one.log_fraction + others) for _, one in kept]


def _columns(families: Mapping[str, Sequence[Candidate]], near: Fit) -> Columns:
    """Simulations of every effect at each of its starts, acting fully on every flight on which it can act."""
    model, base = near.model, tuple(range(len(near.model.terms)))
    wide, lanes, keys = model, [], []
    wanted: dict[Effect, tuple[Term, tuple[float, ...]]] = {}
    for family in families.values():
        for one in family:
            if isinstance(bends := one.terms[0].bends, Effect):
                wanted.setdefault(bends, (one.terms[0], one.starts))
    for effect, (term, starts) in wanted.items():
        blank = np.isnan(model.recorded(effect.lacks)) if effect.lacks else np.ones(len(model.flights))
        every = blank.astype(float)
        wide = wide.with_terms(replace(term, weight=every))
        for start in starts:
            lanes.append(((*base, len(wide.terms) - 1), np.array([*near.tangent.at, start])))
            keys.append((effect, start))
    found = tangents(wide, lanes, known_angle_slope(near.model, near.tangent)) if lanes else []
    return {key: _moved(tangent, near) for key, tangent in zip(keys, found, strict=True)}


def _moved(tangent: Tangent, near: Fit) -> tuple[Array, Array]:
    usable = near.data.seen & np.isfinite(near.tangent.values)
    shift = np.where(usable, np.nan_to_num(tangent.values - near.tangent.values), 0.0)
    return shift, np.where(usable, tangent.slope[..., -1], 0.0)


def _scored(family: Sequence[Candidate], columns: Columns, near: Fit) -> list[tuple[float, Candidate]]:
    """Every candidate's log posterior weight from its best start, up to a constant of its family, with the starts to
    keep."""
    pairs = [(one, start) for one in family for start in one.starts]
    gains = iter(_gains(pairs, columns, near).tolist())
    found = []
    for one in family:
        scores = [next(gains) + one.log_fraction for _ in one.starts]
        kept = [start for start, score in zip(one.starts, scores, strict=True) if score > max(scores) - PLACE_WINDOW]
        found.append((max(scores), replace(one, starts=tuple(kept))))
    return found


def _added(
    one: Candidate, start: float, columns: Columns, near: Fit
) -> tuple[Float[Array, "flight readout own"], Float[Array, "flight readout"]]:
    """A candidate's effect on the readouts around a start: the derivatives with respect to its terms, and the shift."""
    slopes, total = [], np.zeros(near.tangent.values.shape)
    for term in one.terms:
        if not isinstance(term.bends, Effect):
            slopes.append(_plain_slope(term, near))
            continue
        shift, own = columns[term.bends, start]
        slopes.append(own * term.weight[:, None])
        total = total + shift * term.weight[:, None]
    return np.stack(slopes, axis=-1), total


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


def _gains(pairs: Sequence[tuple[Candidate, float]], columns: Columns, near: Fit) -> Float[Array, "pair"]:
    """Log Bayes factors of models with a candidate, around a start each, against the one without. [nat]"""
    found = np.empty(len(pairs))
    counts = np.array([len(one.terms) for one, _ in pairs])
    for count in np.unique(counts):
        rows = np.flatnonzero(counts == count).tolist()
        found[rows] = _gains_of_size([pairs[row] for row in rows], columns, near)
    return found


def _gains_of_size(pairs: Sequence[tuple[Candidate, float]], columns: Columns, near: Fit) -> Float[Array, "pair"]:
    """As `_gains`, for candidates with the same number of terms (`own`) and readouts that are linear in them.

    Around the start `x0` the readouts are the smaller model's plus `shift + slope (x - x0)`.
    """
    scales = np.flatnonzero(near.weights > NEGLIGIBLE_SCALE_WEIGHT)
    linear, evidence = near.linear(scales), near.evidence
    slope, expected = stacked(pairs, columns, near)
    count, own = slope.shape[2:]
    known = linear.regressors(evidence.miss[..., None])
    left = linear.regressors(evidence.miss[..., None] - expected)
    flat = linear.regressors(slope.reshape(*slope.shape[:2], count * own))
    parts = [flat.every(i, own) for i in range(own)]
    score = np.stack([part.products(left) for part in parts], axis=-1)
    information = np.stack([np.stack([one.products(other) for other in parts], axis=-1) for one in parts], axis=-1)
    sds = np.array([[term.sd for term in one.terms] for one, _ in pairs])
    raised = normal_posterior(information, score, np.eye(own) / sds[:, None] ** 2, -2 * np.log(sds).sum(axis=-1))
    gain = 0.5 * (known.products(known) - left.products(left)) + raised.log_bayes
    return np.asarray(np.logaddexp.reduce(near.log_weight[scales, None] + gain, axis=0) - near.log_evidence)


def stacked(
    pairs: Sequence[tuple[Candidate, float]], columns: Columns, near: Fit
) -> tuple[Float[Array, "flight used pair own"], Float[Array, "flight used pair"]]:
    """The derivatives of the used readouts with respect to the terms of each candidate, and their shift at the means of
    those terms."""
    used, slopes, shifts = near.evidence.readouts, [], []
    for one, start in pairs:
        slope, shift = _added(one, start, columns, near)
        away = np.array([term.mean for term in one.terms]) - _begins(one, start)
        slopes.append(slope[:, used])
        shifts.append(shift[:, used] + slopes[-1] @ away)
    return np.stack(slopes, axis=2), np.stack(shifts, axis=2)
