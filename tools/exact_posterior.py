"""Compares the field ensemble with the exact posterior of its problem: `python tools/exact_posterior.py OUT.json`.

Everything random in a simulated flight is integrated out by importance sampling (`studies.exact.integrated`), for some
new flights and each set of readouts. This gives the lowest possible error of any method, and the distance of the
ensemble's densities from the exact ones. `--held-out` uses the held-out manufacturer's motors. It takes about a second
of one core per flight and set of readouts. A second run with the same numbers reuses the integrals of the first for
another ensemble.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
from scipy.special import ndtr
from scipy.stats import norm

from fieldkit.inference.network.ensemble import Ensemble, load_folder
from fieldkit.inference.network.field_ensemble import posterior
from fieldkit.inference.network.mixture import Mixture
from fieldkit.model.observation_noise import SUBSETS, measure
from fieldkit.model.observations import ALPHA_RANGE, ALPHA_SD, CD_RANGE, disc
from fieldkit.model.prior_predictive import Truth, flown_motors, simulate, split_motors
from fieldkit.motors import catalogue
from fieldkit.plugins import trained_folder
from studies.exact.integrated import Draws, integrate
from studies.exact.likelihood import Problem, normals_of, parameters, problem

NAMES = ("apogee", "apogee, speed", "all ten")
MIN_EFFECTIVE_DRAWS = 50.0
"""Minimum number of effective draws of a valid integral. [1]"""
BLOCK = 25
"""Number of flights integrated together."""


def medians(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Moments of weighted draws [flight draw]."""
    order = np.argsort(values, axis=1)
    below = np.cumsum(np.take_along_axis(weight, order, axis=1), axis=1)
    return np.array(
        [row[np.searchsorted(b, 0.5)] for row, b in zip(np.take_along_axis(values, order, 1), below, strict=True)]
    )


def log_prior(truth: Truth) -> np.ndarray:
    """Log prior density of the logarithm of drag area, and alpha."""
    low, high = np.log(CD_RANGE)
    ends = ndtr((np.array(ALPHA_RANGE) - 1) / ALPHA_SD)
    return norm.logpdf(truth.alpha, 1, ALPHA_SD) - np.log(ends[1] - ends[0]) - np.log(high - low)


def exactly(
    rng: np.random.Generator, one: Problem, truth: Truth, begin: np.ndarray, count: int
) -> dict[str, np.ndarray]:
    """Of each flight: errors of the exact medians, exact log density of the truth, its rank, effective draws."""
    diameter = truth.declared[:, 1]
    draws: Draws = integrate(rng, one, normals_of(begin, diameter), count)
    at_truth = integrate(rng, one, normals_of(truth.parameters, diameter), count, fixed=True)
    flights, each, _ = draws.normals.shape
    area, alpha = parameters(draws.normals.reshape(flights * each, -1), np.repeat(diameter, each))
    best = [medians(values.reshape(flights, each), draws.weight) for values in (area, alpha)]
    return {
        "cd_exact": np.abs(np.exp(best[0]) / disc(diameter) - truth.cd),
        "alpha_exact": np.abs(best[1] - truth.alpha),
        "log_density_exact": at_truth.log_evidence + log_prior(truth) - draws.log_evidence,
        "rank": ((area.reshape(flights, each) < truth.parameters[:, :1]) * draws.weight).sum(axis=1),
        "size": np.minimum(draws.size, at_truth.size),
    }


def by_ensemble(density: Mixture, truth: Truth) -> dict[str, np.ndarray]:
    """Of each flight: errors of the ensemble's medians, and its log density of the truth."""
    found = density_medians(density)
    return {
        "cd": np.abs(np.exp(found[:, 0]) / disc(truth.declared[:, 1]) - truth.cd),
        "alpha": np.abs(found[:, 1] - truth.alpha),
        "log_density": density.log_density(truth.parameters),
    }


def density_medians(density: Mixture) -> np.ndarray:
    """Medians of both parameters [flight 2]."""
    return np.stack([density.margin(axis).quantiles(np.array([0.5]))[:, 0] for axis in (0, 1)], axis=-1)


def summary(rows: dict[str, np.ndarray]) -> dict[str, float]:
    """Means over the flights with valid integrals."""
    kept = rows["size"] >= MIN_EFFECTIVE_DRAWS
    gap = (rows["log_density_exact"] - rows["log_density"])[kept]
    means = {name: float(values[kept].mean()) for name, values in rows.items() if name not in ("rank", "size")}
    errors = {}
    for name in ("cd", "alpha"):
        ratio = rows[name][kept].mean() / rows[f"{name}_exact"][kept].mean() - 1
        spread = (rows[name] - rows[f"{name}_exact"])[kept].std() / np.sqrt(kept.sum())
        errors[f"{name}_above_limit"] = float(ratio)
        errors[f"{name}_above_limit_se"] = float(spread / rows[f"{name}_exact"][kept].mean())
    return (
        {"flights": int(kept.sum()), "not_found": int((~kept).sum())}
        | means
        | errors
        | {"kl": float(gap.mean()), "kl_se": float(gap.std() / np.sqrt(len(gap)))}
        | {"ranks": np.histogram(rows["rank"][kept], 5, (0, 1))[0].tolist()}
    )


def main() -> None:
    """Integrate, compare, write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--flights", type=int, default=200)
    parser.add_argument("--draws", type=int, default=600, help="of each proposal")
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--held-out", action="store_true")
    parser.add_argument("--ensemble", type=Path, default=None)
    options = parser.parse_args()
    ensemble: Ensemble = load_folder(options.ensemble or trained_folder("field"))
    motors = flown_motors(catalogue().motors)
    rng = np.random.default_rng(options.seed)
    began = time.process_time()
    truth = simulate(rng, split_motors()[1] if options.held_out else split_motors()[0], options.flights)
    whole = measure(rng, truth)
    settings = {"held_out": options.held_out, "seed": options.seed, "draws": options.draws, "asked": options.flights}
    before = json.loads(options.out.read_text(encoding="utf-8")) if options.out.exists() else {}
    if any(before.get(key) != value for key, value in settings.items()):
        before = {}
    found: dict = settings | {"integrals": before.get("integrals", {})}
    for name in NAMES:
        observed = whole.only(*SUBSETS[name])
        density = posterior(observed, ensemble)
        if name not in found["integrals"]:
            parts = []
            for first in range(0, len(truth), BLOCK):
                block = slice(first, first + BLOCK)
                one = problem(truth.rows(block), observed.rows(block), motors)
                begin = density_medians(density)[block]
                parts.append(exactly(rng, one, truth.rows(block), begin, options.draws))
            joined = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
            found["integrals"][name] = {key: [round(float(one), 5) for one in values] for key, values in joined.items()}
        rows = {key: np.array(values) for key, values in found["integrals"][name].items()}
        found[name] = summary(rows | by_ensemble(density, truth))
        print(name, found[name], flush=True)
        options.out.write_text(json.dumps(found) + "\n", encoding="utf-8")
    print(f"{time.process_time() - began:.0f} s of one core")


if __name__ == "__main__":
    main()
