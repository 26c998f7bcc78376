"""Readouts near a point: values and derivatives with respect to each term, from one batch of simulated flights.

Derivation: first-order Taylor expansion, with derivatives by finite differences.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.simulated_readouts import shown
from fieldkit.physics.effect import Effect
from fieldkit.shapes import Array, Flags, Float

STEP = 0.25
"""Finite-difference step of a strength, in prior standard deviations. [1]"""
STEPS = {"drag": 0.03, "thrust": 0.025, "stretch": 0.02, "mass": 0.005, "opening": 0.1}
"""Finite-difference step of every other property, small relative to its prior."""
BOTH_WAYS = {"delay": 0.08}
"""Central steps about as large as the scatter of single flights: readouts have a kink when ejection is at apogee, and a
small step would see only one side of it."""
_PERTURBATIONS = (*STEPS.items(), *((kind, side * step) for kind, step in BOTH_WAYS.items() for side in (1, -1)))


@dataclass(frozen=True, slots=True)
class Tangent:
    """The readouts near a point: values, derivatives, and the effect of one standard deviation of scatter. [1] or
    [s]"""

    at: Float[Array, "term"]
    values: Float[Array, "flight readout"]
    slope: Float[Array, "flight readout term"]
    scatter_slope: Float[Array, "flight readout scatter"]


def _perturbations(model: Model) -> tuple[tuple[str, float], ...]:
    """The property changed in each row after a lane's point, and the step: 1 for the standard deviation of recorded
    weather."""
    return (*_PERTURBATIONS, *((name, 1.0) for name in model.history.uncertain))


def launch_angle_slope(model: Model, at: Float[Array, "term"]) -> Float[Array, "flight readout"]:
    """The effect of one unit of launch angle on the readouts, zero if the model has none. It needs planar flight and is
    simulated separately. Raises ImpossibleFlight for a flight without a dry mass."""
    if all(kind.bends != "tilt" for kind in model.scatter):
        return np.zeros((len(model.flights), len(OBSERVED_READOUTS)))
    none_and_one = np.broadcast_to([[0.0], [1.0]], (2, len(model.flights)))
    upright, leaning = _stacked(shown(model, np.stack([at, at]), {"tilt": none_and_one}))
    return np.asarray(leaning - upright)


def known_angle_slope(model: Model, near: Tangent) -> Float[Array, "flight readout"]:
    """As `launch_angle_slope`, from a known linearization. [1] or [s]"""
    kinds = [kind.bends for kind in model.scatter]
    if "tilt" not in kinds:
        return np.zeros(near.values.shape)
    place = kinds.index("tilt")
    return np.asarray(near.scatter_slope[..., place] / model.scatter[place].sd)


def coast_times(model: Model, at: Float[Array, "term"]) -> Float[Array, "flight"]:
    """The time from burnout to apogee of flights at a point. [s]

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    return np.asarray(shown(model, at[None], {})["coast_time"][0])


def tangents(
    model: Model,
    lanes: Sequence[tuple[tuple[int, ...], Float[Array, "_"]]],
    angle_slope: Float[Array, "flight readout"],
) -> list[Tangent]:
    """Values and derivatives of several lanes, each at its own point, from one batch of simulated flights. [1] or [s]

    A lane has the numbers of its own terms and their values, in the units of the terms; `angle_slope` is from
    `launch_angle_slope`. Terms that act on the same property share a column, scaled by their weights on each flight:
    drag of a rocket and drag of one of its configurations differ only in the flights they act on. The bias of a reading
    needs no simulation. Raises ImpossibleFlight for a flight without a dry mass.
    """
    blocks = [_block(model, terms, at) for terms, at in lanes]
    count = sum(len(block.values) for block in blocks)
    steps = _perturbations(model)
    bends = {kind: np.zeros((count, len(model.flights))) for kind, _ in steps}
    firsts = np.cumsum([0, *(len(block.values) for block in blocks)])
    for first in firsts[:-1]:
        for row, (kind, step) in enumerate(steps, start=first + 1):
            bends[kind][row] = step
    readings = _stacked(shown(model, np.concatenate([block.values for block in blocks]), bends))
    parts = np.split(readings, firsts[1:-1])
    return [
        _tangent(model, at, block, part, angle_slope) for (_, at), block, part in zip(lanes, blocks, parts, strict=True)
    ]


@dataclass(frozen=True, slots=True)
class _Block:
    """Rows to simulate for a lane: its point, a step in each of `_perturbations`, a step in the strengths of each slot.

    `slots` has the row of every strength of an effect, and its step. Flights are independent, so strengths that act on
    different flights share a row.
    """

    terms: tuple[int, ...]
    values: Float[Array, "row every"]
    slots: dict[int, tuple[int, float]]


def _block(model: Model, terms: tuple[int, ...], at: Array) -> _Block:
    slots: dict[int, tuple[int, float]] = {}
    first = 1 + len(_perturbations(model))
    acting: list[Flags] = []
    for i, x in zip(terms, at, strict=True):
        term = model.terms[i]
        if isinstance(term.bends, Effect):
            acts = term.weight != 0
            slot = next((k for k, taken in enumerate(acting) if not (taken & acts).any()), len(acting))
            acting[slot:] = [acts if slot == len(acting) else acting[slot] | acts, *acting[slot + 1 :]]
            step = STEP * term.sd if x + STEP * term.sd <= term.high else -STEP * term.sd
            slots[i] = first + slot, step
    values = np.zeros((first + len(acting), len(model.terms)))
    values[:, list(terms)] = at
    for i, (row, step) in slots.items():
        values[row, i] += step
    return _Block(terms, values, slots)


def _tangent(model: Model, at: Array, block: _Block, flown: Array, angle_slope: Array) -> Tangent:
    with np.errstate(invalid="ignore"):
        moved = _finite(flown - flown[0])
    per_kind = {kind: moved[row] / step for row, (kind, step) in enumerate(STEPS.items(), start=1)}
    for number, (kind, step) in enumerate(BOTH_WAYS.items()):
        there, back = moved[1 + len(STEPS) + 2 * number :][:2]
        per_kind[kind] = (there - back) / (2 * step)
    per_kind |= zip(model.history.uncertain, moved[1 + len(_PERTURBATIONS) :], strict=False)
    columns = [_column(model.terms[i], per_kind, moved, block.slots.get(i)) for i in block.terms]
    scatter = [per_kind.get(kind.bends, angle_slope) * kind.sd for kind in model.scatter]
    slope = (
        np.stack(columns, axis=-1) if columns else np.zeros((*flown[0].shape, 0))
    )  # without flights there are no terms
    return Tangent(at, flown[0], slope, _finite(np.stack(scatter, axis=-1)))


def _finite(moved: Array) -> Array:
    """Changes of readouts, 0 if either end is missing: a step that keeps a flight on the pad has no slope."""
    return np.nan_to_num(moved, nan=0.0, posinf=0.0, neginf=0.0)


def _column(term: Term, per_kind: Mapping[str, Array], moved: Array, slot: tuple[int, float] | None) -> Array:
    """The effect of one unit of a term on the readouts. [flight readout]"""
    if slot is not None:
        row, step = slot
        return np.asarray(np.where(term.weight[:, None] != 0, moved[row] / step, 0.0))
    if term.bends in OBSERVED_READOUTS:
        return np.asarray(term.weight[:, None] * (np.array(OBSERVED_READOUTS) == term.bends))
    return np.asarray(term.weight[:, None] * per_kind[str(term.bends)])


def _stacked(readings: dict[str, Array]) -> Float[Array, "draw flight readout"]:
    return compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))
