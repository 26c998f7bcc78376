"""Training of the history network on simulated histories with features from linear fits, in one resumable command."""

import hashlib
import json
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.optim.lr_scheduler import OneCycleLR

from fieldkit.errors import BadValue
from fieldkit.files import read_own, replace
from fieldkit.inference.history.columns import OF_HISTORY, PER_EFFECT
from fieldkit.inference.history.drawn_rockets import MAX_FLIGHTS
from fieldkit.inference.history.features import effect_names, feature_names
from fieldkit.inference.history.modeled_rockets import SELECTION_WORLD
from fieldkit.inference.history.placed_effects import Candidates
from fieldkit.inference.history.shards import HistoryTable, simulate_table
from fieldkit.inference.network.ensemble import Ensemble, from_parts
from fieldkit.inference.network.history_parts import width
from fieldkit.inference.training.fit import TrainingProgress, one_thread
from fieldkit.inference.training.history_members import MEMBERS, HistoryMembers, HistoryTargets, loss, scaled_features
from fieldkit.inference.training.member_graphs import history_graph
from fieldkit.inference.training.shipping import claim, ship
from fieldkit.inference.training.unfinished import load_state, save_state
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import learned
from fieldkit.model.random_effects import priors
from fieldkit.parallel import workers
from fieldkit.physics.effect import effects
from fieldkit.shapes import Array, Float

FOLDER = "parts"
"""Folder of the shards and the state of training, next to the ensemble to be trained."""
TEST_FRACTION = 0.1
"""Fraction of the histories for evaluation, never used in training. [1]"""
VALIDATION_FRACTION = 0.05
"""Fraction of the histories for choosing the number of epochs. [1]"""
HELD_OUT_ROCKETS = 150
"""Number of rockets on the held-out manufacturer's motors."""
SAVE_EPOCHS = 5
"""Number of epochs between saved states, from which an interrupted run resumes."""


@dataclass(frozen=True, slots=True)
class HistoryPlan:
    """Schedule: epochs, batch size, peak learning rate, weight decay."""

    epochs: int
    batch: int = 256
    rate: float = 2e-3
    decay: float = 0.05


PLANS = {"quick": HistoryPlan(epochs=2), "published": HistoryPlan(epochs=8, decay=0.5)}
"""Three more epochs than five improve the loss of validation histories by 0.003."""


def train_history(
    out: Path,
    *,
    evaluate: Callable[[Ensemble, HistoryTable], dict[str, Any]],
    candidates_of: Candidates,
    inclusion: Mapping[str, float],
    seed: int = 1,
    n_train: int = 13_100,
    schedule: str = "published",
    cluster: str = "",
    effects: Sequence[str] = (),
    progress: TrainingProgress | None = None,
) -> dict[str, Any]:
    """Simulate the histories of `n_train` rockets, train, export into a new folder, evaluate, and return the results.

    Shards and the state of training are saved in the folder until the end, so that an interrupted run can resume.
    `evaluate` returns the card's figures on histories that were not used in training, `candidates_of` the candidates
    for a history, and `inclusion` has the prior probabilities of the effects, of which only the named ones, by default
    all, are above zero. While histories are simulated, `progress`
    counts shards and its loss is nan. Raises BadValue for an unknown schedule or a folder that already contains an
    ensemble, FieldkitError if the cluster cannot be used, DamagedModel if the hyperprior cannot be read.
    """
    if schedule not in PLANS:
        raise BadValue(f"found the schedule {schedule!r}, expected one of {', '.join(PLANS)}")
    claim(out)
    plan = PLANS[schedule]
    simulating, whole_run = (Stopwatch(out / FOLDER / name) for name in ("simulation_seconds", "seconds"))

    def on_shard(done: int, count: int) -> None:
        simulating.save()
        whole_run.save()
        if progress:
            progress(done, count + plan.epochs, float("nan"))

    with workers(cluster) if cluster else ThreadPoolExecutor(1) as pool:
        whole = simulate_table(out / FOLDER, seed, n_train, candidates_of, inclusion, pool, on_shard)
        others = simulate_table(out / FOLDER, seed, HELD_OUT_ROCKETS, candidates_of, inclusion, pool, held_out=True)
    simulated = simulating.seconds
    train, validation, test = split(whole)

    def on_epoch(epoch: int, epochs: int, value: float) -> None:
        whole_run.save()
        if progress:
            progress(epoch, epochs, value)

    with one_thread(seed):
        members, mean, sd, losses = fit_history(train, validation, plan, out / FOLDER / "state.npy", on_epoch)
    graph = history_graph(members, mean, sd)
    card = _card(seed, n_train, schedule, plan, inclusion, effects) | {
        "simulations": len(whole.features),
        "simulation_seconds": round(simulated, 1),
        "seconds": round(whole_run.seconds, 1),
        "loss": losses,
    }
    ensemble = from_parts(graph, card, out)
    card["test"] = evaluate(ensemble, test)
    card["test_held_out"] = evaluate(ensemble, others)
    files = ship(out, graph, card)
    shutil.rmtree(out / FOLDER, ignore_errors=True)
    return {
        "recipe": "history",
        "cd_mae": card["test"]["parameters"]["cd_mae"],
        "alpha_mae": card["test"]["parameters"]["alpha_mae"],
        "n_train": n_train,
        "seconds": card["seconds"],
        "files": files,
    }


