"""Compares the field ensemble with other estimators on the same simulated flights: `python tools/rivals.py OUT.json`.

The rivals are `sbi`'s neural posterior estimation with default settings and a spline flow of `zuko` in the ensemble's
training loop, both with the ensemble's features and the same flights, and the ensemble's mixture at that size and as
shipped. The score is the mean log density of new flights for each set of readouts. A second run with the same numbers
reuses the rivals of the first for another ensemble. It needs torch, onnx, sbi and zuko; the last two are not in any
extra of fieldkit.
"""

import argparse
import json
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
import torch

from fieldkit.inference.network.ensemble import load_folder
from fieldkit.inference.network.field_ensemble import intervals, posterior
from fieldkit.inference.network.mixture import logits, mixture
from fieldkit.inference.training.density import MAX_FEATURE_SDS, TrainingPlan, fit
from fieldkit.inference.training.field import batch
from fieldkit.inference.training.fit import one_thread
from fieldkit.model.field_features import features
from fieldkit.model.observation_noise import SUBSETS, forget, measure
from fieldkit.model.prior_predictive import simulate, split_motors
from fieldkit.plugins import trained_folder

JUDGED = 5000
"""Number of new flights."""
FLOW_EPOCHS = 20
LogDensity = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Log density of logits [flight 2] given features [flight feature]."""


def scaler(columns: np.ndarray) -> Callable[[np.ndarray], torch.Tensor]:
    """Features for the rivals, standardized and clipped as in the ensemble."""
    mean, sd = columns.mean(axis=0), columns.std(axis=0) + 1e-6
    return lambda values: torch.from_numpy(
        ((values - mean) / sd).clip(-MAX_FEATURE_SDS, MAX_FEATURE_SDS).astype(np.float32)
    )


def by_sbi(observed: np.ndarray, target: np.ndarray) -> tuple[LogDensity, dict]:
    """NPE with default settings on one observation of the flights."""
    from sbi.inference import NPE

    scale = scaler(observed)
    began = time.process_time()
    trainer = NPE()
    trainer.append_simulations(torch.from_numpy(target.astype(np.float32)), scale(observed))
    estimator = trainer.train()

    def log_density(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            found = estimator.log_prob(torch.from_numpy(values.astype(np.float32))[None], scale(columns))
        return found[0].numpy().astype(float)

    return log_density, {"seconds": time.process_time() - began, "epochs": int(trainer.summary["epochs_trained"][-1])}


def by_zuko(observe: Callable, first: np.ndarray, count: int) -> tuple[LogDensity, dict]:
    """A neural spline flow of zuko in the ensemble's training loop: new observations in each epoch, one cycle of
    Adam."""
    import zuko

    scale = scaler(first)
    began = time.process_time()
    flow = zuko.flows.NSF(2, first.shape[1], transforms=3, bins=8, hidden_features=(128, 128, 128))
    optimiser = torch.optim.Adam(flow.parameters(), lr=1e-3)
    size = 2048
    cycle = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, 2e-3, total_steps=FLOW_EPOCHS * (count // size), pct_start=0.15
    )
    for _ in range(FLOW_EPOCHS):
        one = observe()
        x, y = scale(one.features.astype(float)), torch.from_numpy(one.target)
        order = torch.randperm(count)
        for first_row in range(0, count - size + 1, size):
            rows = order[first_row : first_row + size]
            loss = -flow(x[rows]).log_prob(y[rows]).mean()
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(flow.parameters(), 5.0)
            optimiser.step()
            cycle.step()

    def log_density(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            found = flow(scale(columns)).log_prob(torch.from_numpy(values.astype(np.float32)))
        return found.numpy().astype(float)

    return log_density, {"seconds": time.process_time() - began, "epochs": FLOW_EPOCHS}


def by_mixture(observe: Callable) -> tuple[LogDensity, dict]:
    """The ensemble's members at this size."""
    began = time.process_time()
    members, mean, sd = fit(observe, TrainingPlan(epochs=FLOW_EPOCHS))

    def log_density(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
        scaled = ((columns - mean) / sd).clip(-MAX_FEATURE_SDS, MAX_FEATURE_SDS).astype(np.float32)
        with torch.no_grad():
            parts = members(torch.from_numpy(scaled).expand(len(members.weights[0]), -1, -1)).numpy()
        low, high = np.zeros((len(columns), 2)), np.ones((len(columns), 2))
        place = 1 / (1 + np.exp(-values))
        density = mixture(parts.swapaxes(0, 1).astype(float), low, high).log_density(place)
        return density + np.log(place * (1 - place)).sum(axis=-1)

    return log_density, {"seconds": time.process_time() - began, "epochs": FLOW_EPOCHS}


def main() -> None:
    """Train and evaluate all, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--flights", type=int, default=50_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--shipped", type=Path, default=None)
    parser.add_argument("--without", nargs="*", default=[], help="rivals to leave out")
    options = parser.parse_args()
    known, _ = split_motors()
    streams = [np.random.default_rng(stream) for stream in np.random.SeedSequence(options.seed + 1000).spawn(4)]
    truth = simulate(streams[0], known, options.flights)
    fresh = simulate(streams[1], known, JUDGED)
    whole = measure(streams[1], fresh)
    judged = {name: whole.only(*kept) for name, kept in SUBSETS.items()} | {"any, with gaps": forget(streams[1], whole)}
    ensemble = load_folder(options.shipped or trained_folder("field"))
    found: dict = {"flights": len(truth), "judged": len(fresh), "seed": options.seed, "rivals": {}}
    if options.out.exists():
        before = json.loads(options.out.read_text(encoding="utf-8"))
        if all(before[key] == found[key] for key in ("flights", "judged", "seed")):
            found = before
    found["shipped"] = {
        name: float(posterior(one, ensemble).log_density(fresh.parameters).mean()) for name, one in judged.items()
    }
    with one_thread(options.seed):
        once = batch(streams[2], truth)
        ways = {
            "sbi": lambda: by_sbi(once.features.astype(float), once.target.astype(float)),
            "zuko": lambda: by_zuko(lambda: batch(streams[3], truth), once.features.astype(float), len(truth)),
            "mixture": lambda: by_mixture(lambda: batch(streams[3], truth)),
        }
        for name, train in ways.items():
            if name in options.without:
                continue
            log_density, about = train()
            about["made_with"] = {one: version(one) for one in ("torch", name) if one != "mixture"}
            found["rivals"][name] = about | {"log_density": _judge(log_density, fresh, judged)}
            print(name, found["rivals"][name], flush=True)
    options.out.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


def _judge(log_density: LogDensity, fresh, judged: dict) -> dict[str, float]:
    scores = {}
    for name, observed in judged.items():
        low, high = intervals(observed)
        place = (fresh.parameters - low) / (high - low)
        stretch = np.log(place * (1 - place) * (high - low)).sum(axis=-1)
        density = log_density(features(observed), logits(fresh.parameters, low, high)) - stretch
        scores[name] = float(density.mean())
    return scores


if __name__ == "__main__":
    main()
