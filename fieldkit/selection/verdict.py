"""The verdict: which effects to name, from the posterior and the costs of a false and a missed name.

A false name sends a flyer to fix what is not broken. A missed name costs less, because forecasts average over all
probable effects. A false name is assumed to cost twice as much as a missed one. The expected cost is then lowest if
exactly the effects with more than `NAMING_PROBABILITY` are named. An effect that is not named is denied only if its
absence has more than `NAMING_PROBABILITY`; in between the flights do not decide, and `also` lists it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.laplace.leave_one_out import own_variance
from fieldkit.messages import estimate, marked, message
from fieldkit.physics.effect import Effect, effects, spoken
from fieldkit.quantities import percent, with_sd
from fieldkit.selection.hypotheses import Hypothesis, Members, SetPosterior
from fieldkit.selection.model_check import ModelCheck
from fieldkit.selection.prior import UNEXPLAINED
from fieldkit.selection.trial import Trial, with_and_without

COST_OF_FALSE_NAME = 2.0
"""Ratio of the cost of a false name to that of a missed one. [1]"""
NAMING_PROBABILITY = COST_OF_FALSE_NAME / (COST_OF_FALSE_NAME + 1.0)
"""Minimum posterior probability for a name. [1]"""
MATCH_PROBABILITY = 0.8
"""Minimum probability that nothing is missing for a sentence that states it: one chance in five is too much. [1]"""
MAY_BE_MISSING = "something may be missing, but nothing is probable enough to name"
CREDIBLE_LEVEL = 0.9
"""Posterior probability of the credible sets that give a verdict's alternatives, the same as for all intervals. [1]"""


NEGLIGIBLE_SHIFT = 0.25
"""Root mean square change of the log apogees, in standard deviations of a single flight, below which an effect is not
named beside others: it raises the mean squared error of a forecast by at most a sixteenth. [1]"""


@dataclass(frozen=True, slots=True)
class LoopVerdict:
    """The verdict: an effect's name (several joined by `+`), "none" or "unexplained".

    `confidence` is the posterior probability that the verdict is right [1]: that all named effects are present, or one
    of `also` instead if only their sum is probable enough. `accepted` are the named effects, each in its place.
    """

    effect: str
    confidence: float
    why: str
    also: tuple[str, ...] = ()
    accepted: tuple[Trial, ...] = ()


def verdict(posterior: SetPosterior) -> LoopVerdict:
    """The verdict of lowest expected cost."""
    chances = {name: chance for name, chance in posterior.inclusion.items() if name != UNEXPLAINED}
    named = [name for name, chance in chances.items() if chance > NAMING_PROBABILITY]
    if named:
        return _named(posterior, named, _alternatives(posterior, named), posterior.all_of(named))
    group = _group(posterior, list(chances))
    if group:
        return _named(posterior, group[:1], tuple(group[1:]), posterior.any_of(group))
    something = 1 - posterior.nothing
    if something > NAMING_PROBABILITY:
        return LoopVerdict(UNEXPLAINED, something, _unexplained(posterior), tuple(_undecided(posterior)))
    return LoopVerdict("none", posterior.nothing, _nothing_named(posterior))


def given_verdict(posterior: SetPosterior, given: Sequence[str]) -> LoopVerdict:
    """The verdict if a flyer names the effects."""
    return _named(posterior, given, _alternatives(posterior, given), posterior.all_of(given))


def verdict_that_fits(found: LoopVerdict, check: ModelCheck, nothing: float) -> LoopVerdict:
    """The verdict after the check of the averaged model, which may leave something that the search does not describe.

    Each statement is right only if nothing unlisted acts, which lowers its probability. If something clearly is left,
    and a name, or that nothing is missing, has less than `NAMING_PROBABILITY`, the verdict is that something is
    unexplained. `nothing` is the posterior probability that the plain model lacks nothing. [1]
    """
    fits = 1 - check.unlisted
    something = 1 - nothing * fits
    if found.effect == UNEXPLAINED:
        return replace(found, confidence=something)
    sure = (nothing if found.effect == "none" else found.confidence) * fits
    doubted = something > NAMING_PROBABILITY if found.effect == "none" else sure <= NAMING_PROBABILITY
    if check.left is None or not doubted:
        why = MAY_BE_MISSING if found.effect == "none" and sure <= MATCH_PROBABILITY < nothing else found.why
        return replace(found, confidence=sure, why=why)
    but = "" if found.effect == "none" else f" beside {found.effect}"
    as_clear = f"a pattern as clear arises in {percent(check.p)} of such histories"
    why = f"no known effect explains {check.pattern}{but}; {as_clear}"
    names = () if found.effect == "none" else (found.effect,)
    return LoopVerdict(UNEXPLAINED, something, why, tuple(dict.fromkeys([*names, *found.also])))


def of_heights(found: LoopVerdict, posterior: SetPosterior) -> LoopVerdict:
    """The verdict without the effects that hardly change the apogees, if others do: a delay that is not the rated one
    moves the ejection by seconds, and the height of a flight that is at its top by little.

    Forecasts keep them. Raises ImpossibleFlight for a flight without a dry mass.
    """
    sizes = {trial.candidate.effect: _shift(trial) for trial in found.accepted}
    named = [name for name, size in sizes.items() if size > NEGLIGIBLE_SHIFT]
    if not named or len(named) == len(sizes):
        return found
    others = ", ".join(spoken(name) for name in sizes if name not in named)
    again = _named(posterior, named, _alternatives(posterior, named), posterior.all_of(named))
    beside = f"; forecasts also use {others}, which hardly changes the heights"
    return replace(again, why=message(marked(again.why) + beside))