def split(whole: HistoryTable) -> tuple[HistoryTable, HistoryTable, HistoryTable]:
    """Histories for training, validation and evaluation, in their order: at most two rockets are in more than one."""
    count = len(whole.features)
    test, validation = (max(int(count * fraction), 1) for fraction in (TEST_FRACTION, VALIDATION_FRACTION))
    ends = (count - test - validation, count - test)
    return whole.rows(np.arange(ends[0])), whole.rows(np.arange(*ends)), whole.rows(np.arange(ends[1], count))


def fit_history(
    train: HistoryTable,
    validation: HistoryTable,
    plan: HistoryPlan,
    state: Path,
    progress: Callable[[int, int, float], None],
) -> tuple[HistoryMembers, Float[Array, "feature"], Float[Array, "feature"], list[float]]:
    """Members trained by one cycle of AdamW, each with a different order of the histories, at the epoch with the lowest
    validation loss; the mean and standard deviation that scale their features; and the validation losses.

    `state` is the file of an unfinished run. Runs on a GPU if there is one.
    """
    device = "cuda" if torch.cuda.is_available() else "cpu"
    mean, sd = feature_moments(train)

    def scaled(table: HistoryTable) -> torch.Tensor:
        return torch.from_numpy(scaled_features(table.features, mean, sd)).to(device)

    features, targets = scaled(train), HistoryTargets(train, _acts(train)).to(device)
    unseen, unseen_targets = scaled(validation), HistoryTargets(validation, _acts(validation)).to(device)
    members = HistoryMembers(len(OF_HISTORY), len(effect_names()), len(PER_EFFECT)).to(device)
    count = len(features)
    batch = min(plan.batch, count)
    optimizer = torch.optim.AdamW(members.parameters(), lr=plan.rate, weight_decay=plan.decay)
    rate = OneCycleLR(optimizer, plan.rate, total_steps=plan.epochs * (count // batch), pct_start=0.2)
    losses: list[float] = []
    best: dict[str, Any] = {}
    if state.exists():
        losses, best = load_state(state, members, optimizer, rate)
    for epoch in range(len(losses) + 1, plan.epochs + 1):
        orders = torch.stack([torch.randperm(count, device=device) for _ in range(MEMBERS)])
        for first in range(0, count - batch + 1, batch):
            rows = orders[:, first : first + batch]
            optimizer.zero_grad()
            loss(members(features[rows]), targets.rows(rows)).backward()
            nn.utils.clip_grad_norm_(members.parameters(), 5.0)
            optimizer.step()
            rate.step()
        with torch.no_grad():
            losses.append(float(loss(members(unseen), unseen_targets.rows(_every(len(unseen), device)))))
        if losses[-1] == min(losses):
            best = {name: value.detach().clone() for name, value in members.state_dict().items()}
        if epoch % SAVE_EPOCHS == 0:
            save_state(state, members, optimizer, rate, losses, best)
        progress(epoch, plan.epochs, losses[-1])
    members.load_state_dict(best)
    return members.cpu(), mean, sd, [round(value, 5) for value in losses]


def feature_moments(table: HistoryTable) -> tuple[Float[Array, "feature"], Float[Array, "feature"]]:
    """Mean and standard deviation that scale each feature. Those of a column of `PER_EFFECT` are common to all effects,
    over the histories in which they can act, because one function takes the columns of every effect."""
    mean, sd = table.features.mean(axis=0), table.features.std(axis=0)
    each = table.features[:, len(OF_HISTORY) :].reshape(-1, len(PER_EFFECT))
    acting = each[_acts(table).ravel()]
    effects = len(effect_names())
    mean[len(OF_HISTORY) :] = np.tile(acting.mean(axis=0), effects)
    sd[len(OF_HISTORY) :] = np.tile(acting.std(axis=0), effects)
    same = PER_EFFECT.index("acts") + len(OF_HISTORY) + np.arange(effects) * len(PER_EFFECT)
    mean[same], sd[same] = 0.0, 1.0
    return mean, sd + 1e-3


def _every(count: int, device: str) -> torch.Tensor:
    """Rows of all histories for every member."""
    return torch.arange(count, device=device).expand(MEMBERS, count)


def _acts(table: HistoryTable) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Whether each effect can act on a history."""
    names = feature_names(effect_names())
    return table.features[:, [names.index(f"{name}.acts") for name in effect_names()]] > 0.5


def _digest(document: object) -> str:
    """SHA-256 of a document as JSON."""
    return hashlib.sha256(json.dumps(document, sort_keys=True, default=dict).encode()).hexdigest()


def _card(
    seed: int, n_train: int, schedule: str, plan: HistoryPlan, inclusion: Mapping[str, float], acting: Sequence[str]
) -> dict[str, Any]:
    """The card's content that is known before training."""
    names = effect_names()
    options = f"--schedule {schedule} --seed {seed} --n-train {n_train}" + (
        f" --effects {','.join(acting)}" if acting else ""
    )
    return {
        "name": "history",
        "recipe": "history",
        "physics": "field",
        "command": f"fieldkit train --recipe history {options} --out DIR",
        "seed": seed,
        "n_train": n_train,
        "effects": list(names),
        "effect_priors": priors(list(effects())),
        "priors": {
            "flights": f"1 to {MAX_FLIGHTS}, log-uniform",
            "inclusion": {name: round(chance, 6) for name, chance in inclusion.items()},
            "hyperprior": f"certified in {SELECTION_WORLD:.0%}, on which inclusion is trained; else the learned one",
        },
        "hyperpriors": {one.kind: _digest(one.json()) for one in (CERTIFIED_PRIOR, learned())},
        "forecast_prior": learned().model_json(),
        "features": list(feature_names(names)),
        "outputs": ["inclusion", "none", "unexplained", "log_apogee", "log_cd", "log_alpha"],
        "parts": [MEMBERS, width(len(names))],
        "network": {"members": MEMBERS},
        "training": {
            "schedule": schedule,
            "optimizer": "AdamW, one cycle",
            "epochs": plan.epochs,
            "batch": plan.batch,
            "rate": plan.rate,
            "weight_decay": plan.decay,
        },
        "made_with": {name: version(name) for name in ("torch", "onnx", "numpy")},
    }


class Stopwatch:
    """Seconds spent on a resumable run: those of earlier runs, saved in a file, and those since it was made. [s]"""

    def __init__(self, file: Path) -> None:
        self._file, self._began = file, time.perf_counter()
        self._before = float(read_own(file)) if file.exists() else 0.0

    @property
    def seconds(self) -> float:
        """Seconds of all runs. [s]"""
        return self._before + time.perf_counter() - self._began

    def save(self) -> None:
        """Save the seconds so far. Raises FieldkitError."""
        self._file.parent.mkdir(parents=True, exist_ok=True)
        replace(self._file, f"{self.seconds:.1f}".encode())
