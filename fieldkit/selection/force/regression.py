"""Sparse regression on one climb: the residual of a choice of terms, and its extended information criterion.

Terms are added while the extended Bayesian information criterion falls (Chen and Chen, Biometrika 95, 2008), which has
a penalty for the number of candidates. Samples that a smoother has correlated count by their effective number.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from fieldkit.selection.force.climb import Missing
from fieldkit.selection.force.terms import ForceTerm
from fieldkit.shapes import Array, Float

CANDIDATE_COUNT_WEIGHT = 1.0
"""Weight of the number of candidates in the extended criterion. [1]"""
MAX_TERMS = 4
"""Maximum number of terms. [1]"""
MIN_RESIDUAL_FRACTION = 1e-3
"""Minimum fraction of a term that remains after the free terms are projected out. [1]"""
LEAST_DRAG = 0.1
"""Minimum drag of a climb as a fraction of the model's; with less, it does not constrain drag. [1]"""
CRITERION_TIE = 4.0
"""Another term is named with the chosen one if the criterion differs by no more than this. [1]"""


@dataclass(frozen=True, slots=True)
class ChosenTerm:
    """A term's name, its reduction of the criterion, and the terms that would do nearly as well."""

    name: str
    gain: float
    also: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Regression:
    """The missing force of a climb and the terms that it could show, in standard deviations of a sample.

    Free terms are projected out of all of them: a shift of the clock during the burn, and those given. `worth` is the
    effective number of independent samples in the record, and `spent` the number of free parameters. `drag` describes
    the drag if it is free.
    """

    wanted: Float[Array, "time"]
    columns: Mapping[str, Float[Array, "time"]]
    worth: float
    spent: int
    drag: "FreeDrag | None" = None

    def left(self, names: Sequence[str]) -> Float[Array, "time"]:
        """The residual after the terms with these names. [1]"""
        return _left(self.wanted, [self.columns[name] for name in names])

    def cost(self, names: Sequence[str]) -> float:
        """The information criterion of these terms without the penalty for choosing them; lower is better. [1]"""
        left = self.left(names)
        return self.worth * log(left @ left) + len(names) * log(self.worth)

    def solve(self, names: Sequence[str]) -> tuple[Float[Array, "term"], Float[Array, "term"]]:
        """Coefficients and their standard deviations; fractions of the drag are relative to the actual drag."""
        if not len(names):
            return np.zeros(0), np.zeros(0)
        unit = self._unit(names)
        basis = np.stack([self.columns[name] for name in names], axis=-1)
        left = self.left(names)
        scatter = float(left @ left) / max(self.worth - self.spent - len(names), 1.0)
        inverse = np.linalg.pinv(basis.T @ basis)
        return unit * (inverse @ (basis.T @ self.wanted)), unit * np.sqrt(np.diag(inverse) * scatter)

    def random_draw_sd(self, names: Sequence[str], scatters: Mapping[str, float]) -> Float[Array, "term"]:
        """Standard deviations of these terms' coefficients due to the scatter of single flights, given by name, in the
        unit of the term.

        Coefficients are linear in the force: one standard deviation along a column moves them by that multiple of
        their fit to the column.
        """
        patterns = [sd * self.columns[name] for name, sd in scatters.items() if name in self.columns]
        if not patterns:
            return np.zeros(len(names))
        basis = np.stack([self.columns[name] for name in names], axis=-1)
        moved = np.linalg.pinv(basis) @ np.stack(patterns, axis=-1)
        return np.asarray(self._unit(names) * np.linalg.norm(moved, axis=-1))

    def _unit(self, names: Sequence[str]) -> Float[Array, "term"]:
        """The scale of each of these coefficients when all are fitted together."""
        return self.drag.unit(names) if self.drag else np.ones(len(names))


