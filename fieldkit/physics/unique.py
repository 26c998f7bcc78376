"""Simulate identical draws once: a step in one parameter leaves most flights of a rocket unchanged."""

from dataclasses import fields

import numpy as np

from fieldkit.physics.flight import fly
from fieldkit.physics.state import PER_DRAW, FlightResult, Setup
from fieldkit.shapes import Array, Integers

MIXERS = np.random.default_rng(0).integers(1, 2**63, 64, dtype=np.uint64) | np.uint64(1)
"""Odd multipliers, one per entry, for hashing the entries of a draw. [1]"""


def fly_unique(setup: Setup) -> FlightResult:
    """Like `fly`, but each distinct setup is simulated once; for batches in which many draws share a setup."""
    shape = setup.draw_shape
    flat = setup.flat(shape)
    first, kind = kinds(flat)
    flown = fly(flat.part(first))
    return FlightResult(*(getattr(flown, entry.name)[kind].reshape(shape) for entry in fields(FlightResult)))


def kinds(flat: Setup) -> tuple[Integers, Integers]:
    """The first draw of every distinct setup, and the index of the distinct setup of every draw.

    Draws are compared by a hash, a sum of products of the bits of their entries. If two different draws collide, every
    draw is treated as distinct.
    """
    entries = np.stack([np.zeros(flat.draws), *(np.broadcast_to(x, flat.draws) for x in _entries(flat))])
    bits = entries.view(np.uint64)
    mixed = ((bits ^ (bits >> np.uint64(29))) * MIXERS[: len(bits), None]).sum(axis=0)
    _, first, kind = np.unique(mixed, return_index=True, return_inverse=True)
    if (bits[:, first[kind]] == bits).all():
        return first, kind
    every = np.arange(flat.draws)
    return every, every


def _entries(flat: Setup) -> list[Array]:
    """The entries that may differ between draws."""
    arrays = [getattr(flat, name) for name in PER_DRAW]
    arrays += [flat.air.density, flat.air.temperature, *(strength for _, strength in flat.forces)]
    return [np.asarray(one, float) for one in arrays if np.size(one) > 1]
