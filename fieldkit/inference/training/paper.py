"""The reference paper's ensemble: five networks on bootstrap samples of simulated flights.

The recipe is the paper's with one exception: validation and test flights are drawn separately from the training flights
(in the published code both are the first 2,000 training rows).
"""

import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import torch

from fieldkit.errors import BadValue
from fieldkit.inference.network.ensemble import Ensemble, from_parts
from fieldkit.inference.training.fit import BATCH, SCHEDULES, WEIGHT_DECAY, Schedule, TrainingProgress, fit, one_thread
from fieldkit.inference.training.graph import graph
from fieldkit.inference.training.network import network
from fieldkit.inference.training.shipping import claim, ship
from fieldkit.model.features import PAPER_FEATURES
from fieldkit.model.paper_prior_predictive import ALPHA_RANGE, APOGEE_NOISE, CD_RANGE, PaperDraws, paper_draws
from fieldkit.shapes import Array, Float

MEMBERS = 5
HIDDEN_UNITS = (128, 256, 128)
DROPOUT = 0.1
OUTPUTS = {"cd": (0.2, 1.5), "alpha": (0.5, 1.5)}
"""Outputs and their ranges. [1]"""
HELD_OUT = 2000
"""Number of validation flights and of test flights."""


def train_paper(
    out: Path,
    *,
    evaluate: Callable[[Ensemble, Array, Array], dict[str, Any]],
    seed: int = 1,
    n_train: int = 10_000,
    schedule: str = "quick",
    progress: TrainingProgress | None = None,
) -> dict[str, Any]:
    """Simulate, train, export into a new folder, and return the results of `fieldkit train --json`.

    `evaluate` returns the card's figures from features and truths of flights that were not used in training. The same
    seed gives the same graph on the same machine. Raises BadValue for an unknown schedule, too few flights, or
    a folder that already contains an ensemble, FieldkitError if the ensemble cannot be written.
    """
    plan = _checked(schedule, n_train)
    claim(out)
    began = time.perf_counter()
    train, validation, test = _flights(seed, n_train)
    mean, scale = train.features.mean(axis=0), train.features.std(axis=0)

    def tensors(draws: PaperDraws) -> tuple[torch.Tensor, torch.Tensor]:
        whitened = (draws.features - mean) / scale
        return torch.tensor(whitened, dtype=torch.float32), torch.tensor(draws.truth, dtype=torch.float32)

    with one_thread(seed):
        model = network(MEMBERS, (len(PAPER_FEATURES), *HIDDEN_UNITS), np.array(list(OUTPUTS.values())), DROPOUT)
        fit(model, *tensors(train), tensors(validation), plan, progress)
    seconds = round(time.perf_counter() - began, 1)
    card = _card(plan, seed, n_train) | {"ranges": _ranges(train.features), "seconds": seconds}
    exported = graph(model, mean, scale, f"fieldkit: the reference paper's ensemble, seed {seed}")
    card["test"] = evaluate(from_parts(exported, card, out), test.features, test.truth)
    return {
        "recipe": "paper",
        "cd_mae": card["test"]["cd"]["mae"],
        "alpha_mae": card["test"]["alpha"]["mae"],
        "n_train": n_train,
        "seconds": seconds,
        "files": ship(out, exported, card),
    }


def _checked(schedule: str, n_train: int) -> Schedule:
    if schedule not in SCHEDULES:
        raise BadValue(f"found the schedule {schedule!r}, expected one of {', '.join(SCHEDULES)}")
    if n_train < BATCH:
        raise BadValue(f"found {n_train} flights to train on, expected at least {BATCH}")
    return SCHEDULES[schedule]


def _flights(seed: int, n_train: int) -> list[PaperDraws]:
    """Flights for training, validation and testing, each from a separate random stream."""
    streams = np.random.SeedSequence(seed).spawn(3)
    counts = (n_train, HELD_OUT, HELD_OUT)
    return [paper_draws(np.random.default_rng(s), count) for s, count in zip(streams, counts, strict=True)]


def _ranges(features: Float[Array, "flight feature"]) -> dict[str, list[float]]:
    """Lowest and highest value of each feature in training."""
    low, high = features.min(axis=0), features.max(axis=0)
    return {name: [float(a), float(b)] for name, a, b in zip(PAPER_FEATURES, low, high, strict=True)}


def _card(plan: Schedule, seed: int, n_train: int) -> dict[str, Any]:
    """The card's content that is known before training."""
    return {
        "name": "paper",
        "recipe": "paper",
        "physics": "paper",
        "effects": [],
        "command": (
            f"fieldkit train --recipe paper --schedule {plan.name} --seed {seed} --n-train {n_train} --out DIR"
        ),
        "seed": seed,
        "n_train": n_train,
        "n_validation": HELD_OUT,
        "n_test": HELD_OUT,
        "priors": {
            "cd": {"law": "uniform", "low": CD_RANGE[0], "high": CD_RANGE[1], "unit": "1"},
            "alpha": {"law": "uniform", "low": ALPHA_RANGE[0], "high": ALPHA_RANGE[1], "unit": "1"},
            "apogee_noise": {"law": "normal", "mean": 0.0, "sd": APOGEE_NOISE, "unit": "m"},
        },
        "features": list(PAPER_FEATURES),
        "outputs": list(OUTPUTS),
        "output_ranges": {name: list(ends) for name, ends in OUTPUTS.items()},
        "network": {
            "members": MEMBERS,
            "hidden": list(HIDDEN_UNITS),
            "layer": "linear, batch norm, ReLU, dropout",
            "dropout": DROPOUT,
        },
        "training": {
            "schedule": plan.name,
            "optimiser": "AdamW",
            "loss": "squared error of Cd and alpha",
            "batch": BATCH,
            "weight_decay": WEIGHT_DECAY,
            "epochs": plan.epochs,
            "rate": plan.rate,
            "rate_follows": "one cycle" if plan.one_cycle else f"halved on a plateau of {plan.patience} epochs",
        },
        "made_with": {name: version(name) for name in ("torch", "onnx", "numpy")},
    }