@dataclass(frozen=True, slots=True, eq=False)
class FreeDrag:
    """The amount of drag in a climb, if it is free: terms that are fractions of the model's drag become fractions of
    it. The columns have nothing projected out; `place` is the index of the drag among those `given`."""

    force: Float[Array, "time"]
    given: Sequence[Float[Array, "time"]]
    place: int
    whole: Mapping[str, Float[Array, "time"]]
    shares: frozenset[str]

    def unit(self, names: Sequence[str]) -> Float[Array, "term"]:
        """The ratio of the model's drag to the climb's for terms that are fractions of it; 1 for the others. [1]"""
        value, *_ = np.linalg.lstsq(np.stack([*self.given, *(self.whole[n] for n in names)], axis=-1), self.force)
        factor = 1 / max(1 + float(value[self.place]), LEAST_DRAG)
        return np.array([factor if name in self.shares else 1.0 for name in names])


def regression(missing: Missing, terms: Sequence[ForceTerm], free: Collection[str] = ()) -> Regression:
    """The regression of a missing force on the terms that act along its climb.

    Terms named in `free` are projected out first and not tested.
    """
    sd, burning = missing.track.push_sd, missing.track.burning.sum() > 3
    whole = {term.name: term.column(missing) / sd for term in terms}
    given = [missing.steepness / sd] * bool(burning) + [whole.pop(name) for name in free]
    force = missing.force / sd
    wanted = _left(force, given)
    acting = {name: column for name, column in whole.items() if np.linalg.norm(column) > 1e-9}
    columns = {name: _left(column, given) for name, column in acting.items()}
    columns = {
        name: left
        for name, left in columns.items()
        if np.linalg.norm(left) > MIN_RESIDUAL_FRACTION * np.linalg.norm(acting[name])
    }
    drag = None
    if "drag" in free:
        twice = replace(missing, drag=2 * missing.drag)
        shares = {t.name for t in terms if t.name in columns and np.allclose(t.column(twice) / sd, 2 * whole[t.name])}
        drag = FreeDrag(force, given, int(burning) + list(free).index("drag"), whole, frozenset(shares))
    return Regression(wanted, columns, _worth(wanted, list(columns.values())), len(given), drag)


def forward(candidates: Collection[str], gain: Callable[[list[str], str], float]) -> tuple[ChosenTerm, ...]:
    """Terms added one by one while the best of the others reduces the criterion."""
    chosen: list[ChosenTerm] = []
    while len(chosen) < min(MAX_TERMS, len(candidates)):
        before = [one.name for one in chosen]
        gains = {name: gain(before, name) for name in candidates if name not in before}
        best = max(gains, key=lambda name: gains[name])
        if gains[best] <= 0:
            break
        least = max(gains[best] - CRITERION_TIE, 0.0)
        also = tuple(name for name in gains if name != best and gains[name] > least)
        chosen.append(ChosenTerm(best, gains[best], also))
    return tuple(chosen)


def price(terms: int, candidates: int) -> float:
    """The penalty for one more term, from the increase in the number of possible choices. [1]"""
    return 2 * CANDIDATE_COUNT_WEIGHT * log((candidates - terms) / (terms + 1))


def _left(wanted: Array, basis: Sequence[Array]) -> Array:
    if not len(basis):
        return wanted
    stacked = np.stack(basis, axis=-1)
    value, *_ = np.linalg.lstsq(stacked, wanted, rcond=None)
    return np.asarray(wanted - stacked @ value)


def _worth(wanted: Array, basis: Sequence[Array]) -> float:
    """Effective number of independent samples in the record, from the autocorrelation that no term explains.

    Sum of the autocorrelation of the full library's residual up to its first zero (Sokal's integrated time).
    """
    left = _left(wanted, basis)
    left = left - left.mean()
    power = np.correlate(left, left, "full")[len(left) - 1 :]
    if power[0] <= 0:
        return float(len(wanted))
    correlation = power / power[0]
    zero = np.flatnonzero(correlation <= 0.05)
    upto = int(zero[0]) if len(zero) else len(correlation)
    return max(float(len(wanted) / (1 + 2 * correlation[1:upto].sum())), len(basis) + 2.0)
