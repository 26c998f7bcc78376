"""Find what a rocket's model lacks: try everything, choose, add, look again, and check on unseen flights.

The errors reported are of flights left out, with the whole choice made anew without them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.errors import UnknownEffect
from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import Data
from fieldkit.model.rocket_model import Model
from fieldkit.physics.effect import Effect
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.scoring.score import Forecasts, Score, forecasts_of, score
from fieldkit.selection.candidates import Candidate, Place, effect_candidates
from fieldkit.selection.choice import Ranked, choose, choose_in_folds, confidence, probability, rank, stands
from fieldkit.selection.patterns import pattern_candidates
from fieldkit.selection.trial import Trial, by_effect, plain_again, plain_trial, try_all

MAX_SEARCHES = 2
"""Number of times all effects are tried, if trying them shows that the plain model had not found its best fit. [1]"""
LOG_EVIDENCE_TIE = 2.0
"""Difference of log evidence up to which effects are named together. [nat]"""


@dataclass(frozen=True, slots=True)
class Second:
    """What was tried beside an effect: the model `base` with that effect in it, and the ranking of the others."""

    first: Ranked
    base: Trial
    ranking: tuple[Ranked, ...]


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What the flights say: the plain model, the ranking, the verdict, errors of unseen flights before and after.

    `effect` is the name of the effect (several joined by `+`), "none" or "unexplained". `accepted` are the
    candidates of the new model, empty without one. `also` are effects that these flights cannot tell from
    the accepted one. `seconds` are the pairs tried, empty where the effect was given. `pattern` is what forecasts
    follow where something is unexplained and they are better for it.
    """

    model: Model
    data: Data
    base: Trial
    ranking: tuple[Ranked, ...]
    seconds: tuple[Second, ...]
    effect: str
    confidence: float
    why: str
    also: tuple[str, ...]
    accepted: tuple[Trial, ...]
    pattern: tuple[Place, ...]
    before: Score
    after: Score
    forecasts_before: Forecasts
    forecasts_after: Forecasts

    @property
    def places(self) -> tuple[Place, ...]:
        """What the new model has that the plain one has not: the effects, or the pattern, where each acts."""
        return (*(trial.candidate.place for trial in self.accepted), *self.pattern)


CERTAIN_MISFIT_PROBABILITY = 0.99
"""Probability that something is missing from which on it is reported even if no known effect forecasts better. [1]"""
MAX_FIRST_EFFECTS = 3
"""Effects beside which a second one is looked for."""
MIN_LOG_ODDS_TO_NAME = -2.0
"""Log odds against the plain model that an effect needs for that. [nat]"""
MOST_EFFECTS = 4
"""At once: as long as adding one convinces and helps, another is looked for. [1]"""
SECOND = 0.5
"""Log evidence that a second one must add at first sight to be looked at more closely. [nat]"""
LOG_ODDS_TO_PAIR = 6.0
"""Log odds behind the strongest effect from which on an effect is not tried in a pair. [nat]"""
_NOT_YET = "; flights left out do not show it yet: look again after the next ones"
_NO_BETTER = "but flights that were not seen are forecast no better with it, so it is left out until more have flown"


@dataclass(frozen=True, slots=True)
class _Verdict:
    effect: str
    confidence: float
    why: str
    also: tuple[str, ...] = ()
    accepted: tuple[Trial, ...] = ()
    pattern: tuple[Place, ...] = ()


def diagnose(model: Model, data: Data, on_progress: ReportProgress = no_op, given: Sequence[str] = ()) -> Diagnosis:
    """Weigh everything that could be missing from a model against the flights that teach.

    `given` are effects to take whatever the evidence for them, each where it is most at home. Raises UnknownEffect
    for one that is none, or that these flights cannot show.
    """
    truth, seen = data.values[:, 0], data.seen[:, 0]
    families = by_effect([*effect_candidates(model, seen), *pattern_candidates(model)])
    _check(given, families)
    base, trials = _search(model, data, fit(model, data), families, part(on_progress, 0.0, 0.5))
    ranking = rank(trials, base, truth, seen)
    before = forecasts_of(base.left_out)
    plain_score = score(before, truth, seen)
    seconds: tuple[Second, ...] = ()
    if given:
        chosen = _given(ranking, data, families, given)
        after, verdict = chosen.forecasts, _accepted((*ranking, chosen), chosen)
    else:
        seconds = _seconds(ranking, data, families, on_progress)
        options = _further(
            (*ranking, *(pair for second in seconds for pair in second.ranking)), data, families, on_progress
        )
        after = choose_in_folds(options, before)
        verdict = _verdict(options, choose(options), score(after, truth, seen), plain_score)
    if verdict.effect == "none":
        after = before
    judged = score(after, truth, seen)
    yet = judged.mae > plain_score.mae and (verdict.accepted or verdict.pattern)
    return Diagnosis(
        model=model,
        data=data,
        base=base,
        ranking=ranking,
        seconds=seconds,
        effect=verdict.effect,
        confidence=verdict.confidence,
        why=verdict.why + (_NOT_YET if yet else ""),
        also=verdict.also,
        accepted=verdict.accepted,
        pattern=verdict.pattern,
        before=plain_score,
        after=judged,
        forecasts_before=before,
        forecasts_after=after,
    )


Families = Mapping[str, Sequence[Candidate]]
"""Candidates by the effect that a verdict would speak of, patterns under no name."""


def _seconds(
    ranking: Sequence[Ranked], data: Data, families: Families, on_progress: ReportProgress
) -> tuple[Second, ...]:
    """Second effects beside the likeliest ones."""
    found: list[Second] = []
    for number, first in enumerate(firsts := likely_firsts(ranking)):

        def said(text: str, share: float, done: int = number, name: str = first.effect) -> None:
            on_progress(f"{name or 'a pattern'} and {text}", 0.5 + 0.5 * (done + share) / len(firsts))

        found.append(_beside(first, data, _others(first, families), said))
    return tuple(found)


