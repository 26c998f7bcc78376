"""The law of several climbs: the terms of the missing force that come back from flight to flight.

Each flight has coefficients of its own, for motors and rockets scatter. A term is taken while the information
criterion of all flights together falls without the flight that says most for it, and while its mean over the flights
stands clear of how it differs between them: so one flight alone decides nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from fieldkit.loop.force.regression import Regression, forward, price
from fieldkit.loop.force.terms import Term
from fieldkit.shapes import Array, Float

FEWEST = 2
"""Climbs from which on a law is asked for."""
SURE = 0.98
"""Of the interval of a term's mean over the flights that must leave out zero. [1]"""


@dataclass(frozen=True, slots=True)
class Common:
    """A term that comes back: its mean over the flights with the standard deviation of that mean.

    `gain` is what it takes off the criterion without the flight that says most for it; it does so in `flights` of
    those `seen` that could show it. `also` are terms that would have done nearly as well in its place.
    """

    term: Term
    value: float
    sd: float
    gain: float
    flights: int
    seen: int
    also: tuple[str, ...]


def common_law(climbs: Sequence[Regression], terms: Sequence[Term]) -> tuple[Common, ...]:
    """The fewest terms that come back in the missing force of several climbs, the most telling first."""
    if len(climbs) < FEWEST:
        return ()
    known = {term.name: term for term in terms}
    candidates = [name for name in known if sum(name in climb.columns for climb in climbs) >= FEWEST]
    chosen = forward(candidates, partial(_steady_gain, climbs, len(candidates)))
    names = [one.name for one in chosen]
    law = []
    for place, one in enumerate(chosen):
        value, sd, _ = _mean(climbs, one.name, names)
        gains = _gains(climbs, names[:place], one.name)
        law.append(Common(known[one.name], value, sd, one.gain, int((gains > 0).sum()), len(gains), one.also))
    return tuple(law)


def _steady_gain(climbs: Sequence[Regression], candidates: int, chosen: list[str], name: str) -> float:
    """What a term takes off the criterion without the flight that says most for it; none where flights disagree."""
    mean, sd, count = _mean(climbs, name, [*chosen, name])
    if abs(mean) < _reach(count) * sd:
        return -np.inf
    gains = _gains(climbs, chosen, name)
    return float(gains.sum() - gains.max()) - price(len(chosen), candidates)


def _gains(climbs: Sequence[Regression], chosen: Sequence[str], name: str) -> Float[Array, "seen"]:
    """What a term takes off the criterion of each flight that could show it."""
    able = [(climb, _shown(climb, chosen)) for climb in climbs if name in climb.columns]
    return np.array([climb.cost(before) - climb.cost([*before, name]) for climb, before in able])


def _mean(climbs: Sequence[Regression], name: str, names: Sequence[str]) -> tuple[float, float, int]:
    """A coefficient's mean over the flights, its standard deviation, and the number of flights that could show it.

    Flights differ by more than their errors: the spread between them is estimated as in DerSimonian and Laird
    (Controlled Clinical Trials 7, 1986).
    """
    each = []
    for climb in climbs:
        if name in climb.columns:
            shown = _shown(climb, names)
            values, sds = climb.solve(shown)
            each.append((values[shown.index(name)], sds[shown.index(name)]))
    value, sd = np.array(each).T
    weight = 1 / sd**2
    middle = weight @ value / weight.sum()
    excess = weight @ (value - middle) ** 2 - (len(value) - 1)
    between = max(excess / (weight.sum() - (weight**2).sum() / weight.sum()), 0.0)
    weight = 1 / (sd**2 + between)
    return float(weight @ value / weight.sum()), float(weight.sum() ** -0.5), len(value)


def _reach(flights: int) -> float:
    """Standard deviations of a mean over so few flights that hold `SURE` of Student's distribution."""
    from scipy.special import stdtrit

    return float(stdtrit(flights - 1, (1 + SURE) / 2))


def _shown(climb: Regression, names: Sequence[str]) -> list[str]:
    return [name for name in names if name in climb.columns]
