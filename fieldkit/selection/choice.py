"""Which effect the flights call for, or none: evidence, what was tried, and unseen flights must all agree.

An effect's evidence integrates its strength over its prior and is averaged over the places it may act in, so
that it pays for what it could have done and did not. All effects together have the prior odds
`ODDS`, shared evenly: what is tried more often must convince more. What counts is the evidence that stays when the
flight that says most for it is taken away, so that one odd flight decides nothing. And an effect is only taken
that forecasts flights left out better than the model without it does, the less so the surer the evidence is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.scoring.score import Forecasts, Score, forecasts_of, score
from fieldkit.selection.trial import Trial, family_forecasts
from fieldkit.shapes import Array, Flags, Float

ODDS = 3.0
"""Prior odds that something is missing, as the steady evidence has less to say than all of it: set, like what
follows, so that of 66 histories without an effect (`bench`, seeds 7, 11 and 12) none was given one. [1]"""
MIN_INCLUSION_PROBABILITY = 0.65
"""Posterior probability of an effect, against the model without it, from which on it is included if it helps. [1]"""
MAX_EASY_EFFECTS = 2
"""Number of effects for which `MIN_INCLUSION_PROBABILITY` is enough. [1]"""
MIN_FURTHER_PROBABILITY = 0.99
"""The same probability for each one more: beside several, what the simulator itself gets wrong passes for an effect
soonest. [1]"""
MAX_ERROR_RATIO = 0.97
"""Error on flights left out, over that of the model without it, up to which an effect with even odds helps. [1]"""
ERROR_RATIO_PER_LOG_ODDS = 0.02
"""What more of that an effect may leave for each unit of its log posterior odds: the error of twenty flights is
itself known to a tenth only, and an effect may show best in readouts that are no apogee. [1/nat]"""
MAX_ERROR_RATIO_ALLOWED = 1.15
"""Upper limit of that ratio, whatever the posterior odds. [1]"""
NOISE = 1.1
"""Error on flights left out with the whole choice made anew without each, over that of the plain model, up to which a
choice stands: the error of twenty flights is known to a tenth only. [1]"""
PATTERN_SHARE = 0.1
"""Share of the prior odds that patterns without an explanation have beside the effects. [1]"""


@dataclass(frozen=True, slots=True)
class Ranked:
    """An effect (or the patterns together, without a name) with the trials of all its places.

    `beside` is the one it was tried beside, None for the plain model. `log_bayes` is its log Bayes factor against the
    model without it, `steady` what stays of it without the flight that says most for it, `fold_steady` the same for
    all flights but each one, `log_odds` its log prior odds. `helps` says whether it forecasts flights left out
    better, `fold_helps` the same without each flight.
    """

    effect: str
    trials: tuple[Trial, ...]
    beside: "Ranked | None"
    log_bayes: float
    steady: float
    fold_steady: Float[Array, "flight"]
    log_odds: float
    forecasts: Forecasts
    score: Score
    helps: bool
    fold_helps: Flags

    @property
    def best(self) -> Trial:
        """The place in which it is most at home."""
        return max(self.trials, key=lambda trial: trial.log_evidence + trial.candidate.log_share)

    @property
    def accepted(self) -> tuple[Trial, ...]:
        """What a model with it has that the plain one has not."""
        return (self.best,) if self.beside is None else (*self.beside.accepted, self.best)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of all that is in it, empty for a pattern."""
        return tuple(trial.candidate.effect for trial in self.accepted)

    @property
    def own_weight(self) -> float:
        """Log posterior odds against the model without it."""
        return self.steady + self.log_odds

    @property
    def weight(self) -> float:
        """Log posterior odds against the plain model."""
        return self.own_weight + (self.beside.weight if self.beside else 0.0)

    @property
    def belief(self) -> float:
        """Log odds against the model without it, if that something is missing is as likely as not beforehand."""
        return self.own_weight - float(np.log(ODDS))

    @property
    def whole_belief(self) -> float:
        """The same against the plain model."""
        return self.belief + (self.beside.whole_belief if self.beside else 0.0)

    @property
    def counts(self) -> bool:
        """Whether it may be chosen: it helps, and convinces against the model without it."""
        return self.helps and self.own_weight > self._enough

    @property
    def _enough(self) -> float:
        """Log posterior odds from which on it convinces."""
        return _log_odds(
            MIN_INCLUSION_PROBABILITY if len(self.accepted) <= MAX_EASY_EFFECTS else MIN_FURTHER_PROBABILITY
        )

    @property
    def fold_weight(self) -> Float[Array, "flight"]:
        """`weight` without each flight; minus infinity where it would not be chosen there."""
        own = self.fold_steady + self.log_odds
        return np.where(self.fold_helps & (own > self._enough), self._fold_odds, -np.inf)

    @property
    def _fold_odds(self) -> Float[Array, "flight"]:
        """Log posterior odds against the plain model without each flight."""
        before = self.beside._fold_odds if self.beside else 0.0
        return np.asarray(self.fold_steady + self.log_odds + before)


def _log_odds(probability: float) -> float:
    return float(np.log(probability / (1 - probability)))


