"""Candidates for a model in a linear fit: directions in which strengths move the readouts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.response import started
from fieldkit.model.rocket_model import Term
from fieldkit.physics.effect import Effect, effects
from fieldkit.shapes import Array, Float

START_SD = 0.25
"""Relative standard deviation of a strength around each of its starts. [1]"""


@runtime_checkable
class PlacedEffect(Protocol):
    """A candidate: an effect with its place (the flights it acts on), or a pattern (with an empty `effect`), and its
    terms on every flight."""

    @property
    def effect(self) -> str: ...
    @property
    def terms(self) -> tuple[Term, ...]: ...
    @property
    def log_share(self) -> float: ...


@dataclass(frozen=True, slots=True)
class Direction:
    """One direction in which a strength moves the readouts."""

    number: int
    family: str
    log_share: float
    shift: Float[Array, "flight readout"]
    mean: float
    sd: float
    low: float
    high: float
    unit: float


def directions(linear: LinearFit, candidates: Sequence[PlacedEffect]) -> tuple[list[Direction], list[list[Direction]]]:
    """Directions of candidates with one strength, and for those with several, all directions of each."""
    names = {id(effect): name for name, effect in effects().items()}
    moved = linear.moved
    single: list[Direction] = []
    several: list[list[Direction]] = []
    for number, candidate in enumerate(candidates):
        found: list[Direction] = []
        for term in candidate.terms:
            if not isinstance(term.bends, Effect):
                shift = term.weight[:, None] * moved[term.bends]
                found.append(_direction(number, candidate, term, shift))
                continue
            name = names[id(term.bends)]
            if not term.bends.starts:
                shift = term.weight[:, None] * moved[started(name, 0)]
                found.append(_direction(number, candidate, term, shift))
                continue
            density = [np.exp(-0.5 * ((start - term.mean) / term.sd) ** 2) for start in term.bends.starts]
            for place, start in enumerate(term.bends.starts):
                shift = term.weight[:, None] * moved[started(name, place)]
                part = candidate.log_share + float(np.log(density[place] / sum(density)))
                single.append(Direction(number, candidate.effect, part, shift, 1.0, START_SD, -np.inf, np.inf, start))
        if len(found) == 1:
            single.append(found[0])
        elif found:
            several.append(found)
    return single, several


def _direction(number: int, candidate: PlacedEffect, term: Term, shift: Array) -> Direction:
    return Direction(number, candidate.effect, candidate.log_share, shift, term.mean, term.sd, term.low, term.high, 1.0)
