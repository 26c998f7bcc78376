"""Find what a rocket's model lacks: try everything, choose, add, look again, and check on unseen flights.

The errors reported are of flights left out, with the whole choice made anew without them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.loop.candidates import effect_candidates, pattern_candidates
from fieldkit.loop.choice import DECISIVE_MORE, Ranked, pick_in_folds, probability, rank, strongest
from fieldkit.loop.fit import fit
from fieldkit.loop.model import Data, Model
from fieldkit.loop.score import Forecasts, Score, forecasts_of, score
from fieldkit.loop.trial import Trial, by_effect, plain_again, plain_trial, try_family
from fieldkit.simulator.effect import Effect, effects

SEARCH_SLACK = 0.35
"""How far a search lets motors be from their certificate, and configurations from each other, unexplained."""
TURNS = 2
"""Times everything is tried, where trying it shows that the plain model had not found its best fit."""
APART = 2.0
"""Difference of log evidence up to which effects are named together. [nat]"""
Progress = Callable[[str, float], None]
"""Told what is being tried and the share done."""


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What the flights say: the plain model, the ranking, the verdict, errors of unseen flights before and after.

    `effect` is the name of the effect (two joined by `+`), "none" or "unexplained". `accepted` are the
    candidates of the new model, empty without one. `also` are effects that these flights cannot tell from
    the accepted one.
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


CERTAIN = 0.99
"""Probability that something is missing, from which on it is said even where nothing known forecasts better."""
_NO_BETTER = "but flights that were not seen are forecast no better with it, so it is left out until more have flown"


@dataclass(frozen=True, slots=True)
class _Verdict:
    effect: str
    confidence: float
    why: str
    also: tuple[str, ...] = ()
    accepted: tuple[Trial, ...] = ()
    pattern: bool = False


def diagnose(model: Model, data: Data, progress: Progress | None = None) -> Diagnosis:
    """Weigh everything that could be missing from a model against the flights that teach."""
    tell = progress or (lambda text, share: None)
    truth, seen = data.values[:, 0], data.seen[:, 0]
    families = by_effect([*effect_candidates(model, seen), *pattern_candidates(model)])
    plain = fit(model, data)
    for turn in range(TURNS):
        trials = []
        for number, (name, family) in enumerate(families.items()):
            tell(name or "patterns", 0.5 * (turn + number / len(families)) / TURNS)
            trials += try_family(model, data, family, plain)
        better = plain_again(model, data, plain, trials)
        settled = better.log_evidence < plain.log_evidence + 0.3
        plain = better
        if settled:
            break
    base = plain_trial(plain)
    ranking = rank(trials, base, truth, seen)
    first = strongest(ranking, named=True)
    pairs: tuple[Ranked, ...] = ()
    if first is not None:
        found = []
        for number, (name, family) in enumerate(families.items()):
            if name and name != first.effect:
                tell(f"{first.effect}+{name}", 0.5 + number / (2 * len(families)))
                found += try_family(first.best.fit.model, data, family, first.best.fit)
        pairs = rank(found, first.best, truth, seen)
    before = forecasts_of(base.left_out)
    plain_score = score(before, truth, seen)
    after = pick_in_folds(ranking, before, first.effect if first else "", pairs)
    verdict = _verdict(ranking, first, strongest(ranking, named=False), pairs)
    if first is not None and verdict.accepted and not first.worth(score(after, truth, seen), plain_score):
        verdict = _rejected(ranking)
    if not verdict.accepted and not verdict.pattern:
        after = before
    return Diagnosis(
        model=model,
        data=data,
        base=base,
        ranking=ranking,
        effect=verdict.effect,
        confidence=verdict.confidence,
        why=verdict.why,
        also=verdict.also,
        accepted=verdict.accepted,
        before=plain_score,
        after=score(after, truth, seen),
        forecasts_before=before,
        forecasts_after=after,
    )


def _verdict(
    ranking: Sequence[Ranked], first: Ranked | None, pattern: Ranked | None, pairs: Sequence[Ranked]
) -> _Verdict:
    something = probability(ranking)
    if first is None and pattern is None:
        return _rejected(ranking)
    second = strongest(pairs, named=True, decisive=DECISIVE_MORE) if first is not None else None
    both = first.weight + (second.weight if second else 0.0) if first is not None else -np.inf
    if first is None or (pattern is not None and pattern.weight > both):
        assert pattern is not None
        place = pattern.best.candidate.place.where
        why = f"the flights differ from the model together with {place}, and no known effect accounts for it"
        return _Verdict("unexplained", something, why, pattern=True)
    accepted = (first.best, second.best) if second is not None else (first.best,)
    names = [trial.candidate.effect for trial in accepted]
    near = [item.effect for item in ranking if item.effect and item.log_bayes > first.log_bayes - APART]
    rivals = np.logaddexp.reduce([item.weight for item in ranking])
    share = float(np.exp(first.weight - rivals)) if second is None else probability(pairs)
    also = tuple(name for name in near if name not in names)
    return _Verdict("+".join(names), something * share, _because(accepted), also, accepted)


def _rejected(ranking: Sequence[Ranked]) -> _Verdict:
    """Nothing is accepted: because nothing is there, or because what is there helps no forecast."""
    something = probability(ranking)
    best = max(ranking, key=lambda item: item.weight, default=None)
    if best is None or best.weight < 0:
        why = "the flights differ from the model by no more than their own scatter, as far as they can show"
        return _Verdict("none", 1 - something, why)
    why = f"{best.best.candidate.place if best.effect else best.best.candidate.place.where} fits best, {_NO_BETTER}"
    return _Verdict("unexplained", something, why) if something >= CERTAIN else _Verdict("none", 1 - something, why)


def _because(accepted: Sequence[Trial]) -> str:
    """One sentence to a flyer: what is missing, where, and how strong."""
    parts = []
    for trial in accepted:
        bends = trial.candidate.terms[0].bends
        assert isinstance(bends, Effect)
        mean, sd = trial.strength()
        place = f" ({trial.candidate.place})" if str(trial.candidate.place) != trial.candidate.effect else ""
        parts.append(f"{bends.explains}{place}: {mean:.3g} +/- {sd:.2g} {bends.unit}")
    return "; ".join(parts)