def rank(
    trials: Sequence[Trial],
    plainer: Trial,
    truth: Float[Array, "flight"],
    seen: Flags,
    beside: Ranked | None = None,
    among: int = 0,
) -> tuple[Ranked, ...]:
    """Effects by their evidence, the strongest first; `truth` are log apogees, `seen` those that teach.

    `plainer` is the model that they were added to, with the effect `beside` in it if any. They share their prior odds
    with all that were tried, `among` so many where the others are not at hand.
    """
    families: dict[str, list[Trial]] = {}
    for trial in trials:
        families.setdefault(trial.candidate.effect, []).append(trial)
    named = max(sum(1 for name in families if name), among, 1)
    odds = {name: float(np.log(ODDS * ((1 - PATTERN_SHARE) / named if name else PATTERN_SHARE))) for name in families}
    misses = _misses(forecasts_of(plainer.left_out), truth, seen)
    ranked = [
        _ranked(name, family, plainer, odds[name], misses, truth, seen, beside) for name, family in families.items()
    ]
    return tuple(sorted(ranked, key=lambda item: -item.log_bayes))


def _misses(forecasts: Forecasts, truth: Array, seen: Flags) -> Array:
    """Absolute errors of forecast apogees, 0 for flights that do not teach. [m]"""
    return np.where(seen, np.abs(forecasts.apogee - np.exp(truth)), 0.0)


def _ranked(
    name: str,
    family: Sequence[Trial],
    plainer: Trial,
    odds: float,
    plain_misses: Array,
    truth: Array,
    seen: Flags,
    beside: Ranked | None,
) -> Ranked:
    share = np.array([trial.candidate.log_share for trial in family])
    whole = np.array([trial.log_evidence for trial in family])
    folds = np.stack([trial.fold_evidence for trial in family])
    forecasts = family_forecasts(family)
    misses = _misses(forecasts, truth, seen)
    log_bayes = float(np.logaddexp.reduce(whole + share) - plainer.log_evidence)
    fold_log_bayes = np.logaddexp.reduce(folds + share[:, None], axis=0) - plainer.fold_evidence
    steady, fold_steady = robust_evidence(log_bayes, fold_log_bayes, seen)
    fold_misses, fold_plain = misses.sum() - misses, plain_misses.sum() - plain_misses
    return Ranked(
        effect=name,
        trials=tuple(family),
        beside=beside,
        log_bayes=log_bayes,
        steady=steady,
        fold_steady=fold_steady,
        log_odds=odds,
        forecasts=forecasts,
        score=score(forecasts, truth, seen),
        helps=bool(misses.sum() < may_leave(steady + odds) * plain_misses.sum()),
        fold_helps=np.asarray(fold_misses < may_leave(fold_steady + odds) * fold_plain),
    )


def robust_evidence(
    log_bayes: float, without: Float[Array, "flight"], seen: Flags
) -> tuple[float, Float[Array, "flight"]]:
    """Evidence less what its strongest flight says, for all flights and for all but each one.

    `without` is the evidence without each flight. What two flights say is taken to add up.
    """
    says = np.where(seen, np.maximum(log_bayes - without, 0.0), 0.0)
    strongest = int(np.argmax(says))
    second = float(np.max(np.delete(says, strongest), initial=0.0))
    others = np.where(np.arange(len(says)) == strongest, second, says[strongest])
    return float(log_bayes - says[strongest]), np.asarray(without - others)


def may_leave(weight: Array | float) -> Array:
    """The error that an effect of this log posterior odds may leave, over that of the model without it. [1]"""
    return np.clip(MAX_ERROR_RATIO + ERROR_RATIO_PER_LOG_ODDS * np.asarray(weight), None, MAX_ERROR_RATIO_ALLOWED)


def stands(chosen: Ranked, after: Score, before: Score) -> bool:
    """Whether a choice holds where all of it is made anew without each flight: `after` are the errors then.

    Without its most telling flight an effect may fall short of being chosen, and just that flight is then forecast by
    the plain model; so this may cost what chance does, and what evidence as sure as this may leave.
    """
    return after.mae <= max(NOISE, float(may_leave(chosen.weight)) / MAX_ERROR_RATIO) * before.mae


def probability(options: Sequence[Ranked]) -> float:
    """Posterior probability that the plain model lacks something."""
    beliefs = [item.belief for item in options if item.beside is None]
    return float(1 / (1 + np.exp(-np.logaddexp.reduce(beliefs)))) if beliefs else 0.0


def confidence(chosen: Ranked, options: Sequence[Ranked]) -> float:
    """Posterior probability that these effects are there, alone or with others, among all that was tried."""
    beliefs = np.array([0.0, *(item.whole_belief for item in options)])
    there = [False, *(set(chosen.effects) <= set(item.effects) for item in options)]
    return float(np.exp(np.logaddexp.reduce(beliefs[there]) - np.logaddexp.reduce(beliefs)))


def choose(options: Sequence[Ranked]) -> Ranked | None:
    """The likeliest that counts, None where none does."""
    return max((item for item in options if item.counts), key=lambda item: item.weight, default=None)


def choose_in_folds(options: Sequence[Ranked], plain: Forecasts) -> Forecasts:
    """Forecasts of each flight by the model chosen without it, by the same rule."""
    if not options:
        return plain
    weights = np.stack([item.fold_weight for item in options])
    chosen = np.argmax(weights, axis=0)
    counts = np.isfinite(weights.max(axis=0))
    return Forecasts.pick([options[i].forecasts if any_ else plain for i, any_ in zip(chosen, counts, strict=True)])
