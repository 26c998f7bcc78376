"""The recipe of the field ensemble: simulate, train, write the graph and the card that vouches for it."""

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.inference.field_features import ALPHA_RANGE, FEATURES, SEEN, Observed, drag_area_range, features, shown
from fieldkit.inference.mixture import COMPONENTS, WIDTH
from fieldkit.inference.simulated import NOISE, PRIORS, Truth, flown_motors, forget, measure, simulate
from fieldkit.inference.training.graph import graph
from fieldkit.inference.training.members import HIDDEN, LAYERS, MEMBERS, Batch, Schedule, train
from fieldkit.motors import Motor, catalogue
from fieldkit.shapes import Array, Float

HELD_OUT = "Quest"
"""The maker whose motors no member ever sees: the ensemble is judged on them."""
FLIGHTS = 1_000_000
SEED = 20240607


def training_motors() -> list[Motor]:
    """Every motor up to class I but those of the maker held out."""
    return [motor for motor in flown_motors(catalogue().motors) if motor.maker != HELD_OUT]


def held_out_motors() -> list[Motor]:
    """Those of the maker held out."""
    return [motor for motor in flown_motors(catalogue().motors) if motor.maker == HELD_OUT]


def logits(truth: Truth, observed: Observed) -> Float[Array, "flight 2"]:
    """Where drag area (in its logarithm) and alpha lie in their intervals, on the whole line."""
    low, high = drag_area_range(observed)
    place = np.stack(
        [(np.log(truth.drag_area) - low) / (high - low), (truth.alpha - ALPHA_RANGE[0]) / np.ptp(ALPHA_RANGE)], axis=-1
    )
    place = np.clip(place, 1e-6, 1 - 1e-6)
    return np.asarray(np.log(place / (1 - place)))


def batch(rng: np.random.Generator, truth: Truth) -> Batch:
    """The flights as observed once, with fresh noise and fresh gaps."""
    whole = measure(rng, truth)
    observed = forget(rng, whole)
    told = shown(Observed(observed.motor, observed.declared, whole.readouts))
    arrays = features(observed), logits(truth, observed), told
    return Batch(*(np.asarray(array, np.float32) for array in arrays))


def train_field(
    folder: Path,
    *,
    flights: int = FLIGHTS,
    schedule: Schedule | None = None,
    seed: int = SEED,
    truth: Truth | None = None,
    report: Callable[[str], None] = lambda line: None,
) -> None:
    """Train the field ensemble and write it into a folder, its card without a verdict yet."""
    rng = np.random.default_rng(seed)
    schedule = schedule or Schedule()
    if truth is None:
        report(f"flying {flights} flights")
        truth = simulate(rng, training_motors(), flights)
    known = truth
    members, mean, sd = train(lambda _: batch(rng, known), schedule, seed, report)
    content = graph(members, mean, sd)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "ensemble.onnx").write_bytes(content)
    card = {
        "name": "field",
        "features": list(FEATURES),
        "outputs": {"outputs": [MEMBERS, WIDTH + 2 * len(SEEN)]},
        "members": MEMBERS,
        "hidden": [HIDDEN] * LAYERS,
        "components": COMPONENTS,
        "physics": "field",
        "effects": [],
        "priors": dict(PRIORS),
        "noise": {name: [noise.floor, noise.share, noise.step] for name, noise in NOISE.items()},
        "held_out": HELD_OUT,
        "seed": seed,
        "simulations": len(truth),
        "schedule": {"epochs": schedule.epochs, "batch": schedule.batch, "rate": schedule.rate},
        "command": "fieldkit train --recipe field",
        "reach": reach(features(measure(rng, truth.rows(slice(0, 100_000))))),
        "digests": {"ensemble.onnx": hashlib.sha256(content).hexdigest()},
    }
    write_card(folder, card)


REACH = ("log_thrust_to_weight", "log_impulse", "log_burn_time", "log_mass", "log_drag_area", "mach")


def reach(columns: Float[Array, "flight feature"]) -> dict[str, list[float]]:
    """Between which bounds nearly all simulated flights lie, for features a flyer can be told about."""
    return {
        name: [float(bound) for bound in np.percentile(columns[:, FEATURES.index(name)], [0.02, 99.98])]
        for name in REACH
    }


def write_card(folder: Path, card: Mapping[str, Any]) -> None:
    """The card of an ensemble, as text that reads well in a diff."""
    (folder / "card.json").write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")


def add_verdict(folder: Path, verdict: Mapping[str, Any]) -> None:
    """Write what the judge found into the card."""
    card = json.loads((folder / "card.json").read_text(encoding="utf-8"))
    write_card(folder, card | dict(verdict))


