"""The quick search for missing effects of a rocket, from one linear pass.

Probabilities, strengths and leave-one-out errors are closed forms, with each effect in its most probable place; no fit
has checked them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.plan import repeated
from fieldkit.inference.history.effect_probabilities import EffectProbabilities, effect_probabilities, families
from fieldkit.inference.history.evidence import Trials
from fieldkit.inference.history.quick_forecast import PreparedHistory, QuickAnswer, acting, answers, centered, modeled
from fieldkit.inference.history.response import reference
from fieldkit.inference.laplace.leave_one_out import leave_one_out
from fieldkit.inference.laplace.posterior import solve, used_readouts
from fieldkit.messages import estimate, message
from fieldkit.model.scale import scale_grid
from fieldkit.motors import Found
from fieldkit.physics.effect import Effect
from fieldkit.physics.history import flown_and_planned
from fieldkit.scoring.score import Score, forecasts_of, score
from fieldkit.selection.candidates import Candidate
from fieldkit.selection.prior import UNEXPLAINED, inclusion_probabilities
from fieldkit.selection.quick_candidates import quick_candidates
from fieldkit.selection.verdict import MATCH_PROBABILITY, MAY_BE_MISSING, NAMING_PROBABILITY

SIMILAR_ODDS = 0.5
"""Another effect is named as an alternative if the ratio of its probability to the verdict's is at least this. [1]"""


@dataclass(frozen=True, slots=True)
class QuickCandidate:
    """An effect with its probability, its log Bayes factor from a linear fit [nat], its most likely place and strength,
    and leave-one-out errors with it."""

    effect: str
    probability: float
    log_bayes: float
    place: str
    mean: float
    sd: float
    unit: str
    after: Score


@dataclass(frozen=True, slots=True)
class QuickLook:
    """The answer of a linear pass for a rocket; `candidates` are in descending order of probability.

    `again` is the forecast of repeating the last flight. `effect`, `confidence`, `why` and `also` are as in a verdict
    of the loop. `before` are the plain model's leave-one-out errors.
    """

    rocket: str
    flights: int
    probabilities: EffectProbabilities
    again: QuickAnswer
    candidates: tuple[QuickCandidate, ...]
    effect: str
    confidence: float
    why: str
    also: tuple[str, ...]
    before: Score

    @property
    def after(self) -> Score:
        """Leave-one-out errors with the verdict's most probable effect, or else of the plain model."""
        first = self.effect.split("+")[0]
        return next((one.after for one in self.candidates if one.effect == first), self.before)


def quick_look(rocket: str, flown: Sequence[tuple[Flight, Found]], used_in_fit: Sequence[bool]) -> QuickLook:
    """The quick answer for the flights of a rocket, in the order flown.

    Raises ImpossibleFlight for a flight without a dry mass, DamagedModel if the hyperprior cannot be read.
    """
    last, motor = flown[-1]
    history = flown_and_planned(flown, [(repeated(last), motor)]).using(used_in_fit)
    ahead = modeled(history)
    found = effect_probabilities(history, quick_candidates, inclusion_probabilities(), UNEXPLAINED, acting(ahead))
    truth, seen = found.data.values[:, 0], found.data.seen[:, 0]
    before = score(forecasts_of(found.left_out), truth, seen)
    candidates = _candidates(found)
    effect, confidence = _verdict(found)
    named = [one for one in candidates if one.effect in effect.split("+")]
    also = [
        one.effect
        for one in candidates
        if named and one not in named and one.probability > SIMILAR_ODDS * named[-1].probability
    ]
    ready = centered(PreparedHistory(history, ahead, found.response, reference(ahead.model)))
    return QuickLook(
        rocket,
        int(seen.sum()),
        found,
        answers(ready, ready.flown)[0],
        candidates,
        effect,
        confidence,
        _because(effect, confidence, named),
        tuple(also),
        before,
    )


