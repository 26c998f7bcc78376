"""Forecasts averaged over hypotheses: leave-one-out, and of each flight from the earlier ones.

A hypothesis forecasts a flight by its fit without that flight, weighted by its probability given the other flights, so
no choice has to be repeated without each flight. Only the set of hypotheses was found with all flights.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammaincinv

from fieldkit.inference.laplace.fit import refits_without
from fieldkit.inference.laplace.importance import RELIABLE_PARETO_K
from fieldkit.inference.laplace.leave_one_out import leave_one_out, own_variance
from fieldkit.inference.laplace.posterior import growing
from fieldkit.progress import ReportProgress, no_op
from fieldkit.scoring.score import Forecasts
from fieldkit.selection.hypotheses import Hypothesis, Members, SetPosterior
from fieldkit.shapes import Array, Flags, Float

NEGLIGIBLE_PROBABILITY = 0.01
"""Minimum probability without a flight for repeating a hypothesis's fit. [1]"""
MAX_REFIT_WORK = 400
"""Maximum number of flights without which a hypothesis's fit is repeated, times the number of flights in it: all of up
to 20. With all of them, the time would grow with the square of the number of flights. For the others the readouts are
taken as linear around the fit to all flights, which one of so many hardly moves. [1]"""
TAIL_PARTS = 4
"""Normal components that approximate a Student t. [1]"""
MIN_EARLIER_FLIGHTS = 4
"""Minimum number of earlier clean flights for a forecast forward in time. [1]"""
MAX_FORWARD = 24
"""Hypotheses used forward in time. [1]"""


@dataclass(frozen=True, slots=True)
class Ahead:
    """Forecasts of every flight from the earlier ones, by the plain model and averaged.

    `seen` marks the flights with `MIN_EARLIER_FLIGHTS` before them; `chosen` is the most probable set at each flight,
    empty for none.
    """

    before: Forecasts
    after: Forecasts
    seen: Flags
    chosen: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _ByHypothesis:
    """One hypothesis's forecast of the log apogee of every flight for each scale, and its log weight."""

    mean: Float[Array, "scale flight"]
    known: Float[Array, "scale flight"]
    own: Float[Array, "scale flight"]
    weight: Float[Array, "scale flight"]
    log_weight: Float[Array, "flight"]


def left_out(posterior: SetPosterior, on_progress: ReportProgress = no_op) -> Forecasts:
    """Leave-one-out forecasts of every flight by the hypotheses, weighted without that flight, by importance sampling.

    If the importance weights are unreliable, the fit is repeated without the flight; if they are for more flights than
    `MAX_REFIT_WORK` allows, only without those with the most influence, as the shape of the weights' tail shows it.
    Raises ImpossibleFlight for a flight without a dry mass.
    """
    some = [one for one in posterior.hypotheses if one.sampled is not None]
    forecasts = [_sampled(one) for one in some]
    log_weight = np.stack([one.log_weight for one in forecasts])
    chance = np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0))
    for number, (one, own) in enumerate(zip(some, forecasts, strict=True)):
        on_progress("flights left out", number / len(some))
        assert one.sampled is not None
        k = one.sampled.pareto_k_without
        unsure = (k > RELIABLE_PARETO_K) & one.fit.data.seen.any(axis=1) & (chance[number] > NEGLIGIBLE_PROBABILITY)
        rows, most = np.flatnonzero(unsure)[np.argsort(-k[unsure], kind="stable")].tolist(), MAX_REFIT_WORK // len(k)
        if rows[most:]:
            forecasts[number] = _linear(one, own, rows[most:])
        if rows:
            forecasts[number] = _refitted(one, forecasts[number], rows[:most])
    states = [state for one, own in zip(some, forecasts, strict=True) for state in _by_state(one, own)]
    return _mixed(states, posterior.hypotheses[0].fit.model.hyperprior.tail)


