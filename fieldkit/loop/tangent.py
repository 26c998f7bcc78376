"""Readouts near a point: their values and how they change with each unknown, all from one batch of flights."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.loop.model import OBSERVED, SCATTER, Model, compared, shown
from fieldkit.shapes import Array, Float

STEP = 0.25
"""Step of a difference in standard deviations of the prior. [1]"""


@dataclass(frozen=True, slots=True)
class Tangent:
    """The readouts near a point: values there, derivatives, and what a standard deviation of scatter does."""

    at: Float[Array, "term"]
    values: Float[Array, "flight readout"]
    slope: Float[Array, "flight readout term"]
    scatter_slope: Float[Array, "flight readout scatter"]


def lean_slope(model: Model, at: Float[Array, "term"]) -> Float[Array, "flight readout"]:
    """What a lean of one unit does to the readouts; it needs the planar flight and is flown apart."""
    upright, leaning = (
        _stacked(shown(model, at[None], {"tilt": np.full((1, len(model.flights)), lean)})) for lean in (0.0, 1.0)
    )
    return np.asarray((leaning - upright)[0])


def tangents(
    model: Model, lanes: Sequence[tuple[tuple[int, ...], Array]], lean: Float[Array, "flight readout"]
) -> list[Tangent]:
    """Values and derivatives of several lanes, each at its own point, from one batch of flights."""
    upright = [scatter for scatter in SCATTER if scatter.bends != "tilt"]
    blocks = [_block(model, terms, at, len(upright)) for terms, at in lanes]
    values = np.concatenate([block for block, _ in blocks])
    bends: dict[str, Array] = {s.bends: np.zeros((len(values), len(model.flights))) for s in upright}
    end = 0
    for block, _ in blocks:
        end += len(block)
        for row, scatter in enumerate(upright, start=end - len(upright)):
            bends[scatter.bends][row] = scatter.sd
    readings = _stacked(shown(model, values, bends))
    found, first = [], 0
    for (terms, at), (block, steps) in zip(lanes, blocks, strict=True):
        part = readings[first : first + len(block)]
        first += len(block)
        with np.errstate(invalid="ignore"):
            slope = np.moveaxis((part[1 : 1 + len(terms)] - part[0]) / steps[:, None, None], 0, -1)
            moved = np.concatenate([part[1 + len(terms) :] - part[0], lean[None]])
        scatter_slope = np.moveaxis(moved, 0, -1)
        found.append(Tangent(at, part[0], np.nan_to_num(slope), np.nan_to_num(scatter_slope)))
    return found


def _block(model: Model, terms: tuple[int, ...], at: Array, scatters: int) -> tuple[Array, Array]:
    """Rows to fly for a lane: its point, a step along each of its terms, the point again for each scatter."""
    active = [model.terms[i] for i in terms]
    steps = np.array(
        [
            STEP * term.sd if x + STEP * term.sd <= term.high else -STEP * term.sd
            for term, x in zip(active, at, strict=True)
        ]
    )
    rows = np.zeros((1 + len(terms) + scatters, len(model.terms)))
    rows[:, list(terms)] = at
    rows[1 + np.arange(len(terms)), list(terms)] += steps
    return rows, steps


def _stacked(readings: dict[str, Array]) -> Float[Array, "draw flight readout"]:
    return compared(np.stack([readings[name] for name in OBSERVED], axis=-1))