def _verdict(found: EffectProbabilities) -> tuple[str, float]:
    """The verdict of lowest expected cost, as in `fieldkit.selection.verdict`, and its probability.

    Only the probability of each effect is known, not of several together, so they count as independent.
    """
    ranked = sorted(found.inclusion, key=lambda name: -found.inclusion[name])
    likely = [name for name in ranked if found.inclusion[name] > NAMING_PROBABILITY]
    if likely:
        return "+".join(likely), prod(found.inclusion[name] for name in likely)
    if 1 - found.none > NAMING_PROBABILITY:
        return "unexplained", 1 - found.none
    return "none", found.none


def _because(effect: str, confidence: float, named: Sequence[QuickCandidate]) -> str:
    if effect == "none" and confidence <= MATCH_PROBABILITY:
        return MAY_BE_MISSING
    if effect == "none":
        return "the flights match the model within their scatter"
    if effect == "unexplained":
        return "the flights differ from the model, but no known effect is probable enough to name"
    return message("; ".join(f"{one.place}: {estimate(one.mean, one.sd, one.unit)}" for one in named))


def _candidates(found: EffectProbabilities) -> tuple[QuickCandidate, ...]:
    """Every effect that may act, most probable first."""
    each = [_candidate(found, name, rows) for name, rows in families(found.trials).items() if name]
    return tuple(sorted(each, key=lambda one: -one.probability))


def _candidate(found: EffectProbabilities, name: str, rows: Sequence[int]) -> QuickCandidate:
    trials = found.trials
    leader = max(rows, key=lambda row: float(trials.weight[row]))
    own = found.candidates[trials.candidate[leader]]
    assert isinstance(own, Candidate)
    bends = own.terms[0].bends
    assert isinstance(bends, Effect)
    mean, sd = float(trials.mean[leader] * trials.unit[leader]), float(trials.sd[leader] * trials.unit[leader])
    if bends.squared:
        mean, sd = _root(mean, sd)
    log_bayes = float(np.logaddexp.reduce(trials.log_bayes[rows] + trials.log_fraction[rows]))
    after = _left_out_with(found, trials, leader)
    return QuickCandidate(name, found.inclusion[name], log_bayes, str(own.place), mean, sd, bends.unit, after)


def _root(mean: float, sd: float) -> tuple[float, float]:
    """Mean and standard deviation of a strength from those of its fitted square."""
    fitted = max(mean, sd / 10, 1e-12)
    return float(np.sqrt(fitted)), float(sd / (2 * np.sqrt(fitted)))


def _left_out_with(found: EffectProbabilities, trials: Trials, row: int) -> Score:
    """Leave-one-out errors with one trial's direction added to the model, at the most probable scales."""
    linear, data = found.linear, found.data
    model, scales = linear.fit.model, linear.fit.model.hyperprior.unknown_scales
    best = int(np.argmax(linear.fit.log_weight))
    values = [float(value[best]) for value in scale_grid(scales)[:-1]]
    known = [replace(scale, grid=(value,)) for scale, value in zip(scales, values, strict=True)]
    model = replace(model, hyperprior=model.hyperprior.with_scales(*known))
    own = found.candidates[trials.candidate[row]].terms[0]
    term = replace(
        own,
        mean=float(trials.prior_mean[row]),
        sd=float(trials.prior_sd[row]),
        weight=own.weight[: linear.flown],
        low=-np.inf,
        high=np.inf,
    )
    used = len(trials.shift) // linear.flown
    shift = np.zeros((linear.flown, data.values.shape[1]))
    columns = used_readouts(data.seen)
    shift[:, columns] = trials.shift[:, row].reshape(linear.flown, used)
    near = linear.fit.tangent
    wider = replace(near, at=np.r_[near.at, 0.0], slope=np.concatenate([near.slope, shift[..., None]], axis=-1))
    fitted = solve(model.with_terms(term), data, wider)
    return score(forecasts_of(leave_one_out(fitted)), data.values[:, 0], data.seen[:, 0])
