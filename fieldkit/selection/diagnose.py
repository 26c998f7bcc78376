"""The search for effects that a rocket's model lacks, alone and together, weighted by evidence and averaged.

The reported errors are leave-one-out: each flight is forecast by fits and weights without it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.errors import UnknownEffect, nearest
from fieldkit.inference.laplace.leave_one_out import LeaveOneOut, leave_one_out
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import Data
from fieldkit.model.rocket_model import Model
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.scoring.score import Forecasts, Score, forecasts_of, score
from fieldkit.selection.averaged import left_out, that_pay
from fieldkit.selection.candidates import Averaged, Place, effect_candidates
from fieldkit.selection.hypotheses import Hypothesis, SetPosterior
from fieldkit.selection.logged_forces import (
    DRAG_STEP,
    LoggedForces,
    forces_check,
    step_candidate,
    with_probability,
    without_coast_drag,
)
from fieldkit.selection.model_check import ModelCheck, model_check
from fieldkit.selection.patterns import pattern_candidates
from fieldkit.selection.prior import UNEXPLAINED
from fieldkit.selection.search import Families, chain, checked, explore
from fieldkit.selection.trial import Trial, by_effect
from fieldkit.selection.verdict import LoopVerdict, given_verdict, of_heights, verdict, verdict_that_fits
from fieldkit.shapes import Array, Flags, Float

MIN_AVERAGED = 0.02
"""Minimum posterior probability of a hypothesis in the average. [1]"""
MAX_AVERAGED = 8
"""Maximum number of hypotheses in the average. [1]"""
NO_EFFECTS: Averaged = ((1.0, ()),)
"""The average of the plain model alone."""


@dataclass(frozen=True, slots=True)
class Ranked:
    """An effect (without a name for patterns) with its places, the best first.

    `log_bayes` is its log Bayes factor [nat] alone against the plain model, averaged over its places by their prior;
    `probability` is the probability that it is present, alone or with others; `score` is the leave-one-out score of its
    best place alone.
    """

    effect: str
    trials: tuple[Trial, ...]
    log_bayes: float
    probability: float
    score: Score

    @property
    def best(self) -> Trial:
        """The most probable place of the effect."""
        return self.trials[0]


@dataclass(frozen=True, slots=True)
class Plain:
    """The plain model's fit and its leave-one-out forecasts."""

    fit: Fit
    left_out: LeaveOneOut


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """The result of the search: the plain model, everything tried, the verdict, and leave-one-out errors before and
    after.

    `before` are the plain model's leave-one-out forecasts, `after` those averaged over all probable hypotheses where
    that pays (`that_pay`), and `fits` is the check of what these leave in the readouts and in
    the coasts of logs. `averaged` is the plain model
    alone if averaging does not pay and no effect was given.
    """

    model: Model
    data: Data
    base: Plain
    posterior: SetPosterior
    ranking: tuple[Ranked, ...]
    verdict: LoopVerdict
    averaged: Averaged
    before: Score
    after: Score
    forecasts_before: Forecasts
    forecasts_after: Forecasts
    fits: ModelCheck
    forces: LoggedForces | None
    """Forces along the flights' logs, if they were read."""

    @property
    def effect(self) -> str:
        """The name of the effect (several joined by `+`), "none" or "unexplained"."""
        return self.verdict.effect

    @property
    def confidence(self) -> float:
        """Posterior probability that the verdict is right. [1]"""
        return self.verdict.confidence

    @property
    def why(self) -> str:
        """The verdict in a sentence."""
        plain = self.averaged == NO_EFFECTS
        if not self.accepted or not (plain or self.after.mae > self.before.mae):
            return self.verdict.why
        use = ", so forecasts stay without a correction" if plain else ""
        return f"{self.verdict.why}; flights left out do not show it yet{use}: check again after more flights"

    @property
    def also(self) -> tuple[str, ...]:
        """Effects that these flights do not distinguish from the verdict's."""
        return self.verdict.also

    @property
    def accepted(self) -> tuple[Trial, ...]:
        """The named effects, each in its place."""
        return self.verdict.accepted

    @property
    def pattern(self) -> tuple[Place, ...]:
        """The pattern of the most probable hypothesis, if the verdict is unexplained."""
        places = self.posterior.best().places if self.effect == UNEXPLAINED else ()
        return tuple(place for place in places if not place.effect)


