"""The search for probable sets of effects: each alone, then others added to the probable sets.

The search only decides which sets are tried (Occam's window: Madigan and Raftery, Journal of the American Statistical
Association 89, 1994). Sets that are not tried get no probability; the others get theirs from their evidence.
"""

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import replace
from math import log

import numpy as np

from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.importance import sampled
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.inference.laplace.scale_grids import around_mode, with_probable_motors
from fieldkit.model.readout_data import Data
from fieldkit.model.rocket_model import Model
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.quantities import counted
from fieldkit.selection.candidates import Candidate, Place
from fieldkit.selection.hypotheses import Hypothesis, Members, SetPosterior, members_of, prior_of
from fieldkit.selection.pair_screen import pair_weights
from fieldkit.selection.prior import UNEXPLAINED, log_prior_odds
from fieldkit.selection.screen import screened
from fieldkit.selection.trial import Trial, fitted_again, try_all

Families = Mapping[str, Sequence[Candidate]]
"""Candidates by the effect's name in a verdict; patterns have an empty name."""

MAX_EFFECTS = 4
"""Maximum number of effects in a set. [1]"""
MAX_EXPANSIONS = 8
"""Maximum number of sets to extend. [1]"""
WINDOW = log(50.0)
"""A set is not extended below these log odds against the most probable set: its extensions would be probable in at most
one case in fifty. [nat]"""
SIMPLER_WINDOW = log(5.0)
"""A set is not extended below these log odds against one of its subsets: Occam's window excludes sets that are less
probable than a simpler one, here with an allowance for effects that hide each other. [nat]"""
SCREENING_ERROR = 3.0
"""Allowance for error in the log evidence of a linear model. [nat]"""
MAX_SEARCHES = 2
"""Maximum number of rounds of trials, which are repeated if they improve the plain model's fit. [1]"""
SETTLED_CHANGE = 0.3
"""The plain model's fit has converged if its log evidence changes by less than this. [nat]"""
SAMPLED_WINDOW = log(50.0)
"""Hypotheses within these log odds of the most probable one are checked by importance sampling. [nat]"""
MAX_SAMPLED = 8
"""Maximum number of hypotheses to check. [1]"""
MAX_REFINED = 12
"""Maximum number of hypotheses whose scales are integrated on finer grids, to choose those to check. [1]"""
SEED = 19
"""Seed of the draws, the same for every hypothesis."""


def explore(
    model: Model, data: Data, families: Families, on_progress: ReportProgress = no_op, *, pairs: bool = True
) -> SetPosterior:
    """The posterior over everything that was tried; without `pairs` each effect alone. Raises ImpossibleFlight for a
    flight without a dry mass."""
    plain, singles, couples = _singles(model, data, families, part(on_progress, 0.0, 0.5))
    sets = {frozenset[str](): [Hypothesis((), plain)]}
    for name in families:
        members = frozenset({name or UNEXPLAINED})
        own = [trial for trial in singles if trial.candidate.effect == name]
        if not own:
            continue
        sets[members] = [Hypothesis((t.candidate,), t.fit, prior_of([t.candidate])) for t in own]

    def extend(parent: Members, names: Iterable[str]) -> None:
        others = {name: families[name] for name in names if (name or UNEXPLAINED) not in parent}
        _add(sets, _expanded(sets[parent], data, others, _weight(sets[_best(sets)])))

    def extend_probable() -> None:
        while len(done) < MAX_EXPANSIONS and (parent := _next(sets, done)) is not None:
            on_progress(f"{'+'.join(sorted(parent))} and others", 0.5 + 0.3 * len(done) / MAX_EXPANSIONS)
            done.add(parent)
            extend(parent, families)

    done: set[Members] = set()
    if pairs:
        extend_probable()
        for single, partners in _hidden(sets, couples, done).items():
            extend(single, partners)
        extend_probable()
    every = SetPosterior(tuple(one for some in sets.values() for one in some))
    return checked(every, part(on_progress, 0.8, 0.2))


def chain(plain: Fit, data: Data, families: Families, given: Sequence[str]) -> list[Hypothesis]:
    """Given effects, each tried in all its places together with the earlier ones in their most probable places. Raises
    ImpossibleFlight for a flight without a dry mass."""
    found = [Hypothesis((), plain)]
    for name in given:
        (found,) = _expanded(found, data, {name: families[name]}, -np.inf).values()
    return found


def checked(
    posterior: SetPosterior, on_progress: ReportProgress = no_op, window: float = SAMPLED_WINDOW
) -> SetPosterior:
    """The posterior with the evidence of its probable hypotheses checked by the simulator.

    A hypothesis is probable if its log odds against the best are within `window` [nat]; the plain model is always
    checked. The others get the mean correction of the probable sets that share most effects with them. Corrections
    of improbable sets are not used: far from the flights the error of a linear fit may be tens of nats. Raises
    ImpossibleFlight for a flight without a dry mass.
    """
    plain, likely = posterior.best(frozenset()), _likely(posterior, window)
    every = [*likely, *([] if any(one is plain for one, _ in likely) else [(plain, around_mode(plain.fit))])]
    found: dict[tuple[Place, ...], Hypothesis] = {}
    for number, (one, fine) in enumerate(every):
        on_progress("checking the probable ones", number / len(every))
        drawn = sampled(fine, np.random.default_rng(SEED), causes=True)
        found[one.places] = replace(one, correction=drawn.log_evidence - one.fit.log_evidence, sampled=drawn)
    lent: dict[Members, float] = {}
    for one, _ in likely or every:
        lent.setdefault(one.members, found[one.places].correction)
    return SetPosterior(
        tuple(
            found.get(one.places) or replace(one, correction=_borrowed(one.members, lent))
            for one in posterior.hypotheses
        )
    )