def _shift(trial: Trial) -> float:
    """Root mean square change of the log apogees by an effect, on the flights on which it acts, in standard deviations
    of a single flight. [1]"""
    changed = with_and_without(trial)["apogee"]
    acts = np.any([term.weight != 0 for term in trial.candidate.own], axis=0) & trial.fit.data.seen[:, 0]
    off = np.log(changed[0] / changed[1])[acts & np.isfinite(changed).all(axis=0)]
    own = trial.fit.weights @ own_variance(trial.fit)
    return float(np.sqrt((off**2).mean() / own.mean())) if off.size else 0.0


def _group(posterior: SetPosterior, names: Sequence[str]) -> list[str]:
    """The smallest group of effects of which at least one is probably present, the most probable first; empty if there
    is none."""
    group: list[str] = []
    while len(group) < len(names):
        rest = [name for name in names if name not in group]
        group.append(max(rest, key=lambda name: posterior.any_of([*group, name])))
        if posterior.any_of(group) > NAMING_PROBABILITY:
            return group
    return []


def _undecided(posterior: SetPosterior) -> list[str]:
    """The effects that are too probable to deny, the most probable first; some of them may be probable enough to
    name."""
    return [
        name for name, chance in posterior.inclusion.items() if chance > 1 - NAMING_PROBABILITY and name != UNEXPLAINED
    ]


def _alternatives(posterior: SetPosterior, named: Sequence[str]) -> tuple[str, ...]:
    """What these flights do not distinguish from the named effects: effects that replace them in the credible sets,
    then those of these sets that have several effects, and those that add only undecided effects to the named."""
    total, singles, joined = 0.0, [], []
    undecided = set(_undecided(posterior))
    for members, chance in posterior.sets.items():
        if total > CREDIBLE_LEVEL:
            break
        total += chance
        known = members - {UNEXPLAINED}
        others = known - set(named)
        if not set(named) <= known:
            singles += sorted(others)
        elif not others or not others <= undecided:
            continue
        if len(known) > 1:
            joined.append("+".join(sorted(known)))
    return tuple(dict.fromkeys([*singles, *joined]))


def _named(posterior: SetPosterior, named: Sequence[str], also: tuple[str, ...], confidence: float) -> LoopVerdict:
    best = best_with(posterior, named)
    order = {candidate.effect: place for place, candidate in enumerate(best.candidates)}
    accepted = sorted((t for t in best.trials if t.candidate.effect in named), key=lambda t: order[t.candidate.effect])
    effect = "+".join(trial.candidate.effect for trial in accepted)
    return LoopVerdict(effect, confidence, in_words(accepted), also, tuple(accepted))


def best_with(posterior: SetPosterior, names: Sequence[str]) -> Hypothesis:
    """The most probable hypothesis with all of these."""
    sets: dict[Members, float] = {m: c for m, c in posterior.sets.items() if set(names) <= m}
    return posterior.best(max(sets, key=lambda members: sets[members]))


def _unexplained(posterior: SetPosterior) -> str:
    likely = next((members for members in posterior.sets if members), frozenset[str]())
    if UNEXPLAINED in likely:
        best = posterior.best(likely)
        pattern = next(place.pattern for place in best.places if place.pattern)
        return f"misses follow {pattern.in_words}, and no known effect explains them"
    names = ", ".join(name for name in posterior.inclusion if name != UNEXPLAINED)
    return f"the flights differ from the model, but no known effect is probable enough to name ({names})"


def _nothing_named(posterior: SetPosterior) -> str:
    """Why nothing is named: nothing seems missing, or nothing is probable enough."""
    if posterior.nothing > MATCH_PROBABILITY:
        return "the flights match the model within their scatter"
    known = effects().keys() & posterior.inclusion.keys()
    if not known:
        return MAY_BE_MISSING
    likely = max(known, key=lambda name: posterior.inclusion[name])
    return f"{MAY_BE_MISSING}; the most probable is {effects()[likely].title}, {posterior.inclusion[likely]:.0%}"


def in_words(accepted: Sequence[Trial]) -> str:
    """One sentence for a flyer: what is missing, on which flights, and how strong it is."""
    parts = []
    for trial in accepted:
        bends = trial.candidate.terms[0].bends
        assert isinstance(bends, Effect)
        mean, sd = trial.strength()
        place = f" ({trial.candidate.place})" if str(trial.candidate.place) != trial.candidate.effect else ""
        parts.append(f"{bends.explains}{place}: {_measured(mean, sd, bends.unit)}")
    return message("; ".join(parts))


def _measured(mean: float, sd: float, unit: str) -> str:
    """A strength with its standard deviation: fractions in percent, everything else in its unit."""
    if unit.startswith("fraction"):
        return f"{'' if mean < 0 else '+'}{with_sd(100 * mean, 100 * sd)}%{unit.removeprefix('fraction')}"
    return estimate(mean, sd, unit)