def that_pay(
    before: Forecasts, after: Forecasts, truth: Float[Array, "flight"], seen: Flags, *, forward: bool = False
) -> tuple[Forecasts, bool]:
    """The averaged forecasts while they pay, the plain ones otherwise; and whether the next flight is averaged.

    They pay if the sum of their continuous ranked probability scores over flights with an apogee is not larger. If
    forecasts are `forward` in time, each flight's are chosen by the earlier ones. Otherwise all flights choose, because
    a choice by all but one is adverse: where both are nearly as good, leaving out a flight on which one of them fails
    makes that one the choice for it. The gain of one choice out of two is small. `truth` has the flown apogees. [log m]
    """
    gain = np.where(seen, before.crps(truth) - after.crps(truth), 0.0)
    pays = bool(gain.sum() >= 0)
    if not forward:
        return after if pays else before, pays
    earlier = np.cumsum(gain) - gain
    return Forecasts.pick([after if own >= 0 else before for own in earlier.tolist()]), pays


def _by_state(one: Hypothesis, forecasts: _ByHypothesis) -> list[_ByHypothesis]:
    """The forecasts of a hypothesis for each state of an effect that only a flight's own log shows.

    A forecast cannot know it, unless the flyer recorded it. Readouts are linear in the terms of the effect.
    """
    switched = next((place for place in one.places if place.switched is not None), None)
    if switched is None or switched.switched is None:
        return [forecasts]
    model, mean, slope = one.fit.model, one.fit.moments()[0], one.fit.tangent.slope[:, 0]
    known = np.array([one is not None for one in model.history.drag_switches])
    found = []
    for acts, chance in ((False, 1 - switched.switched.chance), (True, switched.switched.chance)):
        moved = np.zeros(len(model.flights))
        for row, term in enumerate(model.terms):
            if switched.has(term.name) and (own := term.weight != 0).any():
                there = float(np.mean(term.weight[own])) if acts else 0.0
                per_unit = float(np.mean(slope[own, row] / term.weight[own]) * mean[row])
                moved += (there - term.weight) * per_unit
        log_weight = forecasts.log_weight + np.log(chance)
        found.append(replace(forecasts, mean=forecasts.mean + np.where(known, 0.0, moved), log_weight=log_weight))
    return found


def _sampled(one: Hypothesis) -> _ByHypothesis:
    assert one.sampled is not None
    drawn = one.sampled
    return _ByHypothesis(drawn.mean, drawn.known, drawn.own, drawn.weight, one.log_prior + drawn.log_without)


def _refitted(one: Hypothesis, forecasts: _ByHypothesis, rows: Sequence[int]) -> _ByHypothesis:
    """Forecasts of some flights by a hypothesis from fits without each of them."""
    assert one.sampled is not None
    found, scales = [], one.sampled.scales
    for row, again in zip(rows, refits_without(one.sampled.fit, rows, scales), strict=True):
        apogee = again.tangent.slope[row, 0]
        mean = again.tangent.values[row, 0] + (again.mean - again.tangent.at) @ apogee
        known = np.einsum("t,stu,u->s", apogee, again.covariance, apogee)
        found.append((mean, known, own_variance(again)[scales, row], again.log_weight))
    return _with_flights(one, forecasts, rows, [np.stack(part, axis=-1) for part in zip(*found, strict=True)])


def _linear(one: Hypothesis, forecasts: _ByHypothesis, rows: Sequence[int]) -> _ByHypothesis:
    """As `_refitted`, with readouts that are linear around the fit to all flights."""
    assert one.sampled is not None
    found, own, scales = leave_one_out(one.sampled.fit), own_variance(one.sampled.fit), one.sampled.scales
    parts = [part[scales][:, rows] for part in (found.mean, found.known, own, found.log_weight)]
    return _with_flights(one, forecasts, rows, parts)


def _with_flights(
    one: Hypothesis, forecasts: _ByHypothesis, rows: Sequence[int], parts: Sequence[Float[Array, "scale some"]]
) -> _ByHypothesis:
    """The forecasts with those of some flights replaced: their mean, both variances, and the log weight of each of the
    scales in the sum."""
    assert one.sampled is not None
    *normal, log_scale = parts
    total = np.logaddexp.reduce(log_scale, axis=0)
    columns = [whole.copy() for whole in (forecasts.mean, forecasts.known, forecasts.own, forecasts.weight)]
    for column, part in zip(columns, (*normal, np.exp(log_scale - total)), strict=True):
        column[:, rows] = part
    log_weight, known_fit = (
        forecasts.log_weight.copy(),
        np.logaddexp.reduce(one.sampled.fit.log_weight[one.sampled.scales]),
    )
    log_weight[rows] = one.log_prior + one.sampled.log_evidence - known_fit + total
    mean, known, own, weight = columns
    return _ByHypothesis(mean, known, own, weight, log_weight)