def _further(
    options: tuple[Ranked, ...], data: Data, families: Families, on_progress: ReportProgress
) -> tuple[Ranked, ...]:
    """The options, and what is tried beside the best two effects, the best three, as long as those may be chosen."""
    for count in range(2, MOST_EFFECTS):
        best = choose([item for item in options if len(item.effects) == count])
        if best is None or best.weight < max(item.weight for item in options) - LOG_ODDS_TO_PAIR:
            break

        def said(text: str, share: float, names: str = "+".join(best.effects)) -> None:
            on_progress(f"{names} and {text}", 1.0)

        options = (*options, *_beside(best, data, _others(best, families), said).ranking)
    return options


def _others(first: Ranked, families: Families) -> Families:
    """The effects that are not in an option yet."""
    return {name: family for name, family in families.items() if name and name not in first.effects}


def _beside(first: Ranked, data: Data, families: Families, on_progress: ReportProgress) -> Second:
    """Every family tried beside an effect in the place in which that is most at home."""
    fitted = first.best.fit
    worth = fitted.log_evidence + SECOND
    with_first, found = _search(fitted.model, data, fitted, families, on_progress, searches=1, worth=worth)
    return Second(first, with_first, rank(found, with_first, data.values[:, 0], data.seen[:, 0], beside=first))


def _given(ranking: Sequence[Ranked], data: Data, families: Families, given: Sequence[str]) -> Ranked:
    """The effects named, each put where it is most at home beside those before it."""
    first, *others = given
    chosen = next(item for item in ranking if item.effect == first)
    for name in others:
        (chosen,) = _beside(chosen, data, {name: families[name]}, no_op).ranking
    return chosen


def _check(given: Sequence[str], families: Families) -> None:
    """Raise UnknownEffect for a name that is no effect here, or given twice."""
    for number, name in enumerate(given):
        if not name or name not in families or name in given[:number]:
            could = ", ".join(sorted(name for name in families if name))
            raise UnknownEffect(f"found the effect {name!r}, expected one that these flights could show: {could}")


def _search(
    model: Model,
    data: Data,
    plain: Fit,
    families: Families,
    on_progress: ReportProgress,
    searches: int = MAX_SEARCHES,
    worth: float = -np.inf,
) -> tuple[Trial, list[Trial]]:
    """Every candidate tried beside a model, and the model itself, whose best fit the trials help to find."""
    count = sum(len(family) for family in families.values())
    for turn in range(searches):

        def done(share: float, turn: int = turn) -> None:
            on_progress(f"{count} candidates", (turn + share) / searches)

        trials = try_all(model, data, families, plain, worth, done)
        better = plain_again(model, data, plain, trials)
        settled = better.log_evidence < plain.log_evidence + 0.3
        plain = better
        if settled:
            break
    return plain_trial(plain), trials


def likely_firsts(ranking: Sequence[Ranked]) -> list[Ranked]:
    """The options beside which a second effect may be there: the likeliest effects if they are likely at all, and the
    patterns if they are no less so; what patterns imitate does not hide the effects that are there."""
    likely = sorted(ranking, key=lambda item: -item.weight)[:MAX_FIRST_EFFECTS]
    best = max((item.weight for item in likely if item.effect), default=-np.inf)
    return [item for item in likely if item.weight > max(best - LOG_ODDS_TO_PAIR, MIN_LOG_ODDS_TO_NAME)]


def _verdict(options: Sequence[Ranked], chosen: Ranked | None, after: Score, before: Score) -> _Verdict:
    """What is said of the option chosen, if it forecasts flights not seen well enough when all is done without them."""
    if chosen is None or not stands(chosen, after, before):
        return _rejected(options)
    if "" in chosen.effects:
        place = chosen.accepted[0].candidate.place.where
        why = f"the flights differ from the model together with {place}, and no known effect accounts for it"
        places = tuple(trial.candidate.place for trial in chosen.accepted)
        return _Verdict("unexplained", probability(options), why, pattern=places)
    return _accepted(options, chosen)


def _accepted(options: Sequence[Ranked], chosen: Ranked) -> _Verdict:
    """The verdict for an option, and the effects that these flights cannot tell from those in it; then, of two at
    once, whole verdicts that could stand in its place."""
    alike = [item for item in options if len(item.effects) == len(chosen.effects) and "" not in item.effects]
    near = [item.effects for item in alike if item.weight > chosen.weight - LOG_EVIDENCE_TIE]
    other = [name for effects in near for name in effects if name not in chosen.effects]
    joined = ["+".join(effects) for effects in near if len(effects) > 1 and set(effects) != set(chosen.effects)]
    also = tuple(dict.fromkeys([*other, *joined]))
    sure = confidence(chosen, options)
    return _Verdict("+".join(chosen.effects), sure, _because(chosen.accepted), also, chosen.accepted)


def _rejected(options: Sequence[Ranked]) -> _Verdict:
    """Nothing is accepted: because nothing is there, or because what is there helps no forecast."""
    something = probability(options)
    best = max(options, key=lambda item: item.weight, default=None)
    if best is None or best.weight < 0:
        why = "the flights differ from the model by no more than their own scatter, as far as they can show"
        return _Verdict("none", 1 - something, why)
    why = f"{best.best.candidate.place if best.effect else best.best.candidate.place.where} fits best, {_NO_BETTER}"
    certain = best.weight > np.log(CERTAIN_MISFIT_PROBABILITY / (1 - CERTAIN_MISFIT_PROBABILITY))
    return _Verdict("unexplained", something, why) if certain else _Verdict("none", 1 - something, why)


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
