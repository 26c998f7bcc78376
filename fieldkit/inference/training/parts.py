"""Flights simulated in parts, on any machines in any order, with the same result."""

import hashlib
import io
import json
import shutil
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from fieldkit import __version__, parallel
from fieldkit.model.observations import DECLARED_FIELDS, FIGURES, READOUT_NAMES
from fieldkit.model.prior_predictive import PRIORS, Truth, simulate, split_motors
from fieldkit.model.random_effects import priors
from fieldkit.motors.motor import digest
from fieldkit.shapes import Array, Float

SIZE = 50_000
"""Flights per part: seconds of work and 20 MB. [1]"""
FOLDER = "parts"
"""Folder of the parts, next to the ensemble to be trained."""
WIDTHS = (len(FIGURES), len(DECLARED_FIELDS), len(READOUT_NAMES), 1, 1)
"""Number of columns of each array of a truth. [1]"""
ReportPart = Callable[[int, int], None]
"""Callback with the number of parts done and their total."""


@dataclass(frozen=True, slots=True)
class SimulationPart:
    """What determines a part's flights: the seed, its number, the number of flights, the active effects."""

    seed: int
    number: int
    count: int
    effects: tuple[str, ...]


def simulate_parts(
    out: Path, seed: int, count: int, effects: Sequence[str], pool: Executor, on_part: ReportPart | None = None
) -> Truth:
    """The requested number of flights, less those that hardly leave the pad; parts from an earlier run in `out` are
    reused. Raises BadValue for an unknown effect."""
    counts = [min(SIZE, count - start) for start in range(0, count, SIZE)]
    items = {f"{n:05d}.npy": SimulationPart(seed, n, size, tuple(effects)) for n, size in enumerate(counts)}
    found: dict[str, Truth] = {}
    for name, content in parallel.done(fly_part, items, out / FOLDER / _digest(items), pool):
        found[name] = unpacked(content)
        if on_part:
            on_part(len(found), len(items))
    columns = ([getattr(found[name], field) for name in items] for field in Truth.__dataclass_fields__)
    return Truth(*(np.concatenate(column) for column in columns))


def drop_parts(out: Path) -> None:
    """Delete the parts of a finished ensemble."""
    shutil.rmtree(out / FOLDER, ignore_errors=True)


def fly_part(part: SimulationPart) -> bytes:
    """The flights of a part as bytes. Its random numbers depend only on the part, not on the machine. Raises
    BadValue for an unknown effect.
    """
    stream = np.random.SeedSequence(part.seed, spawn_key=(0, part.number))
    known, _ = split_motors()
    return packed(simulate(np.random.default_rng(stream), known, part.count, part.effects))


def packed(truth: Truth) -> bytes:
    """Flights as a table in numpy's format, which can contain only numbers."""
    columns = (getattr(truth, name).reshape(len(truth), -1) for name in Truth.__dataclass_fields__)
    file = io.BytesIO()
    np.lib.format.write_array(file, np.hstack(list(columns)), allow_pickle=False)
    return file.getvalue()


def unpacked(content: bytes) -> Truth:
    """The flights in such a table."""
    table: Float[Array, "flight column"] = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    ends = np.cumsum([0, *WIDTHS])
    motor, declared, readouts, area, alpha = (table[:, a:b] for a, b in pairwise(ends))
    return Truth(motor, declared, readouts, area[:, 0], alpha[:, 0])


def _digest(items: dict[str, SimulationPart]) -> str:
    """A digest of everything that parts depend on, so that parts of another seed, recipe, prior, catalog or version are
    not reused."""
    acting = sorted({effect for part in items.values() for effect in part.effects})
    drawn = [digest(split_motors()[0]), dict(PRIORS), priors(acting)]
    settings = json.dumps([__version__, SIZE, drawn, {name: repr(part) for name, part in items.items()}])
    return hashlib.sha256(settings.encode()).hexdigest()[:16]
