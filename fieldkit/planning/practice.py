"""The practice flights that narrow the forecast of a contest's finals most, and how well the rocket can be set.

Derivation: the logarithms of the apogees of flights at several masses are jointly close to normal. They share what is
unknown about the rocket (covariance M), and each has a scatter of its own (variance q). After practice flights P the
variance of a flight t is M_tt + q_t - M_tP (M_PP + q_P)^-1 M_Pt, by conditioning (Rasmussen and Williams, Gaussian
Processes for Machine Learning, 2006, equation A.6). M is the covariance of two independent flights of the same drawn
rockets. Mass and parachute can be set no better than apogee and descent are known: the standard deviation of the mass
is that of the apogee, without the scatter of single flights, over the slope of the apogee by mass; that of the area is
twice that of the log descent speed, which falls with the root of the area.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from fieldkit.planning.contest import Season
from fieldkit.planning.finals import FinalsRow, TrialFlights
from fieldkit.planning.forecasts import Plan
from fieldkit.shapes import Array, Float

PRACTICE_DRAWS = 4000
"""Number of rockets drawn for the covariance of their flights. [1]"""
CANDIDATES = 3
"""Number of masses among which practice flights are chosen, from the lightest to the heaviest of the finals. [1]"""
MOST_PRACTICE_FLIGHTS = 4
"""Largest number of practice flights that are planned together. [1]"""
TRIMMED = 0.005
"""Fraction of draws at either end that count as the nearest other one, because tails have no normal covariance. [1]"""


@dataclass(frozen=True, slots=True)
class Setting:
    """How well a rocket can be set for a target: dry mass [kg] and parachute area relative to the current one [1], each
    with the standard deviation that the forecast leaves; None if the descent is not measured."""

    row: FinalsRow
    mass_sd: float
    area_sd: float | None


@dataclass(frozen=True, slots=True)
class PracticePlan:
    """Practice flights with these dry masses [kg], each timed, and what they leave: the standard deviation of the log
    apogee of a finals flight, that of its log descent speed, and the mean points of the finals, all on average over the
    targets."""

    masses: tuple[float, ...]
    apogee_sd: float
    descent_sd: float
    points: float


@dataclass(frozen=True, slots=True)
class Practice:
    """The best practice plan for each number of flights, none first, and all plans of one flight, best first."""

    plans: tuple[PracticePlan, ...]
    single: tuple[PracticePlan, ...]


@dataclass(frozen=True, slots=True)
class _Shared:
    """Covariance of the log apogees of flights at some masses [kg] of one unknown rocket, and their own variances."""

    masses: tuple[float, ...]
    cov: Float[Array, "mass mass"]
    own: Float[Array, "mass"]


def setting(flown: TrialFlights, row: FinalsRow, shared_sd: float) -> Setting:
    """How well the mass and the area of a row are known; `shared_sd` is the standard deviation of the log apogee
    without the scatter of single flights. [1]"""
    middle = np.median(flown.apogee, axis=-1)
    slope = float(np.interp(row.mass, flown.masses, np.gradient(np.log(middle), flown.masses)))
    fall = flown.fall
    area = None if fall.assumed else 2 * row.area * float(np.sqrt(max(fall.relative_sd() ** 2 - fall.spread**2, 0.0)))
    return Setting(row, shared_sd / abs(slope), area)


def practice(plan: Plan, rule: Season, flown: TrialFlights, table: Sequence[FinalsRow]) -> tuple[Practice, float]:
    """The practice flights that narrow the finals most, among the masses of a table of finals, and the standard
    deviation of the log apogee without the scatter of single flights. [1]

    Raises ImpossibleFlight for a plan without a mass.
    """
    ends = sorted(row.mass for row in table)
    masses = tuple(dict.fromkeys(float(one) for one in np.linspace(ends[0], ends[-1], CANDIDATES)))
    shared = _shared(plan, masses)
    near = [int(np.argmin([abs(mass - row.mass) for mass in masses])) for row in table]

    def of(flights: tuple[int, ...]) -> PracticePlan:
        left = _left(shared, flights)[near]
        before = (np.diag(shared.cov) + shared.own)[near]
        slower = flown.fall.relative_sd(len(flights)) / flown.fall.relative_sd()
        points = [
            _points(flown, rule, row, float(ratio), slower)
            for row, ratio in zip(table, np.sqrt(left / before), strict=True)
        ]
        return PracticePlan(
            tuple(masses[one] for one in flights),
            float(np.sqrt(left.mean())),
            flown.fall.relative_sd(len(flights)),
            float(np.mean(points)),
        )

    def best(count: int) -> list[PracticePlan]:
        every = combinations_with_replacement(range(len(masses)), count)
        return sorted((of(one) for one in every), key=lambda one: one.apogee_sd)

    plans = [best(count)[0] for count in range(MOST_PRACTICE_FLIGHTS + 1)]
    return Practice(tuple(plans), tuple(best(1))), float(np.sqrt(np.diag(shared.cov).mean()))


def final_scores(
    rule: Season, known: Sequence[float], ahead: Float[Array, "draw declared"], left: int
) -> Float[Array, "draw"] | None:
    """The score of a season: the best of the declared flights that have points and of those that are left, by their
    forecast points; None if these are too few. [1]"""
    flown = np.broadcast_to(np.array(known), (len(ahead), len(known)))
    every = np.concatenate([flown, ahead[:, :left]], axis=1)
    return rule.sums(every) if every.shape[1] >= rule.best else None


def _shared(plan: Plan, masses: tuple[float, ...]) -> _Shared:
    """What flights at these dry masses [kg] have in common: each is drawn twice, with its own scatter."""
    made = plan.forecasts_at((*masses, *masses), draws=PRACTICE_DRAWS, paired=False)
    logs = np.log(np.maximum(np.stack([one.apogee for one in made]), 1.0))
    low, high = np.quantile(logs, [TRIMMED, 1 - TRIMMED], axis=1, keepdims=True)
    every, count = np.cov(np.clip(logs, low, high)), len(masses)
    cross = every[:count, count:]
    values, vectors = np.linalg.eigh((cross + cross.T) / 2)
    cov = (vectors * np.maximum(values, 0.0)) @ vectors.T
    total = (np.diag(every)[:count] + np.diag(every)[count:]) / 2
    return _Shared(masses, cov, np.maximum(total - np.diag(cov), 1e-8))


def _left(shared: _Shared, flights: tuple[int, ...]) -> Float[Array, "mass"]:
    """Variance of the log apogee of a flight at each mass after practice flights at some of them. [1]"""
    at = list(flights)
    known = np.zeros(len(shared.masses))
    if at:
        observed = shared.cov[np.ix_(at, at)] + np.diag(shared.own[at])
        to = shared.cov[:, at]
        known = np.einsum("tp,pt->t", to, np.linalg.solve(observed, to.T))
    return np.asarray(np.diag(shared.cov) - known + shared.own)


def _points(flown: TrialFlights, rule: Season, row: FinalsRow, apogee: float, descent: float) -> float:
    """Mean points for the target of a row, if the scatter about its medians shrinks by these ratios. [1]"""
    at = int(np.argmin(np.abs(flown.masses - row.mass)))
    area = flown.area_index(row.area)
    heights, times = flown.apogee[at], flown.duration[area, at]
    narrow = np.median(heights) + apogee * (heights - np.median(heights))
    timed = np.median(times) + descent * (times - np.median(times))
    timed = np.full_like(timed, np.nan) if flown.fall.assumed else timed
    return float(rule.announced(row.target, row.window).points(narrow, timed).mean())