def diagnose(
    model: Model,
    data: Data,
    on_progress: ReportProgress = no_op,
    given: Sequence[str] = (),
    declined: Sequence[str] = (),
    forces: LoggedForces | None = None,
) -> Diagnosis:
    """Evaluate everything that could be missing from a model, using the flights in the fit.

    `given` are effects that are present whatever the evidence, and `declined` those that are absent; `forces` are
    those along the flights' logs. Raises UnknownEffect for an unknown effect, or one that these flights cannot show,
    ImpossibleFlight for a flight without a dry mass. Flights are simulated with the coarse settings of forecasts.
    """
    model, logged = replace(model, coarse=True), step_candidate(model, forces)
    if forces is not None and logged:
        data = without_coast_drag(data, model, forces)
    truth, seen = data.values[:, 0], data.seen[:, 0]
    families = by_effect([*effect_candidates(model, seen), *logged, *pattern_candidates(model)])
    _check([*given, *declined], families)
    families = {name: family for name, family in families.items() if (name or UNEXPLAINED) not in declined}
    posterior = explore(model, data, families, part(on_progress, 0.0, 0.85), pairs=not given)
    plain = posterior.best(frozenset())
    named, forecast_by = of_heights(verdict(posterior), posterior), posterior
    if given:
        pinned = checked(SetPosterior((plain, *chain(plain.fit, data, families, given))), window=np.inf)
        forecast_by = SetPosterior(pinned.hypotheses[1:])
        others = (one for one in posterior.hypotheses if one.members != frozenset(given))  # a single one was tried too
        named = given_verdict(SetPosterior((*others, *forecast_by.hypotheses)), given)
    switches = posterior.inclusion.get(DRAG_STEP, 0.0)
    fits = model_check(forecast_by, forces_check(forces, switches))
    if not given:
        named = verdict_that_fits(named, fits, posterior.nothing)
    before = left_out(SetPosterior((plain,)))
    after, pays = left_out(forecast_by, part(on_progress, 0.85, 0.15)), True
    if not given:
        after, pays = that_pay(before, after, truth, seen)
    return Diagnosis(
        model=model,
        data=data,
        base=Plain(plain.fit, leave_one_out(plain.fit)),
        posterior=posterior,
        ranking=_ranking(posterior, families, truth, seen),
        verdict=named,
        averaged=averaged(forecast_by) if pays else NO_EFFECTS,
        before=score(before, truth, seen),
        after=score(after, truth, seen),
        forecasts_before=before,
        forecasts_after=after,
        fits=fits,
        forces=with_probability(forces, switches) if forces is not None and logged else forces,
    )


def averaged(posterior: SetPosterior) -> Averaged:
    """The hypotheses in the average, most probable first."""
    probable = _probable(posterior)
    total = sum(chance for chance, _ in probable)
    return tuple((chance / total * part, places) for chance, one in probable for part, places in by_state(one.places))


def left_out_of_average(posterior: SetPosterior) -> float:
    """Posterior probability of the sets that are too improbable for the average, which is over the others as in Occam's
    window (Madigan and Raftery, Journal of the American Statistical Association 89, 1994). [1]"""
    return 1 - sum(chance for chance, _ in _probable(posterior))


def _probable(posterior: SetPosterior) -> list[tuple[float, Hypothesis]]:
    pairs = zip(posterior.probability.tolist(), posterior.hypotheses, strict=True)
    order = sorted(pairs, key=lambda pair: -pair[0])
    return [pair for pair in order if pair[0] > MIN_AVERAGED][:MAX_AVERAGED] or order[:1]


def by_state(places: tuple[Place, ...]) -> Averaged:
    """Effects in their places, with each probability of whether one that logs show acts on a flight ahead."""
    switched = next((place for place in places if place.switched is not None), None)
    if switched is None or switched.switched is None:
        return ((1.0, places),)
    chance = switched.switched.chance
    acting = replace(switched, switched=replace(switched.switched, ahead=True))
    return ((1 - chance, places), (chance, tuple(acting if place is switched else place for place in places)))


def _check(names: Sequence[str], families: Families) -> None:
    """Raise UnknownEffect for an unknown name, or one given twice."""
    for number, name in enumerate(names):
        if not name or name not in families or name in names[:number]:
            could = ", ".join(sorted(name for name in families if name))
            near = nearest(name, filter(None, families)) if name not in names[:number] else []
            hint = (
                f"; did you mean {' or '.join(near)}?"
                if near
                else f", expected one that these flights can show: {could}"
            )
            raise UnknownEffect(f"found the effect {name!r}{hint}")


def _ranking(
    posterior: SetPosterior, families: Families, truth: Float[Array, "flight"], seen: Flags
) -> tuple[Ranked, ...]:
    """Every effect, the most probable first, and of equal ones that with the stronger evidence when alone."""
    found = []
    for effect in families:
        name = effect or UNEXPLAINED
        own = sorted((one for one in posterior.hypotheses if one.members == {name}), key=lambda one: -one.log_weight)
        if not own:
            continue
        judged = score(forecasts_of(leave_one_out(own[0].fit)), truth, seen)
        trials = tuple(trial for one in own for trial in one.trials)
        chance = posterior.inclusion.get(name, 0.0)
        found.append(Ranked(effect, trials, posterior.log_bayes(name), chance, judged))
    return tuple(sorted(found, key=lambda item: (-item.probability, -item.log_bayes)))
