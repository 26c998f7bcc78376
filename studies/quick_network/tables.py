"""Simulated histories as tables: what a network sees, and the truth; made by many processes for a given time."""

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from fieldkit.inference.history.response import respond
from fieldkit.model.hyperprior import START
from fieldkit.physics.history import together
from fieldkit.selection.prior import inclusion_probabilities
from fieldkit.shapes import Array, Float
from studies.quick_network.drawn_rockets import MAX_FLIGHTS, split_motors, stock
from studies.quick_network.inputs import ClosedForms, closed_forms, effect_names, truth_flags
from studies.quick_network.world import WorldHistory, simulated_histories

ROCKETS = 10
"""Rockets of a batch, whose flights are simulated together."""
TOKENS = MAX_FLIGHTS + 1
"""Flights and the plan, padded. [1]"""
ABOUT = ("log_apogee", "mean", "sd", "reference", "unexplained", "none_odds", "pattern_odds", "flights")
"""Columns of `about`: the truth and the linear pass's answer of a history."""


@dataclass(frozen=True, slots=True)
class WorldTable:
    """Histories: raw and closed-form inputs of each flight with a mask, closed-form inputs of the history, effects that
    are present, that can act and their closed-form log odds, the cause of each flight with the closed-form
    probabilities, and `ABOUT`. `mixture` are draws of the linear pass's log apogee."""

    flights: Float[Array, "history flight raw"]
    mask: Float[Array, "history flight"]
    closed_flights: Float[Array, "history flight closed"]
    closed: Float[Array, "history closed"]
    present: Float[Array, "history effect"]
    acts: Float[Array, "history effect"]
    odds: Float[Array, "history effect"]
    causes: Float[Array, "history flight"]
    judged: Float[Array, "history flight"]
    cause_chance: Float[Array, "history flight cause"]
    about: Float[Array, "history about"]
    mixture: Float[Array, "history draw"]

    def column(self, name: str) -> Float[Array, "history"]:
        """One column of `ABOUT`."""
        return self.about[:, ABOUT.index(name)]

    def rows(self, which: slice) -> "WorldTable":
        """Some histories."""
        return WorldTable(*(getattr(self, name)[which] for name in WorldTable.__slots__))


def passes(found: Sequence[WorldHistory]) -> Iterator[tuple[WorldHistory, ClosedForms]]:
    """The closed forms of simulated histories, whose rockets are simulated in one batch."""
    rockets = {one.rocket: one.history for one in found}
    response = respond(together(list(rockets.values())))
    ends = np.cumsum([0, *(len(history.flights) for history in rockets.values())]).tolist()
    parts = {rocket: response.part(slice(*ends[i : i + 2])) for i, rocket in enumerate(rockets)}
    for one in found:
        yield one, closed_forms(one.history, parts[one.rocket], START)


def table(pairs: Sequence[tuple[WorldHistory, ClosedForms]], mixture: int = 200) -> WorldTable:
    """Histories and their closed forms as a table."""
    names, count = effect_names(), len(pairs)
    raw, closed = pairs[0][1].flights.shape[1], pairs[0][1].closed_flights.shape[1]
    found = WorldTable(
        np.zeros((count, TOKENS, raw), np.float16),
        np.zeros((count, TOKENS), np.float16),
        np.zeros((count, TOKENS, closed), np.float16),
        np.array([own.closed for _, own in pairs], np.float16),
        np.array([truth_flags(names, one.effects) for one, _ in pairs], np.float16),
        np.array([[name in own.odds for name in names] for _, own in pairs], np.float16),
        np.array([[own.odds.get(name, 0.0) for name in names] for _, own in pairs], np.float32),
        np.zeros((count, TOKENS), np.int8),
        np.zeros((count, TOKENS), np.float16),
        np.zeros((count, TOKENS, pairs[0][1].causes.shape[1]), np.float16),
        np.array(
            [
                [
                    np.log(one.apogee),
                    *own.moments(),
                    own.reference,
                    one.unexplained,
                    own.none,
                    own.unexplained,
                    one.history.flown,
                ]
                for one, own in pairs
            ],
            np.float32,
        ),
        np.array([np.quantile(own.draws(), (np.arange(mixture) + 0.5) / mixture) for _, own in pairs], np.float16),
    )
    for row, (one, own) in enumerate(pairs):
        flown = one.history.flown
        found.flights[row, : flown + 1], found.mask[row, : flown + 1] = own.flights, 1.0
        found.closed_flights[row, :flown], found.cause_chance[row, :flown] = own.closed_flights, own.causes
        seen = np.array([flight.apogee is not None for flight in one.history.flights[:flown]], bool)
        found.causes[row, :flown] = one.causes
        found.judged[row, :flown] = seen & np.array(one.history.used_in_fit[:flown], bool)
    return found


def _simulate(folder: Path, seed: int, worker: int, seconds: float) -> int:
    """Shards of one process until the time is over; returns the number of histories."""
    rng, ends = np.random.default_rng([seed, worker]), time.monotonic() + seconds
    choice, prior, made = stock(split_motors()[0]), inclusion_probabilities(), 0
    shard = 0
    while time.monotonic() < ends:
        pairs: list[tuple[WorldHistory, ClosedForms]] = []
        while time.monotonic() < ends and len(pairs) < 600:
            with np.errstate(all="ignore"):
                pairs += [
                    (one, own)
                    for one, own in passes(simulated_histories(rng, choice, prior, ROCKETS))
                    if np.isfinite([*own.moments(), own.reference, own.none]).all()
                ]
        if pairs:
            whole = table(pairs)
            np.savez_compressed(
                folder / f"{worker:02d}_{shard:03d}.npz",
                **{name: getattr(whole, name) for name in WorldTable.__slots__},
            )
            made, shard = made + len(pairs), shard + 1
    return made


def simulate(folder: Path, seed: int, processes: int, seconds: float) -> int:
    """Simulate histories with many processes for some seconds into shards; returns their number."""
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        jobs = [pool.submit(_simulate, folder, seed, worker, seconds) for worker in range(processes)]
        return sum(job.result() for job in jobs)


def load(folder: Path) -> WorldTable:
    """All shards of a folder."""
    parts = [np.load(path) for path in sorted(folder.glob("*.npz"))]
    return WorldTable(*(np.concatenate([part[name] for part in parts]) for name in WorldTable.__slots__))
