"""The field ensemble: densities of drag area and alpha fitted to simulated flights of every motor."""

import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.errors import BadValue
from fieldkit.inference.network import outliers
from fieldkit.inference.network.ensemble import Ensemble, from_parts
from fieldkit.inference.network.field_ensemble import INTERVALS, intervals
from fieldkit.inference.network.mixture import COMPONENTS, WIDTH, logits
from fieldkit.inference.training.density import HIDDEN_UNITS, LAYERS, MEMBERS, Batch, TrainingPlan, fit
from fieldkit.inference.training.fit import TrainingProgress, one_thread
from fieldkit.inference.training.member_graphs import density_graph
from fieldkit.inference.training.parts import drop_parts, simulate_parts
from fieldkit.inference.training.shipping import claim, ship
from fieldkit.model.field_features import FEATURES, features, shown
from fieldkit.model.observation_noise import GAIN, NOISE, OFFSET, forget, measure
from fieldkit.model.observations import INDEPENDENT_READOUTS, Observed
from fieldkit.model.prior_predictive import HELD_OUT, PRIORS, TAIL, Truth, simulate, split_motors
from fieldkit.model.random_effects import known_effects, priors
from fieldkit.motors import Motor
from fieldkit.parallel import workers
from fieldkit.shapes import Array, Float

PLANS = {"quick": TrainingPlan(epochs=2), "published": TrainingPlan(epochs=20)}
"""Schedules: a quick trial, and the shipped ensemble's."""
LIMIT_FLIGHTS = 80_000
"""Number of new flights from which the limits of outliers are computed."""
REACH = ("log_thrust_to_weight", "log_impulse", "log_burn_time", "log_mass", "log_drag_area", "mach")
"""Features with stored training bounds; a flyer is warned outside them."""

Evaluation = Callable[[Ensemble, np.random.Generator], dict[str, Any]]


def train_field(
    out: Path,
    *,
    evaluate: Evaluation,
    seed: int = 1,
    n_train: int = 1_000_000,
    schedule: str = "published",
    effects: Sequence[str] = (),
    cluster: str = "",
    progress: TrainingProgress | None = None,
) -> dict[str, Any]:
    """Simulate, train, export into a new folder, evaluate, and return the results.

    `evaluate` returns the card's figures on new flights.

    On a `cluster`, as in `fieldkit.parallel.workers`, flights are simulated in parts that are stored in the new folder
    until the end, so that an interrupted run can resume. They differ from the flights that one machine draws in one go.

    Named effects act in every simulated flight of training and evaluation, with strengths drawn from their priors, so
    that the posterior allows for them. Raises BadValue for an unknown schedule or effect, too few flights, or a folder
    that already contains an ensemble, FieldkitError if the cluster cannot be used.
    """
    known_effects(effects)
    if schedule not in PLANS:
        raise BadValue(f"found the schedule {schedule!r}, expected one of {', '.join(PLANS)}")
    plan = PLANS[schedule]
    if n_train < plan.batch:
        raise BadValue(f"found {n_train} flights to train on, expected at least {plan.batch}")
    claim(out)
    began = time.perf_counter()
    known, _ = split_motors()
    streams = [np.random.default_rng(stream) for stream in np.random.SeedSequence(seed).spawn(5)]
    if cluster:
        with workers(cluster) as pool:
            truth = simulate_parts(out, seed, n_train, effects, pool)
    else:
        truth = simulate(streams[0], known, n_train, effects)
    flown = round(time.perf_counter() - began, 1)
    with one_thread(seed):
        members, mean, sd = fit(lambda: batch(streams[1], truth), plan, progress)
    exported = density_graph(members, mean, sd)
    card = _card(seed, n_train, schedule, plan, effects, on_cluster=bool(cluster)) | {
        "simulations": len(truth),
        "simulation_seconds": flown,
        "seconds": round(time.perf_counter() - began, 1),
        "reach": reach(features(measure(streams[2], truth.rows(slice(0, 100_000))))),
    }
    card["guard"] = outliers.limits(from_parts(exported, card, out), _fresh(streams[3], known, effects))
    card |= evaluate(from_parts(exported, card, out), streams[4])
    both = card["test"]["all ten"]
    files = ship(out, exported, card)
    drop_parts(out)
    return {
        "recipe": "field",
        "cd_mae": both["cd_mae"],
        "alpha_mae": both["alpha_mae"],
        "n_train": n_train,
        "seconds": card["seconds"],
        "files": files,
    }


def batch(rng: np.random.Generator, truth: Truth) -> Batch:
    """One observation of the flights, with new noise and new gaps."""
    whole = measure(rng, truth)
    observed = forget(rng, whole)
    target = logits(truth.parameters, *intervals(observed))
    arrays = features(observed), target, shown(observed.with_readouts(whole.readouts))
    return Batch(*(np.asarray(array, np.float32) for array in arrays))


def _fresh(rng: np.random.Generator, motors: list[Motor], effects: Sequence[str]) -> Observed:
    """New flights on these motors, with gaps in their readouts."""
    return forget(rng, measure(rng, simulate(rng, motors, LIMIT_FLIGHTS, effects)))


def reach(columns: Float[Array, "flight feature"]) -> dict[str, list[float]]:
    """For each feature in `REACH`, bounds that contain 99.96% of simulated flights, in the unit of the feature."""
    bounds = np.percentile(columns, [0.02, 99.98], axis=0)
    return {name: [float(bound) for bound in bounds[:, FEATURES.index(name)]] for name in REACH}


def _card(
    seed: int, n_train: int, schedule: str, plan: TrainingPlan, effects: Sequence[str], on_cluster: bool
) -> dict[str, Any]:
    """The card's content that is known before training."""
    named = (f" --effects {','.join(effects)}" if effects else "") + (" --cluster local" if on_cluster else "")
    options = f"--schedule {schedule} --seed {seed} --n-train {n_train}{named}"
    return {
        "name": "field",
        "recipe": "field",
        "physics": "field",
        "effects": list(effects),
        "effect_priors": priors(effects),
        "command": f"fieldkit train --recipe field {options} --out DIR",
        "seed": seed,
        "n_train": n_train,
        "priors": dict(PRIORS),
        "noise": {name: {"floor": n.floor, "share": n.relative, "step": n.step} for name, n in NOISE.items()},
        "accelerometer": {"offset": OFFSET, "gain": GAIN, "tail": TAIL},
        "intervals": INTERVALS,
        "held_out": HELD_OUT,
        "features": list(FEATURES),
        "outputs": ["log_drag_area", "alpha"],
        "parts": [MEMBERS, WIDTH + 2 * len(INDEPENDENT_READOUTS)],
        "guarded": list(INDEPENDENT_READOUTS),
        "network": {
            "members": MEMBERS,
            "hidden": [HIDDEN_UNITS] * LAYERS,
            "layer": "linear, SiLU",
            "gaussians": COMPONENTS,
        },
        "training": {"optimiser": "Adam, one cycle", "batch": plan.batch, "epochs": plan.epochs, "rate": plan.rate},
        "made_with": {name: version(name) for name in ("torch", "onnx", "numpy")},
    }
