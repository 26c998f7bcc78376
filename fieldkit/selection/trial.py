"""Trials of candidates: parallel fits of the plain model, or of one with effects, plus each candidate."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.inference.laplace.fit import MAX_LOG_EVIDENCE_BEHIND, Lane, fit_lanes
from fieldkit.inference.laplace.linearization import known_angle_slope
from fieldkit.inference.laplace.posterior import Fit, probable_scales
from fieldkit.model.readout_data import Data
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.simulated_readouts import shown
from fieldkit.physics.effect import Effect
from fieldkit.selection.candidates import EACH_GROUP, Candidate, Place
from fieldkit.selection.screen import Screened
from fieldkit.shapes import Array, Float

MAX_RESTARTS = 3
"""Number of trials from whose end points a model is refitted. [1]"""
REACH_SDS = 8.0
"""Range of the integral over a strength, in standard deviations. [1]"""
NODES = 4001
"""Number of points of this integral. [1]"""


@dataclass(frozen=True, slots=True)
class Trial:
    """A candidate with the fit of a model that includes it, alone or with others."""

    candidate: Candidate
    fit: Fit

    @property
    def unit(self) -> str:
        """Unit of the strength; empty for a pattern."""
        bends = self.candidate.terms[0].bends if self.candidate.terms else ""
        return bends.unit if isinstance(bends, Effect) else ""

    def strength(self) -> tuple[float, float]:
        """Posterior mean and standard deviation of the strength, within its bounds, in the effect's unit.

        For an effect with a strength in every group, it is the root mean square over the groups.
        """
        names = [term.name for term in self.candidate.terms]
        index = [self.fit.model.names.index(name) for name in names]
        means, sds = self.fit.moments()
        if self.candidate.place.where == EACH_GROUP:
            return float(np.sqrt((means[index] ** 2).mean())), float(np.sqrt((sds[index] ** 2).mean()))
        return strength_moments(self.candidate.terms[0], float(means[index[0]]), float(sds[index[0]]))


def strength_moments(term: Term, mean: float, sd: float) -> tuple[float, float]:
    """Mean and standard deviation of a strength, in the unit of its effect, from those of the fitted value's normal
    posterior before its truncation at the bounds of the term.

    Derivation: the integral of the strength and of its square over the density within the bounds.
    """
    low = max(term.low, min(mean, term.high) - REACH_SDS * sd)
    high = min(term.high, max(mean, term.low) + REACH_SDS * sd)
    values = np.linspace(low, high, NODES)
    log_density = -0.5 * ((values - mean) / sd) ** 2
    weight = np.exp(log_density - log_density.max())
    strength = term.bends.strength(values) if isinstance(term.bends, Effect) else values
    middle = float(np.average(strength, weights=weight))
    return middle, float(np.sqrt(np.average((strength - middle) ** 2, weights=weight)))


def with_and_without(trial: Trial) -> dict[str, Float[Array, "2 flight"]]:
    """The readouts of every flight with the fitted effect and without it, all else equal.

    Derivation: the simulator, with the terms of the effect at their means and at zero. Raises ImpossibleFlight for a
    flight without a dry mass.
    """
    model = trial.fit.model
    mean, _ = trial.fit.moments()
    own = {term.name for term in trial.candidate.own}
    without = np.where([name in own for name in model.names], 0.0, mean)
    return shown(model, np.stack([mean, without]), {})


def try_all(
    model: Model,
    data: Data,
    worthy: Screened,
    near: Fit,
    on_progress: Callable[[float], None] | None = None,
) -> list[Trial]:
    """Fit the candidates of every effect in parallel, each from all its starts, starting at the end point of a smaller
    model.

    Candidates with negligible evidence compared with the best of their effect are dropped. Raises ImpossibleFlight for
    a flight without a dry mass.
    """
    families = worthy.families
    if not families:
        return []
    wide, lanes, owners = model, [], []
    base = tuple(range(len(model.terms)))
    for name, family in families.items():
        for candidate in family:
            own = tuple(range(len(wide.terms), len(wide.terms) + len(candidate.terms)))
            wide = wide.with_terms(*candidate.terms)
            for start in candidate.starts:
                step = worthy.steps[candidate.place, start]
                lanes.append(Lane((*base, *own), step.at, name, step))
                owners.append(candidate)
    fits = fit_lanes(
        wide,
        data,
        lanes,
        known_angle_slope(near.model, near.tangent),
        on_progress=on_progress,
        flight_weight=near.flight_weight,
        scales=probable_scales(near),
    )
    best: dict[Place, Fit] = {}
    for candidate, result in zip(owners, fits, strict=True):
        known = best.get(candidate.place)
        if known is None or result.log_evidence > known.log_evidence:
            best[candidate.place] = result.unsolved()
    return [trial for family in families.values() for trial in _with_a_say(family, best)]


def _with_a_say(family: Sequence[Candidate], best: Mapping[Place, Fit]) -> list[Trial]:
    least = max(best[candidate.place].log_evidence for candidate in family) - MAX_LOG_EVIDENCE_BEHIND
    kept = [candidate for candidate in family if best[candidate.place].log_evidence >= least]
    return [Trial(candidate, best[candidate.place]) for candidate in kept]


def fitted_again(model: Model, data: Data, known: Fit, trials: Sequence[Trial]) -> Fit:
    """A model refitted from the end points of its trials: an effect without influence may have led the other terms to a
    better optimum and must not get the credit. Raises ImpossibleFlight for a flight without a dry mass."""
    count = len(model.terms)
    best = {trial.candidate.effect: trial for trial in sorted(trials, key=lambda trial: trial.fit.log_evidence)}
    likely = sorted(best.values(), key=lambda trial: -trial.fit.log_evidence)[:MAX_RESTARTS]
    lanes = [Lane(tuple(range(count)), trial.fit.tangent.at[:count]) for trial in likely]
    angle_slope = known_angle_slope(known.model, known.tangent)
    fits = fit_lanes(model, data, lanes, angle_slope, flight_weight=known.flight_weight)
    return max([known, *fits], key=lambda result: result.log_evidence)


def by_effect(candidates: Sequence[Candidate]) -> dict[str, list[Candidate]]:
    """Candidates by the name of their effect; patterns have an empty name."""
    families: dict[str, list[Candidate]] = {}
    for candidate in candidates:
        families.setdefault(candidate.effect, []).append(candidate)
    return families
