"""Find what a rocket's model lacks: weigh every candidate against the plain model, and check on unseen flights.

Each candidate's evidence integrates its strength over its prior, so that an effect pays for what it could
have done and did not. All effects together have the prior odds of no effect at all, shared evenly: what
is tried more often must convince more. The same choice is made anew with every flight left out in turn, and
the errors reported are of the flight that was left out.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.loop.candidates import Candidate, Place, effect_candidates, pattern_candidates
from fieldkit.loop.fit import Fit, Lane, LeftOut, fit, fit_lanes, leave_one_out
from fieldkit.loop.model import Data, Model
from fieldkit.loop.score import Forecasts, Score, forecasts_of, mixed, score
from fieldkit.shapes import Array, Flags, Float
from fieldkit.simulator.effect import Effect, effects

DECISIVE = 0.9
"""Posterior probability that something is missing, from which on it is said. [1]"""
APART = 2.0
"""Difference of log evidence up to which effects are named together. [nat]"""
PATTERN_SHARE = 0.1
"""Share of the prior odds that patterns without an explanation have beside the effects. [1]"""
Progress = Callable[[str, float], None]
"""Told what is being tried and the share done."""


@dataclass(frozen=True, slots=True)
class Trial:
    """A candidate with its fit and what it says of each flight left out."""

    candidate: Candidate
    fit: Fit
    left_out: LeftOut

    @property
    def log_evidence(self) -> float:
        """Of the observed readouts. [nat]"""
        return self.fit.log_evidence

    @property
    def unit(self) -> str:
        """Of the strength; empty for a pattern."""
        bends = self.candidate.terms[0].bends if self.candidate.terms else ""
        return bends.unit if isinstance(bends, Effect) else ""

    @property
    def fold_evidence(self) -> Float[Array, "flight"]:
        """Log evidence of all flights but one, for each one. [nat]"""
        return np.asarray(np.logaddexp.reduce(self.left_out.log_weight, axis=0))


@dataclass(frozen=True, slots=True)
class Ranked:
    """An effect (or the patterns together) with the trials of all its places, and its log Bayes factor."""

    effect: str
    trials: tuple[Trial, ...]
    log_bayes: float
    score: Score

    @property
    def best(self) -> Trial:
        """The place in which it is most at home."""
        return max(self.trials, key=lambda trial: trial.log_evidence + trial.candidate.log_share)


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What the flights say: the plain model's residual, the ranking, the verdict, errors before and after.

    `effect` is the name of the effect (two joined by `+`), "none" or "unexplained". `accepted` are the
    candidates of the new model, empty without one.
    """

    model: Model
    data: Data
    base: Trial
    ranking: tuple[Ranked, ...]
    effect: str
    confidence: float
    why: str
    also: tuple[str, ...]
    accepted: tuple[Trial, ...]
    before: Score
    after: Score
    forecasts_before: Forecasts
    forecasts_after: Forecasts

    @property
    def advice(self) -> list[str]:
        """What to fly or write down to tell the effects named together apart."""
        names = [name for name in (*self.effect.split("+"), *self.also) if name in effects()]
        return [effects()[name].tell_apart for name in names] if self.also else []


def try_family(model: Model, data: Data, family: Sequence[Candidate], near: Fit) -> list[Trial]:
    """Fit the candidates of one effect side by side, each from all its starts, from where a smaller model ended."""
    wide, lanes, owners = model, [], []
    base = tuple(range(len(model.terms)))
    for candidate in family:
        own = tuple(range(len(wide.terms), len(wide.terms) + len(candidate.terms)))
        wide = wide.with_terms(*candidate.terms)
        rest = [term.mean for term in candidate.terms[1:]]
        for start in candidate.starts:
            lanes.append(Lane((*base, *own), np.array([*near.tangent.at, start, *rest])))
            owners.append(candidate)
    fits = fit_lanes(wide, data, lanes, near.tangent.scatter_slope[..., -1], rounds=5)
    best: dict[Place, Fit] = {}
    for candidate, result in zip(owners, fits, strict=True):
        known = best.get(candidate.place)
        if known is None or result.log_evidence > known.log_evidence:
            best[candidate.place] = result
    return [Trial(candidate, best[candidate.place], leave_one_out(best[candidate.place])) for candidate in family]


SEARCH_SLACK = 0.35
"""How far a search lets motors be from their certificate, and configurations from each other, unexplained."""


TURNS = 2
"""Times everything is tried, where trying it shows that the plain model had not found its best fit."""