def _likely(posterior: SetPosterior, window: float) -> list[tuple[Hypothesis, Fit]]:
    """The probable hypotheses, most probable first, each with its fit whose scales are integrated around their mode."""
    order = sorted(posterior.hypotheses, key=lambda one: -one.log_weight)
    near = [one for one in order if one.log_weight > order[0].log_weight - window - SCREENING_ERROR][:MAX_REFINED]
    fits = [around_mode(one.fit).unsolved() for one in near]
    weight = np.array([one.log_prior + fine.log_evidence for one, fine in zip(near, fits, strict=True)])
    best = weight.max(initial=-np.inf, where=np.isfinite(weight))
    rows = [int(row) for row in np.argsort(-weight) if weight[row] > best - window]
    return [(near[row], fits[row]) for row in rows[:MAX_SAMPLED]]


def _borrowed(members: Members, lent: Mapping[Members, float]) -> float:
    """The mean correction of the checked sets that share the most effects with a set. [nat]"""
    shared = {own: len(own & members) for own in lent}
    most = max(shared.values())
    return float(np.mean([lent[own] for own, count in shared.items() if count == most]))


def _singles(
    model: Model, data: Data, families: Families, on_progress: ReportProgress
) -> tuple[Fit, list[Trial], dict[Members, float]]:
    """The plain fit, which the trials may improve, every candidate added to it, and the log weight of every pair
    according to its screening."""
    plain = with_probable_motors(fit(model, data, outlier_flights=True))
    model = plain.model
    count = sum(len(family) for family in families.values())
    for turn in range(MAX_SEARCHES):

        def report(fraction: float, turn: int = turn) -> None:
            on_progress(f"{counted(count, 'possible cause')}", (turn + fraction) / MAX_SEARCHES)

        worthy, near = screened(families, plain), plain
        trials = try_all(model, data, worthy, near, on_progress=report)
        plain = fitted_again(model, data, near, trials)
        if plain.log_evidence < near.log_evidence + SETTLED_CHANGE:
            break
    couples = {
        pair: near.log_evidence + odds for pair, odds in pair_weights(worthy.families, worthy.columns, near).items()
    }
    return plain, trials, couples


def _hidden(
    sets: Mapping[Members, Sequence[Hypothesis]], couples: Mapping[Members, float], done: Set[Members]
) -> dict[Members, list[str]]:
    """The partners of effects that were not extended, in pairs that are probable according to their screening: two
    effects may hide each other."""
    least = _weight(sets[_best(sets)]) - SIMPLER_WINDOW - SCREENING_ERROR
    found: dict[Members, list[str]] = {}
    for pair, weight in couples.items():
        alone = sorted(
            (one for name in pair if (one := frozenset({name})) in sets), key=lambda one: -_weight(sets[one])
        )
        if weight > least and alone and done.isdisjoint(alone):
            found.setdefault(alone[0], []).extend(pair - alone[0])
    return found


def _add(sets: dict[Members, list[Hypothesis]], more: Mapping[Members, list[Hypothesis]]) -> None:
    """Keep the more probable hypotheses of each set."""
    for members, found in more.items():
        if members not in sets or _weight(found) > _weight(sets[members]):
            sets[members] = found


def _weight(some: Sequence[Hypothesis]) -> float:
    return float(np.logaddexp.reduce([one.log_weight for one in some]))


def _best(sets: Mapping[Members, Sequence[Hypothesis]]) -> Members:
    return max(sets, key=lambda members: _weight(sets[members]))


def _next(sets: Mapping[Members, Sequence[Hypothesis]], done: set[Members]) -> Members | None:
    """The most probable set that is not yet extended; None if none is probable enough."""
    weight = {members: _weight(some) for members, some in sets.items()}
    least = max(weight.values()) - WINDOW

    def open_to_more(one: Members) -> bool:
        simpler = max(own for other, own in weight.items() if other < one)
        return weight[one] > max(least, simpler - SIMPLER_WINDOW)

    found = [one for one in sets if 0 < len(one) < MAX_EFFECTS and one not in done and open_to_more(one)]
    return max(found, key=lambda one: weight[one], default=None)


def _expanded(
    parents: Sequence[Hypothesis], data: Data, others: Families, best: float
) -> dict[Members, list[Hypothesis]]:
    """Each other effect added to a set, with the set's effects in their most probable places.

    The relative evidence of its other places, and of those that its own log prior includes, is assumed to be the same
    as without the added effect. `best` is the log weight of the most probable set.
    """
    parent = max(parents, key=lambda one: one.log_weight)
    elsewhere = _weight(parents) - parent.log_evidence - prior_of(parent.candidates)
    least = best - WINDOW - SCREENING_ERROR - _weight(parents)
    worth = {name: least - log_prior_odds([name or UNEXPLAINED]) for name in others}
    trials = try_all(parent.fit.model, data, screened(others, parent.fit, worth), parent.fit)
    found: dict[Members, list[Hypothesis]] = {}
    for trial in trials:
        candidates = (*parent.candidates, trial.candidate)
        one = Hypothesis(candidates, trial.fit, prior_of(candidates) + elsewhere)
        found.setdefault(members_of(candidates), []).append(one)
    return found
