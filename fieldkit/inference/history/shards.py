"""Simulated histories as tables of features and truths, computed in shards on any machines in any order."""

import hashlib
import io
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit import __version__, parallel
from fieldkit.inference.history.drawn_rockets import split_motors, stock
from fieldkit.inference.history.features import (
    HistorySummary,
    PreparedHistory,
    effect_names,
    feature_names,
    modeled,
)
from fieldkit.inference.history.features import summarized as summary_of
from fieldkit.inference.history.placed_effects import Candidates
from fieldkit.inference.history.response import respond
from fieldkit.inference.history.simulated_histories import ROCKETS_PER_BATCH, SimulatedHistory, simulated_histories
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import learned
from fieldkit.model.random_effects import priors
from fieldkit.motors import Motor
from fieldkit.motors.motor import digest
from fieldkit.physics.effect import effects
from fieldkit.physics.history import together
from fieldkit.shapes import Array, Float

ROCKETS_PER_SHARD = 100
"""Rockets per shard: about 400 histories, some seconds of work."""
TRUTHS = (
    "unexplained",
    "selects",
    "flights",
    "readouts",
    "log_apogee",
    "log_cd",
    "log_alpha",
    "mean",
    "sd",
    "cd_mean",
    "cd_sd",
    "alpha_mean",
    "alpha_sd",
    "correlation",
)
"""Columns after the features and a flag for each effect: the truth, and the linear fit's answer."""


@dataclass(frozen=True, slots=True)
class ShardPlan:
    """What determines a shard: the seed, its number, the number of rockets, the candidates and their prior
    probabilities, and whether it uses the held-out motors."""

    seed: int
    number: int
    rockets: int
    candidates_of: Candidates
    inclusion: Mapping[str, float]
    held_out: bool = False


@dataclass(frozen=True, slots=True)
class HistoryTable:
    """Histories as features and truths, one row each."""

    features: Float[Array, "history feature"]
    effects: Float[Array, "history effect"]
    truths: Float[Array, "history truth"]

    def truth(self, name: str) -> Float[Array, "history"]:
        """One column of `TRUTHS`, in its unit."""
        return self.truths[:, TRUTHS.index(name)]

    def rows(self, which: Any) -> "HistoryTable":
        """The selected histories."""
        return HistoryTable(self.features[which], self.effects[which], self.truths[which])


def summarized(
    found: Sequence[SimulatedHistory], candidates_of: Candidates, names: Sequence[str]
) -> Iterator[HistorySummary]:
    """The summaries of simulated histories; their rockets are simulated in one batch. Raises ImpossibleFlight for a
    flight without a dry mass, BadValue for a recovery figure or rail direction that cannot be read, DamagedModel if the
    hyperprior cannot be read.
    """
    # the histories of one rocket have the same motors and plan, and differ only in their readouts
    rockets = {one.history.found: one for one in found}
    response = respond(together([one.history for one in rockets.values()]))
    ends = np.cumsum([0, *(len(one.history.flights) for one in rockets.values())]).tolist()
    ready = {
        motors: PreparedHistory(modeled(one.history, candidates_of, one.shared), response.part(slice(*ends[i : i + 2])))
        for i, (motors, one) in enumerate(rockets.items())
    }
    for one in found:
        yield summary_of(ready[one.history.found], one.history.flights[: one.history.flown], names)


def row(one: SimulatedHistory, made: HistorySummary, names: Sequence[str]) -> Float[Array, "column"]:
    """A history as a row: features, effects, truths, in their units."""
    baseline, seen = made.baseline, made.data.seen
    truths = {
        "unexplained": one.unexplained,
        "selects": one.selects,
        "flights": seen.any(axis=1).sum(),
        "readouts": seen.any(axis=0).sum(),
        "log_apogee": np.log(one.apogee),
        "log_cd": one.cd,
        "log_alpha": one.alpha,
        "mean": baseline.apogee[0],
        "sd": baseline.apogee_sd[0],
        "cd_mean": baseline.cd[0],
        "cd_sd": baseline.cd_sd[0],
        "alpha_mean": baseline.alpha[0],
        "alpha_sd": baseline.alpha_sd[0],
        "correlation": baseline.correlation[0],
    }
    flags = [name in one.effects for name in names]
    return np.array([*made.features[0], *flags, *(truths[name] for name in TRUTHS)], float)


def simulate_shard(plan: ShardPlan) -> bytes:
    """The histories of a shard as a table in numpy's format. Its random numbers depend only on the shard, not on the
    machine. Raises ImpossibleFlight for a flight without a dry mass, BadValue for a recovery figure or rail direction
    that cannot be read, DamagedModel if the hyperprior cannot be read.
    """
    rng = np.random.default_rng(np.random.SeedSequence(plan.seed, spawn_key=(int(plan.held_out), plan.number)))
    choice = stock(_motors(plan.held_out))
    names = effect_names()
    rows: list[Array] = []
    for first in range(0, plan.rockets, ROCKETS_PER_BATCH):
        count = min(ROCKETS_PER_BATCH, plan.rockets - first)
        found = simulated_histories(rng, choice, plan.candidates_of, plan.inclusion, count)
        made = summarized(found, plan.candidates_of, names)
        rows += [row(one, summary, names) for one, summary in zip(found, made, strict=True)]
    file = io.BytesIO()
    np.lib.format.write_array(file, np.asarray(rows, np.float32), allow_pickle=False)
    return file.getvalue()


def _motors(held_out: bool) -> list[Motor]:
    known, others = split_motors()
    return others if held_out else known


def simulate_table(
    folder: Path,
    seed: int,
    rockets: int,
    candidates_of: Candidates,
    inclusion: Mapping[str, float],
    pool: Executor,
    on_shard: Callable[[int, int], None] | None = None,
    *,
    held_out: bool = False,
) -> HistoryTable:
    """The histories of this number of rockets; shards from an earlier run in the folder are reused.

    `on_shard` is called with the number of shards done and their total. Raises DamagedModel if the hyperprior cannot be
    read.
    """
    sizes = [min(ROCKETS_PER_SHARD, rockets - first) for first in range(0, rockets, ROCKETS_PER_SHARD)]
    plans = {
        f"{number:05d}.npy": ShardPlan(seed, number, size, candidates_of, inclusion, held_out)
        for number, size in enumerate(sizes)
    }
    found: dict[str, Array] = {}
    for name, content in parallel.done(simulate_shard, plans, folder / _digest(seed, held_out, inclusion), pool):
        found[name] = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
        if on_shard:
            on_shard(len(found), len(plans))
    return table(np.concatenate([found[name] for name in plans]))


def table(rows: Float[Array, "history column"]) -> HistoryTable:
    """Features, effects and truths of rows, in the units of their columns."""
    names = effect_names()
    width = len(feature_names(names))
    whole = rows.astype(float)
    return HistoryTable(whole[:, :width], whole[:, width : width + len(names)], whole[:, width + len(names) :])


def _digest(seed: int, held_out: bool, inclusion: Mapping[str, float]) -> str:
    """A digest of everything that shards depend on, so that shards of another seed, feature, prior, hyperprior, catalog
    or version are not reused."""
    drawn = [priors(list(effects())), dict(inclusion), CERTIFIED_PRIOR.json(), learned().json()]
    drawn += [digest(_motors(held_out))]
    made = [feature_names(effect_names()), TRUTHS, ROCKETS_PER_SHARD]
    settings = json.dumps([__version__, seed, held_out, *made, *drawn], sort_keys=True, default=dict)
    return hashlib.sha256(settings.encode()).hexdigest()[:16]
