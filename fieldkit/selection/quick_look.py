"""The quick search for missing effects of a rocket by the history network.

The probabilities are pooled from the network and closed-form evidence. Strengths, evidence and leave-one-out errors
come from one linear fit, with each effect in its most probable place.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.plan import repeated
from fieldkit.inference.history.columns import families
from fieldkit.inference.history.drawn_rockets import MAX_FLIGHTS
from fieldkit.inference.history.evidence import Trials
from fieldkit.inference.history.features import HistorySummary
from fieldkit.inference.laplace.leave_one_out import leave_one_out
from fieldkit.inference.laplace.posterior import solve, used_readouts
from fieldkit.inference.network.history import QuickAnswer, load_history, quick_answer, untrained_effects
from fieldkit.messages import estimate, message
from fieldkit.motors import Found
from fieldkit.physics.effect import Effect
from fieldkit.physics.history import flown_and_planned
from fieldkit.scoring.score import Score, forecasts_of, score
from fieldkit.selection.candidates import Candidate
from fieldkit.selection.quick_candidates import quick_candidates
from fieldkit.selection.verdict import NAMING_PROBABILITY

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

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
    """The network's answer for a rocket; `candidates` are in descending order of probability.

    `effect`, `confidence`, `why` and `also` are as in a verdict of the loop. `before` are the plain model's
    leave-one-out errors. `untrained` are installed effects that the network was not trained with.
    """

    rocket: str
    flights: int
    answer: QuickAnswer
    candidates: tuple[QuickCandidate, ...]
    effect: str
    confidence: float
    why: str
    also: tuple[str, ...]
    before: Score
    untrained: tuple[str, ...]

    @property
    def beyond_training(self) -> bool:
        """Whether there are more flights than in any history that the network was trained with."""
        return self.flights > MAX_FLIGHTS

    @property
    def after(self) -> Score:
        """Leave-one-out errors with the verdict's most probable effect, or else of the plain model."""
        first = self.effect.split("+")[0]
        return next((one.after for one in self.candidates if one.effect == first), self.before)


def quick_look(
    rocket: str,
    flown: Sequence[tuple[Flight, Found]],
    used_in_fit: Sequence[bool],
    ensemble: "Ensemble | None" = None,
) -> QuickLook:
    """The network's answer for the flights of a rocket, in the order flown.

    Raises ImpossibleFlight for a flight without a dry mass, DamagedModel if the network cannot be loaded, BadValue for
    a recovery figure or rail direction that cannot be read.
    """
    network = ensemble or load_history()
    last, motor = flown[-1]
    history = flown_and_planned(flown, [(repeated(last), motor)]).using(used_in_fit)
    estimate = quick_answer(history, quick_candidates, ensemble=network)
    truth, seen = estimate.summary.data.values[:, 0], estimate.summary.data.seen[:, 0]
    before = score(forecasts_of(estimate.summary.left_out), truth, seen)
    candidates = _candidates(estimate)
    effect, confidence = _verdict(estimate)
    named = [one for one in candidates if one.effect in effect.split("+")]
    also = [
        one.effect
        for one in candidates
        if named and one not in named and one.probability > SIMILAR_ODDS * named[-1].probability
    ]
    return QuickLook(
        rocket,
        int(seen.sum()),
        estimate,
        candidates,
        effect,
        confidence,
        _because(effect, named),
        tuple(also),
        before,
        untrained_effects(network),
    )


def _verdict(estimate: QuickAnswer) -> tuple[str, float]:
    """The verdict of lowest expected cost, as in `fieldkit.selection.verdict`, and its probability.

    The network gives the probability of each effect, not of several together, so they count as independent.
    """
    ranked = sorted(estimate.inclusion, key=lambda name: -estimate.inclusion[name])
    likely = [name for name in ranked if estimate.inclusion[name] > NAMING_PROBABILITY]
    if likely:
        return "+".join(likely), prod(estimate.inclusion[name] for name in likely)
    if 1 - estimate.none > NAMING_PROBABILITY:
        return "unexplained", 1 - estimate.none
    return "none", estimate.none


def _because(effect: str, named: Sequence[QuickCandidate]) -> str:
    if effect == "none":
        return "the flights match the model within their scatter"
    if effect == "unexplained":
        return "the flights differ from the model, but no known effect is probable enough to name"
    return message("; ".join(f"{one.place}: {estimate(one.mean, one.sd, one.unit)}" for one in named))


def _candidates(estimate: QuickAnswer) -> tuple[QuickCandidate, ...]:
    """Every effect that may act, most probable first."""
    trials = estimate.summary.trials
    found = [
        _candidate(estimate, name, rows)
        for name, rows in families(trials).items()
        if name and name in estimate.inclusion
    ]
    return tuple(sorted(found, key=lambda one: -one.probability))


def _candidate(estimate: QuickAnswer, name: str, rows: Sequence[int]) -> QuickCandidate:
    summary, trials = estimate.summary, estimate.summary.trials
    leader = max(rows, key=lambda row: float(trials.weight[row]))
    own = summary.candidates[trials.candidate[leader]]
    assert isinstance(own, Candidate)
    bends = own.terms[0].bends
    assert isinstance(bends, Effect)
    mean, sd = float(trials.mean[leader] * trials.unit[leader]), float(trials.sd[leader] * trials.unit[leader])
    if bends.squared:
        mean, sd = _root(mean, sd)
    log_bayes = float(np.logaddexp.reduce(trials.log_bayes[rows] + trials.log_fraction[rows]))
    after = _left_out_with(summary, trials, leader)
    return QuickCandidate(name, estimate.inclusion[name], log_bayes, str(own.place), mean, sd, bends.unit, after)


def _root(mean: float, sd: float) -> tuple[float, float]:
    """Mean and standard deviation of a strength from those of its fitted square."""
    fitted = max(mean, sd / 10, 1e-12)
    return float(np.sqrt(fitted)), float(sd / (2 * np.sqrt(fitted)))


def _left_out_with(summary: HistorySummary, trials: Trials, row: int) -> Score:
    """Leave-one-out errors with one trial's direction added to the model."""
    linear, data = summary.selection, summary.data
    model = linear.fit.model
    own = summary.candidates[trials.candidate[row]].terms[0]
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