def _again(model: Model, data: Data, known: Fit, trials: Sequence[Trial]) -> Fit:
    """The plain model fitted anew from where the trials ended: an effect that does nothing may have helped the
    rest of the model to a better place, and must not get the credit."""
    count = len(model.terms)
    best = {trial.candidate.effect: trial for trial in sorted(trials, key=lambda trial: trial.log_evidence)}
    every = tuple(range(count))
    lanes = [Lane(every, trial.fit.tangent.at[:count]) for trial in best.values()]
    fits = fit_lanes(model, data, lanes, known.tangent.scatter_slope[..., -1], rounds=4)
    return max([known, *fits], key=lambda result: result.log_evidence)


def diagnose(model: Model, data: Data, progress: Progress | None = None) -> Diagnosis:
    """Weigh everything that could be missing from a model against the flights that teach."""
    tell = progress or (lambda text, share: None)
    truth = data.values[:, 0]
    seen = data.seen[:, 0]
    singles = _by_effect([*effect_candidates(model, seen), *pattern_candidates(model)])
    base_fit = fit(model, data)
    for turn in range(TURNS):
        trials = []
        for number, (name, family) in enumerate(singles.items()):
            tell(name or "patterns", 0.5 * (turn + number / len(singles)) / TURNS)
            trials += try_family(model, data, family, base_fit)
        better = _again(model, data, base_fit, trials)
        settled = better.log_evidence < base_fit.log_evidence + 0.3
        base_fit = better
        if settled:
            break
    base = Trial(Candidate(Place("none"), ()), base_fit, leave_one_out(base_fit))
    before = forecasts_of(base.left_out)
    ranking = _rank(trials, base, truth, seen)
    choice = _choose(ranking, base.log_evidence)
    folds = _fold_choices(trials, base)
    if choice is None or not choice.effect:
        after = _select(folds, trials, base)
        return _conclude(model, data, base, ranking, choice, (), before, after if choice else before)

    best = choice.best
    pairs = []
    for number, (name, family) in enumerate(singles.items()):
        if name and name != choice.effect:
            tell(f"{choice.effect}+{name}", 0.5 + number / (2 * len(singles)))
            pairs += try_family(best.fit.model, data, family, best.fit)
    second = _choose(_rank(pairs, best, truth, seen), best.log_evidence)
    accepted = (best, second.best) if second is not None else (best,)
    after = _select(folds, trials, base, (best, pairs))
    return _conclude(model, data, base, ranking, choice, accepted, before, after)


def _by_effect(candidates: Sequence[Candidate]) -> dict[str, list[Candidate]]:
    families: dict[str, list[Candidate]] = {}
    for candidate in candidates:
        families.setdefault(candidate.effect, []).append(candidate)
    return families


def _families(trials: Sequence[Trial]) -> dict[str, list[Trial]]:
    families: dict[str, list[Trial]] = {}
    for trial in trials:
        families.setdefault(trial.candidate.effect, []).append(trial)
    return families


def _log_bayes(family: Sequence[Trial], base: Trial) -> tuple[float, Float[Array, "flight"]]:
    """Log Bayes factor of an effect, averaged over its places; of all flights, and of all but each one."""
    share = np.array([trial.candidate.log_share for trial in family])
    whole = np.array([trial.log_evidence for trial in family])
    folds = np.stack([trial.fold_evidence for trial in family])
    return (
        float(np.logaddexp.reduce(whole + share) - base.log_evidence),
        np.asarray(np.logaddexp.reduce(folds + share[:, None], axis=0) - base.fold_evidence),
    )


def _log_prior_odds(names: Sequence[str]) -> dict[str, float]:
    """Log prior odds of each effect against none; patterns have a share beside them."""
    effects = [name for name in names if name]
    odds = {name: np.log((1 - PATTERN_SHARE) / max(len(effects), 1)) for name in effects}
    return odds | ({"": np.log(PATTERN_SHARE)} if "" in names else {})


def _rank(trials: Sequence[Trial], base: Trial, truth: Array, seen: Flags) -> tuple[Ranked, ...]:
    ranked = []
    for name, family in _families(trials).items():
        bayes, _ = _log_bayes(family, base)
        forecasts = _family_forecasts(family)
        ranked.append(Ranked(name, tuple(family), bayes, score(forecasts, truth, seen)))
    return tuple(sorted(ranked, key=lambda item: -item.log_bayes))


