"""The law of several climbs: the terms of the missing force that recur from flight to flight.

Each flight has separate coefficients, because motors and rockets scatter. A term is added if the joint information
criterion of the flights falls even without the flight that supports it most, and if its mean over the flights is
significant given their variation, so no single flight decides. The variation between flights is at least the effect of
the scatter in thrust and burn time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import ndtri, stdtrit

from fieldkit.selection.force.regression import Regression, forward, price
from fieldkit.selection.force.terms import ForceTerm
from fieldkit.shapes import Array, Float

MIN_CLIMBS = 2
"""Minimum number of climbs for a law. [1]"""
INTERVAL_LEVEL = 0.98
"""Level of the interval for a term's mean over the flights, which must exclude zero. [1]"""


@dataclass(frozen=True, slots=True)
class Common:
    """A recurring term: its mean over the flights and the standard deviation of the mean, in its unit.

    `gain` is its reduction of the criterion without the flight that supports it most; it reduces the criterion in
    `flights` of the `seen` flights that could show it. `also` are terms that would do nearly as well in its place.
    """

    term: ForceTerm
    value: float
    sd: float
    gain: float
    flights: int
    seen: int
    also: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Mean:
    """A coefficient's mean over the flights and its standard deviation, in the unit of the term: `observed` from their
    variation, and `expected` its lower bound, from the scatter of single flights."""

    value: float
    observed: float
    expected: float
    flights: int

    @property
    def sd(self) -> float:
        """The larger of both, in the unit of the term."""
        return max(self.observed, self.expected)

    def excludes_zero(self, candidates: int) -> bool:
        """Whether it excludes zero: by Student's t for the observed standard deviation, and by the normal distribution
        for the scatter, corrected for the number of candidates (Bonferroni)."""
        unsure = (1 - INTERVAL_LEVEL) / 2
        least = max(
            stdtrit(self.flights - 1, 1 - unsure) * self.observed,
            ndtri(1 - unsure / candidates) * self.expected,
        )
        return bool(abs(self.value) > least)


def common_law(climbs: Sequence[Regression], terms: Sequence[ForceTerm]) -> tuple[Common, ...]:
    """The fewest terms that recur in the missing force of several climbs, the most informative first."""
    if len(climbs) < MIN_CLIMBS:
        return ()
    known = {term.name: term for term in terms}
    scatters = {term.name: term.random_draw_sd for term in terms if term.random_draw_sd}
    candidates = [name for name in known if sum(name in climb.columns for climb in climbs) >= MIN_CLIMBS]
    chosen = forward(candidates, partial(_robust_gain, climbs, scatters, len(candidates)))
    names = [one.name for one in chosen]
    law = []
    for place, one in enumerate(chosen):
        mean = _mean(climbs, scatters, one.name, names)
        gains = _gains(climbs, names[:place], one.name)
        flights = int((gains > 0).sum())
        law.append(Common(known[one.name], mean.value, mean.sd, one.gain, flights, len(gains), one.also))
    return tuple(law)


def _robust_gain(
    climbs: Sequence[Regression], scatters: Mapping[str, float], candidates: int, chosen: list[str], name: str
) -> float:
    """A term's reduction of the criterion without the flight that supports it most; zero if flights disagree."""
    if not _mean(climbs, scatters, name, [*chosen, name]).excludes_zero(candidates):
        return -np.inf
    gains = _gains(climbs, chosen, name)
    return float(gains.sum() - gains.max()) - price(len(chosen), candidates)


def _gains(climbs: Sequence[Regression], chosen: Sequence[str], name: str) -> Float[Array, "seen"]:
    """A term's reduction of the criterion of each flight that could show it."""
    able = [(climb, _shown(climb, chosen)) for climb in climbs if name in climb.columns]
    return np.array([climb.cost(before) - climb.cost([*before, name]) for climb, before in able])


def _mean(climbs: Sequence[Regression], scatters: Mapping[str, float], name: str, names: Sequence[str]) -> Mean:
    """A coefficient over the flights that could show it, in a law with these terms.

    Flights vary by more than their errors: the variation between them is estimated as in DerSimonian and Laird
    (Controlled Clinical Trials 7, 1986) and is at least the scatter of single flights, because a few may agree by
    chance.
    """
    each = []
    for climb in climbs:
        if name in climb.columns:
            able = _shown(climb, names)
            place = able.index(name)
            each.append([column[place] for column in (*climb.solve(able), climb.random_draw_sd(able, scatters))])
    value, sd, random_draw_sd = np.array(each).T
    weight = 1 / sd**2
    middle = weight @ value / weight.sum()
    excess = weight @ (value - middle) ** 2 - (len(value) - 1)
    between = max(excess / (weight.sum() - (weight**2).sum() / weight.sum()), 0.0)
    weight_between, least = 1 / (sd**2 + between), 1 / (sd**2 + random_draw_sd**2)
    weight = np.minimum(weight_between, least)
    observed, expected = float(weight_between.sum() ** -0.5), float(least.sum() ** -0.5)
    return Mean(float(weight @ value / weight.sum()), observed, expected, len(value))


def _shown(climb: Regression, names: Sequence[str]) -> list[str]:
    return [name for name in names if name in climb.columns]
