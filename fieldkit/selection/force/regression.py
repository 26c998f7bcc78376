"""Sparse regression on one climb: what a choice of terms leaves, and what the extended criterion asks for it.

Terms are worth their place while the extended Bayesian information criterion falls (Chen and Chen, Biometrika 95,
2008), which pays for every term that could have been chosen. Samples that a smoother has tied together count as what
they are worth.
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
"""Largest number of terms. [1]"""
MIN_RESIDUAL_FRACTION = 1e-3
"""Fraction of a term that must remain after the free terms are projected out. [1]"""
LEAST_DRAG = 0.1
"""Of the model's drag: a climb that shows less shows nothing of it. [1]"""
CRITERION_TIE = 4.0
"""Difference of the criterion within which another term is named beside the chosen one. [1]"""


@dataclass(frozen=True, slots=True)
class ChosenTerm:
    """A term's name, what it takes off the criterion, and the terms that would have done nearly as well."""

    name: str
    gain: float
    also: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Regression:
    """The missing force of a climb and the terms that it could show, in standard deviations of a sample.

    What is free in every flight is taken out of all of them: a shift of the clock where the motor burns, and what
    else was asked for. `worth` is the effective number of independent samples of the record, `spent` the unknowns
    already taken out. `drag` describes the drag, if that is free.
    """

    wanted: Float[Array, "time"]
    columns: Mapping[str, Float[Array, "time"]]
    worth: float
    spent: int
    drag: "FreeDrag | None" = None

    def left(self, names: Sequence[str]) -> Float[Array, "time"]:
        """What the terms of these names do not explain."""
        return _left(self.wanted, [self.columns[name] for name in names])

    def cost(self, names: Sequence[str]) -> float:
        """The information criterion of these terms, without the price of choosing them; less is better."""
        left = self.left(names)
        return self.worth * log(left @ left) + len(names) * log(self.worth)

    def solve(self, names: Sequence[str]) -> tuple[Float[Array, "term"], Float[Array, "term"]]:
        """Coefficients and their standard deviations, shares of the drag being of what drag there was."""
        if not len(names):
            return np.zeros(0), np.zeros(0)
        unit = self._unit(names)
        basis = np.stack([self.columns[name] for name in names], axis=-1)
        left = self.left(names)
        scatter = float(left @ left) / max(self.worth - self.spent - len(names), 1.0)
        inverse = np.linalg.pinv(basis.T @ basis)
        return unit * (inverse @ (basis.T @ self.wanted)), unit * np.sqrt(np.diag(inverse) * scatter)

    def random_draw_sd(self, names: Sequence[str], scatters: Mapping[str, float]) -> Float[Array, "term"]:
        """Standard deviations of these terms' coefficients due to the random draws of a flight, given by name.

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
        """What one of each coefficient is worth, where all of them stand beside each other."""
        return self.drag.unit(names) if self.drag else np.ones(len(names))


@dataclass(frozen=True, slots=True, eq=False)
class FreeDrag:
    """How much drag there is in a climb, if that is free: terms that are shares of the model's drag become shares
    of it. Nothing is taken out of the columns here; `place` is that of the drag among those `given`."""

    force: Float[Array, "time"]
    given: Sequence[Float[Array, "time"]]
    place: int
    whole: Mapping[str, Float[Array, "time"]]
    shares: frozenset[str]

    def unit(self, names: Sequence[str]) -> Float[Array, "term"]:
        """The model's drag over the climb's, for terms that are shares of it; 1 for the others."""
        value, *_ = np.linalg.lstsq(np.stack([*self.given, *(self.whole[n] for n in names)], axis=-1), self.force)
        factor = 1 / max(1 + float(value[self.place]), LEAST_DRAG)
        return np.array([factor if name in self.shares else 1.0 for name in names])


def regression(missing: Missing, terms: Sequence[ForceTerm], free: Collection[str] = ()) -> Regression:
    """The regression of a missing force on those terms that act somewhere along its climb.

    Terms named in `free` are taken out beforehand rather than put to the test.
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
    """Terms added one by one while the best of the others gains anything beside those chosen before."""
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
    """What the criterion asks for one more beside so many terms: by how much more ways there are to choose them."""
    return 2 * CANDIDATE_COUNT_WEIGHT * log((candidates - terms) / (terms + 1))


def _left(wanted: Array, basis: Sequence[Array]) -> Array:
    if not len(basis):
        return wanted
    stacked = np.stack(basis, axis=-1)
    value, *_ = np.linalg.lstsq(stacked, wanted, rcond=None)
    return np.asarray(wanted - stacked @ value)


def _worth(wanted: Array, basis: Sequence[Array]) -> float:
    """Effective number of independent samples of the record, by the autocorrelation that no term explains.

    Sum of the autocorrelation of the full library's residual up to its first zero (Sokal's integrated time).
    """
    left = _left(wanted, basis)
    left = left - left.mean()
    power = np.correlate(left, left, "full")[len(left) - 1 :]
    if power[0] <= 0:
        return float(len(wanted))
    alike = power / power[0]
    zero = np.flatnonzero(alike <= 0.05)
    upto = int(zero[0]) if len(zero) else len(alike)
    return max(float(len(wanted) / (1 + 2 * alike[1:upto].sum())), len(basis) + 2.0)