def _mixed(forecasts: Sequence[_ByHypothesis], tail: float) -> Forecasts:
    """The mixture of the forecasts of all hypotheses, with Student t scatter of single flights."""
    precision = gammaincinv(tail / 2, (np.arange(TAIL_PARTS) + 0.5) / TAIL_PARTS) / (tail / 2)
    log_weight = np.stack([one.log_weight for one in forecasts])
    chance = np.exp(log_weight - np.logaddexp.reduce(log_weight, axis=0))
    means, variances, weights = [], [], []
    for one, own_chance in zip(forecasts, chance, strict=True):
        for factor in precision:
            means.append(one.mean)
            variances.append(one.known + one.own / factor)
            weights.append(own_chance * one.weight / TAIL_PARTS)
    weight = np.concatenate(weights)
    return Forecasts(np.concatenate(means), np.sqrt(np.concatenate(variances)), weight / weight.sum(axis=0))


def ahead(posterior: SetPosterior, on_progress: ReportProgress = no_op) -> Ahead:
    """Forecasts of every flight from the earlier ones by the most probable hypotheses, weighted by the earlier flights
    alone.

    The points of linearization, the weights of outlier flights and the set of hypotheses come from all flights.
    """
    some = _followed(posterior)
    forecasts = []
    for number, one in enumerate(some):
        on_progress("forward in time", number / len(some))
        forecasts.append(_grown(one))
    plain = next(number for number, one in enumerate(some) if not one.candidates)
    fit = some[plain].fit
    used = fit.data.seen[:, 0]
    judged = used & (np.concatenate([[0], np.cumsum(used)[:-1]]) >= MIN_EARLIER_FLIGHTS)
    tail = fit.model.hyperprior.tail
    states = [state for one, own in zip(some, forecasts, strict=True) for state in _by_state(one, own)]
    chosen = tuple(name if there else "" for name, there in zip(_most_probable(some, forecasts), judged, strict=True))
    before = _mixed([forecasts[plain]], tail)
    after, _ = that_pay(before, _mixed(states, tail), fit.data.values[:, 0], judged, forward=True)
    return Ahead(before, after, judged, chosen)


def _followed(posterior: SetPosterior) -> list[Hypothesis]:
    """The plain model, the best place of every set of one effect, and the most probable others."""
    order = sorted(posterior.hypotheses, key=lambda one: -one.log_weight)
    first: dict[Members, Hypothesis] = {}
    for one in order:
        if len(one.members) < 2:
            first.setdefault(one.members, one)
    kept = list(first.values())[:MAX_FORWARD]
    return [*kept, *(one for one in order if one not in kept)][: max(MAX_FORWARD, len(kept))]


def _grown(one: Hypothesis) -> _ByHypothesis:
    """A hypothesis's forecast of every flight from the earlier flights."""
    grown, near = growing(one.fit), one.fit.tangent
    apogee = near.slope[:, 0]
    mean = near.values[:, 0] + np.einsum("ft,sft->sf", apogee, grown.mean - near.at)
    known = np.einsum("ft,sftu,fu->sf", apogee, grown.covariance, apogee, optimize=True)
    total = np.logaddexp.reduce(grown.log_weight, axis=0)
    return _ByHypothesis(mean, known, own_variance(one.fit), np.exp(grown.log_weight - total), one.log_prior + total)


def _most_probable(some: Sequence[Hypothesis], forecasts: Sequence[_ByHypothesis]) -> tuple[str, ...]:
    """The name of the most probable set at each flight."""
    by_set: dict[Members, Array] = {}
    for one, own in zip(some, forecasts, strict=True):
        by_set[one.members] = np.logaddexp(by_set.get(one.members, -np.inf), own.log_weight)
    names = ["+".join(sorted(members)) for members in by_set]
    return tuple(names[row] for row in np.argmax(np.stack(list(by_set.values())), axis=0))
