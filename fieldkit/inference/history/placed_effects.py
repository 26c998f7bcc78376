"""Candidates for a model in a linear fit: directions in which strengths move the readouts."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from fieldkit.inference.evidence import StrengthPrior, log_mass
from fieldkit.inference.history.response import started
from fieldkit.model.rocket_model import Model, Term
from fieldkit.physics.effect import Effect
from fieldkit.shapes import Array, Float, Int, Integers

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
    def log_fraction(self) -> float: ...


Candidates = Callable[[Model], Sequence[PlacedEffect]]
"""A function that returns the candidates for a model with some flown flights; a parameter, because selection is a layer
above inference."""


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """Directions in which strengths move the readouts, one entry each.

    `number` is the number of the candidate, and `family` its name in a verdict. `moves` are the properties and effects
    that some strength changes, as named in a response, and `kind` is the index of the one that each
    changes. `weight` is how strongly it acts on each flight. `unit` is the value of the effect's parameter at a
    strength of 1, in which the `prior` is given.
    """

    number: tuple[int, ...]
    family: tuple[str, ...]
    moves: tuple[str, ...]
    kind: Int[Integers, "direction"]
    weight: Float[Array, "flight direction"]
    log_fraction: Float[Array, "direction"]
    prior: StrengthPrior
    unit: Float[Array, "direction"]

    def shift(
        self, moved: Mapping[str, Float[Array, "flight readout"]], readouts: Int[Integers, "used"]
    ) -> Float[Array, "flight used direction"]:
        """The change of some readouts of every flight by a unit of each strength."""
        every = np.stack([moved[kind][:, readouts] for kind in self.moves], axis=-1)
        return np.asarray(every[..., self.kind] * self.weight[:, None])


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Candidates as directions: all with one strength together, and each with several strengths separately."""

    single: Directions | None
    several: tuple[Directions, ...]


class _Direction(NamedTuple):
    number: int
    family: str
    moves: str
    weight: Float[Array, "flight"]
    log_fraction: float
    mean: float
    sd: float
    low: float
    high: float
    unit: float


def directions(candidates: Sequence[PlacedEffect]) -> Placed:
    """Candidates as directions."""
    single: list[_Direction] = []
    several: list[list[_Direction]] = []
    for number, candidate in enumerate(candidates):
        own = [one for term in candidate.terms for one in _of_term(number, candidate, term)]
        if len(candidate.terms) == 1:
            single += own
        elif own:
            several.append(own)
    return Placed(_stacked(single) if single else None, tuple(_stacked(own) for own in several))


def _of_term(number: int, candidate: PlacedEffect, term: Term) -> Iterator[_Direction]:
    """The direction of a term, or one around each start of an effect's strength."""
    about = (number, candidate.effect)
    bounded = (term.mean, term.sd, term.low, term.high, 1.0)
    if not isinstance(term.bends, Effect):
        yield _Direction(*about, term.bends, term.weight, candidate.log_fraction, *bounded)
        return
    name = term.name.quantity
    if not term.bends.starts:
        yield _Direction(*about, started(name, 0), term.weight, candidate.log_fraction, *bounded)
        return
    density = [np.exp(-0.5 * ((start - term.mean) / term.sd) ** 2) for start in term.bends.starts]
    for place, start in enumerate(term.bends.starts):
        part = candidate.log_fraction + float(np.log(density[place] / sum(density)))
        yield _Direction(*about, started(name, place), term.weight, part, 1.0, START_SD, -np.inf, np.inf, start)


def _stacked(some: Sequence[_Direction]) -> Directions:
    numbers, families, moves, weights, *rest = zip(*some, strict=True)
    log_fraction, mean, sd, low, high, unit = (np.array(one, float) for one in rest)
    prior = StrengthPrior(mean, sd, low, high, log_mass(mean, sd, low, high))
    kinds = tuple(dict.fromkeys(moves))
    places = np.array([kinds.index(kind) for kind in moves])
    return Directions(numbers, families, kinds, places, np.stack(weights, axis=-1), log_fraction, prior, unit)