def _family_forecasts(family: Sequence[Trial]) -> Forecasts:
    """What an effect says of each flight left out, its places weighed by their evidence."""
    parts = [
        (trial.left_out.mean, trial.left_out.variance, trial.left_out.log_weight + trial.candidate.log_share)
        for trial in family
    ]
    return mixed(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _choose(ranking: Sequence[Ranked], base_evidence: float) -> Ranked | None:
    """The effect that the flights call for, or None."""
    odds = _log_prior_odds([item.effect for item in ranking])
    weights = np.array([item.log_bayes + odds[item.effect] for item in ranking])
    if not len(weights) or 1 / (1 + np.exp(-np.logaddexp.reduce(weights))) < DECISIVE:
        return None
    return ranking[int(np.argmax(weights))]


def _fold_choices(trials: Sequence[Trial], base: Trial) -> list[str | None]:
    """The effect chosen without each flight in turn; None for none."""
    families = _families(trials)
    odds = _log_prior_odds(list(families))
    weights = np.stack([_log_bayes(family, base)[1] + odds[name] for name, family in families.items()])
    missing = 1 / (1 + np.exp(-np.logaddexp.reduce(weights, axis=0))) >= DECISIVE
    names = list(families)
    return [names[int(best)] if there else None for best, there in zip(weights.argmax(axis=0), missing, strict=True)]


def _select(
    folds: Sequence[str | None],
    trials: Sequence[Trial],
    base: Trial,
    second: tuple[Trial, Sequence[Trial]] | None = None,
) -> Forecasts:
    """Forecasts of each flight by the model chosen without it."""
    families = _families(trials)
    options = {None: forecasts_of(base.left_out)} | {
        name: _family_forecasts(families[name]) for name in set(folds) if name is not None
    }
    picked = [options[name] for name in folds]
    if second is not None:
        first, pairs = second
        further = _fold_choices(pairs, first)
        pair_families = _families(pairs)
        for number, (name, more) in enumerate(zip(folds, further, strict=True)):
            if name == first.candidate.effect and more:
                picked[number] = _family_forecasts(pair_families[more])
    return Forecasts.pick(picked)


def _conclude(
    model: Model,
    data: Data,
    base: Trial,
    ranking: tuple[Ranked, ...],
    choice: Ranked | None,
    accepted: tuple[Trial, ...],
    before: Forecasts,
    after: Forecasts,
) -> Diagnosis:
    truth, seen = data.values[:, 0], data.seen[:, 0]
    score_before, score_after = score(before, truth, seen), score(after, truth, seen)
    odds = _log_prior_odds([item.effect for item in ranking])
    weights = np.array([item.log_bayes + odds[item.effect] for item in ranking])
    something = float(1 / (1 + np.exp(-np.logaddexp.reduce(weights)))) if len(weights) else 0.0
    if choice is None:
        why = "the flights differ from the model by no more than their own scatter"
        return Diagnosis(
            model, data, base, ranking, "none", 1 - something, why, (), (), score_before, score_before, before, before
        )
    if not choice.effect:
        place = choice.best.candidate.place.where
        why = f"the flights differ from the model together with {place}, and no known effect accounts for it"
        return Diagnosis(
            model, data, base, ranking, "unexplained", something, why, (), (), score_before, score_after, before, after
        )
    name = "+".join(trial.candidate.effect for trial in accepted)
    near = [
        item for item in ranking if item.effect and item is not choice and item.log_bayes > choice.log_bayes - APART
    ]
    also = tuple(item.effect for item in near if item.effect not in name.split("+"))
    share = float(np.exp(choice.log_bayes + odds[choice.effect] - np.logaddexp.reduce(weights)))
    return Diagnosis(
        model,
        data,
        base,
        ranking,
        name,
        something * share,
        _because(accepted),
        also,
        accepted,
        score_before,
        score_after,
        before,
        after,
    )


def _because(accepted: Sequence[Trial]) -> str:
    """One sentence to a flyer: what is missing, where, and how strong."""
    parts = []
    for trial in accepted:
        term = trial.candidate.terms[0]
        assert isinstance(term.bends, Effect)
        mean, sd = strength(trial)
        place = f" ({trial.candidate.place})" if str(trial.candidate.place) != trial.candidate.effect else ""
        parts.append(f"{term.bends.explains}{place}: {mean:.3g} +/- {sd:.2g} {term.bends.unit}")
    return "; ".join(parts)


def strength(trial: Trial) -> tuple[float, float]:
    """Posterior mean and standard deviation of a candidate's strength, in the effect's unit."""
    term = trial.candidate.terms[0]
    mean, sd = trial.fit.moments()
    index = trial.fit.model.names.index(term.name)
    fitted, spread = float(mean[index]), float(sd[index])
    if isinstance(term.bends, Effect) and term.bends.squared:
        fitted = max(fitted, spread / 10, 1e-12)
        return float(np.sqrt(fitted)), float(spread / (2 * np.sqrt(fitted)))
    return fitted, spread
