"""Which effect the flights call for, or none: evidence, what was tried, and unseen flights must all agree.

An effect's evidence integrates its strength over its prior and is averaged over the places it may act in, so
that it pays for what it could have done and did not. All effects together have the prior odds of none at
all, shared evenly: what is tried more often must convince more. And an effect is only taken that forecasts
flights left out better than the plain model does.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.loop.score import Forecasts, Score, forecasts_of, score
from fieldkit.loop.trial import Trial, family_forecasts
from fieldkit.shapes import Array, Flags, Float

DECISIVE = 0.5
"""Posterior probability that something is missing, among what helps unseen flights, from which on it is said:
of 42 histories without an effect (`bench`, seed 11) one is then given one. [1]"""
DECISIVE_MORE = 0.7
"""The same for a second effect beside an accepted one, which may only mend what the first got wrong. [1]"""
BETTER = 0.97
"""Error on flights left out, over that of the plain model, that an effect must not exceed. [1]"""
HARMLESS = 1.03
"""The same for an effect whose evidence is `OVERWHELMING`: it may show in readouts that are no apogee. [1]"""
OVERWHELMING = 5.0
"""Log posterior odds. [nat]"""
PATTERN_SHARE = 0.1
"""Share of the prior odds that patterns without an explanation have beside the effects. [1]"""


@dataclass(frozen=True, slots=True)
class Ranked:
    """An effect (or the patterns together, without a name) with the trials of all its places.

    `log_bayes` is its log Bayes factor against the plainer model, `fold_log_bayes` the same without each
    flight in turn, `log_odds` its log prior odds. `helps` says whether it forecasts flights left out
    better, `fold_helps` the same without each flight.
    """

    effect: str
    trials: tuple[Trial, ...]
    log_bayes: float
    fold_log_bayes: Float[Array, "flight"]
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
    def weight(self) -> float:
        """Log posterior odds against the plainer model."""
        return self.log_bayes + self.log_odds

    def worth(self, after: Score, before: Score) -> bool:
        """Whether flights not seen are forecast better when the whole choice is made without them."""
        return after.mae < before.mae * (HARMLESS if self.weight > OVERWHELMING else 1.0)

    @property
    def fold_weight(self) -> Float[Array, "flight"]:
        """Log posterior odds without each flight; minus infinity where it does not help there."""
        return np.where(self.fold_helps, self.fold_log_bayes + self.log_odds, -np.inf)


def rank(trials: Sequence[Trial], plainer: Trial, truth: Float[Array, "flight"], seen: Flags) -> tuple[Ranked, ...]:
    """Effects by their evidence, the strongest first; `truth` are log apogees, `seen` those that teach."""
    families: dict[str, list[Trial]] = {}
    for trial in trials:
        families.setdefault(trial.candidate.effect, []).append(trial)
    named = max(sum(1 for name in families if name), 1)
    odds = {name: float(np.log((1 - PATTERN_SHARE) / named if name else PATTERN_SHARE)) for name in families}
    misses = _misses(forecasts_of(plainer.left_out), truth, seen)
    ranked = [_ranked(name, family, plainer, odds[name], misses, truth, seen) for name, family in families.items()]
    return tuple(sorted(ranked, key=lambda item: -item.log_bayes))


def _misses(forecasts: Forecasts, truth: Array, seen: Flags) -> Array:
    """Absolute errors of forecast apogees, 0 for flights that do not teach. [m]"""
    return np.where(seen, np.abs(forecasts.apogee - np.exp(truth)), 0.0)


def _ranked(
    name: str, family: Sequence[Trial], plainer: Trial, odds: float, plain_misses: Array, truth: Array, seen: Flags
) -> Ranked:
    share = np.array([trial.candidate.log_share for trial in family])
    whole = np.array([trial.log_evidence for trial in family])
    folds = np.stack([trial.fold_evidence for trial in family])
    forecasts = family_forecasts(family)
    misses = _misses(forecasts, truth, seen)
    log_bayes = float(np.logaddexp.reduce(whole + share) - plainer.log_evidence)
    fold_log_bayes = np.logaddexp.reduce(folds + share[:, None], axis=0) - plainer.fold_evidence
    fold_misses, fold_plain = misses.sum() - misses, plain_misses.sum() - plain_misses
    return Ranked(
        effect=name,
        trials=tuple(family),
        log_bayes=log_bayes,
        fold_log_bayes=fold_log_bayes,
        log_odds=odds,
        forecasts=forecasts,
        score=score(forecasts, truth, seen),
        helps=bool(misses.sum() < _limit(log_bayes + odds) * plain_misses.sum()),
        fold_helps=np.asarray(fold_misses < _limit(fold_log_bayes + odds) * fold_plain),
    )


def _limit(weight: Array | float) -> Array:
    """The error that an effect of this log posterior odds may leave, over that of the plain model. [1]"""
    return np.where(np.asarray(weight) > OVERWHELMING, HARMLESS, BETTER)


def probability(ranking: Sequence[Ranked]) -> float:
    """Posterior probability that one of these is there rather than none."""
    weights = [item.weight for item in ranking]
    return float(1 / (1 + np.exp(-np.logaddexp.reduce(weights)))) if weights else 0.0


def strongest(ranking: Sequence[Ranked], *, named: bool, decisive: float = DECISIVE) -> Ranked | None:
    """The likeliest that helps, among the effects or among the patterns, where something is missing at all."""
    helping = [item for item in ranking if item.helps]
    if probability(helping) < decisive:
        return None
    chosen = [item for item in helping if bool(item.effect) == named]
    return max(chosen, key=lambda item: item.weight, default=None)


def pick_in_folds(
    ranking: Sequence[Ranked], plain: Forecasts, first: str = "", pairs: Sequence[Ranked] = ()
) -> Forecasts:
    """Forecasts of each flight by the model chosen without it, all by the same rules.

    `pairs` are second effects tried beside the effect `first`; they are there for the folds that choose it.
    """
    weights = np.stack([item.fold_weight for item in ranking]) if ranking else np.zeros((0, plain.mean.shape[1]))
    more = np.stack([item.fold_weight for item in pairs]) if pairs else None
    picked = []
    for flight in range(plain.mean.shape[1]):
        chosen = _pick(ranking, weights[:, flight])
        if chosen is None:
            picked.append(plain)
            continue
        if more is not None and first:
            chosen = _pick_pair(ranking, weights[:, flight], chosen, first, pairs, more[:, flight])
        picked.append(chosen.forecasts)
    return Forecasts.pick(picked)


def _pick(ranking: Sequence[Ranked], weights: Array, decisive: float = DECISIVE) -> Ranked | None:
    if not len(weights) or 1 / (1 + np.exp(-np.logaddexp.reduce(weights))) < decisive:
        return None
    return ranking[int(np.argmax(weights))]


def _pick_pair(
    ranking: Sequence[Ranked], weights: Array, chosen: Ranked, first: str, pairs: Sequence[Ranked], more: Array
) -> Ranked:
    """The pair, where the fold's best effect is the one that pairs were tried with and a second one convinces."""
    named = [i for i, item in enumerate(ranking) if item.effect]
    best = max(named, key=lambda i: weights[i])
    second = _pick(pairs, more, DECISIVE_MORE) if ranking[best].effect == first else None
    if second is None:
        return chosen
    both = weights[best] + more[[item is second for item in pairs].index(True)]
    return second if both >= weights[ranking.index(chosen)] else chosen
