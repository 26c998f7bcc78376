"""The history network and the linear fit on held-out simulated histories: coverage, ranks, inclusion."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.stats import rankdata

from fieldkit.inference.history.features import effect_names, feature_names
from fieldkit.inference.history.shards import HistoryTable
from fieldkit.inference.network.ensemble import Ensemble
from fieldkit.inference.network.history_parts import LEVELS, STANDARD, HistoryAnswer, answer
from fieldkit.shapes import Array, Flags, Float

FLIGHT_BINS = ((1, 2), (3, 5), (6, 12), (13, 25), (26, 60))
"""Groups by the number of flights."""
READOUT_BINS = ((1, 1), (2, 3), (4, 6))
"""Groups by the number of kinds of readouts."""
INTERVALS = {0.4: (0.3, 0.7), 0.8: (0.1, 0.9), 0.9: (0.05, 0.95)}
"""Levels of the ends of central intervals, by their coverage. [1]"""
RANK_BINS = 10
MIN_FLIGHTS_FOR_EFFECTS = 8
"""Minimum number of flights for evaluating inclusion effect by effect. [1]"""
DEEP_TAIL = 1e-4
"""Lowest rank of a truth, and distance of the highest from 1. [1]"""


def judge(ensemble: Ensemble, table: HistoryTable) -> dict[str, Any]:
    """The evaluation of the network and of its linear fit on these histories."""
    names = effect_names()
    estimate = answer(ensemble.members(table.features), len(names))
    z = (table.truth("log_apogee") - table.truth("mean")) / table.truth("sd")
    flights, readouts = table.truth("flights"), table.truth("readouts")
    return {
        "histories": len(z),
        "forecast": _forecast(estimate, z, table.truth("sd")),
        "by_flights": {
            f"{low}-{high}": _forecast(estimate, z, table.truth("sd"), (flights >= low) & (flights <= high))
            for low, high in FLIGHT_BINS
        },
        "by_readouts": {
            f"{low}-{high}": _forecast(estimate, z, table.truth("sd"), (readouts >= low) & (readouts <= high))
            for low, high in READOUT_BINS
        },
        "parameters": _parameters(estimate, table),
        "inclusion": _inclusion(estimate, table),
    }


def _forecast(
    estimate: HistoryAnswer, z: Array, sd: Array, rows: Flags | None = None
) -> dict[str, float | list[float] | int]:
    """Coverage, relative CRPS and ranks of the network, and of the linear fit as a normal distribution."""
    some = np.ones(len(z), bool) if rows is None else rows
    if not some.any():
        return {"histories": 0}
    own, truth, size = estimate.quantiles[some], z[some], sd[some]
    normal = np.broadcast_to(np.array(STANDARD), own.shape)
    rank = ranks(own, truth)
    counts, _ = np.histogram(rank, RANK_BINS, (0.0, 1.0))
    return {
        "histories": int(some.sum()),
        **{f"coverage{round(100 * level)}": _coverage(own, truth, *ends) for level, ends in INTERVALS.items()},
        **{
            f"linear_coverage{round(100 * level)}": _coverage(normal, truth, *ends) for level, ends in INTERVALS.items()
        },
        "crps": float((pinball(own, truth) * size).mean()),
        "linear_crps": float((pinball(normal, truth) * size).mean()),
        "median_error": float(np.median(np.abs(own[:, LEVELS.index(0.5)] - truth) * size)),
        "linear_median_error": float(np.median(np.abs(truth) * size)),
        "ranks": [float(x) for x in np.round(counts / counts.mean(), 3)],
    }


def _coverage(quantiles: Array, truth: Array, low: float, high: float) -> float:
    inside = (quantiles[:, LEVELS.index(low)] <= truth) & (truth <= quantiles[:, LEVELS.index(high)])
    return float(inside.mean())


def pinball(quantiles: Float[Array, "history level"], truth: Float[Array, "history"]) -> Float[Array, "history"]:
    """Twice the mean pinball loss over levels weighted by their spacing, which approximates the CRPS. [1]"""
    levels = np.array(LEVELS)
    ends = np.r_[0.0, 0.5 * (levels[1:] + levels[:-1]), 1.0]
    miss = truth[:, None] - quantiles
    return np.asarray(2 * (np.maximum(levels * miss, (levels - 1) * miss) @ np.diff(ends)))


def ranks(quantiles: Float[Array, "history level"], truth: Float[Array, "history"]) -> Float[Array, "history"]:
    """The rank of each truth in its forecast, interpolated between levels; beyond them it reaches `DEEP_TAIL`, or 1
    minus that, after two more steps. [1]"""
    known = np.r_[DEEP_TAIL, LEVELS, 1 - DEEP_TAIL]
    found = []
    for row, value in zip(quantiles, truth, strict=True):
        low, high = row[0] - 2 * (row[1] - row[0]), row[-1] + 2 * (row[-1] - row[-2])
        found.append(np.interp(value, [low, *row, high], known))
    return np.array(found)


def _parameters(estimate: HistoryAnswer, table: HistoryTable) -> dict[str, float]:
    """Errors and coverage of Cd and alpha, of the network and of the linear fit."""
    found: dict[str, float] = {}
    for column, name in enumerate(("cd", "alpha")):
        mean, sd, truth = (table.truth(key) for key in (f"{name}_mean", f"{name}_sd", f"log_{name}"))
        middle, spread = mean + sd * estimate.shift[:, column], sd * estimate.scale[:, column]
        found |= {
            f"{name}_mae": float(np.abs(np.exp(middle) - np.exp(truth)).mean()),
            f"linear_{name}_mae": float(np.abs(np.exp(mean) - np.exp(truth)).mean()),
            f"{name}_coverage90": float((np.abs(truth - middle) < 1.645 * spread).mean()),
            f"linear_{name}_coverage90": float((np.abs(truth - mean) < 1.645 * sd).mean()),
        }
    return found


def _inclusion(estimate: HistoryAnswer, table: HistoryTable) -> dict[str, Mapping[str, float]]:
    """How well the network and the linear evidence distinguish presence from absence, and the calibration."""
    names, columns = effect_names(), feature_names(effect_names())
    judged = (table.truth("selects") > 0.5) & (table.truth("flights") >= MIN_FLIGHTS_FOR_EFFECTS)
    found: dict[str, Mapping[str, float]] = {}
    for number, name in enumerate(names):
        rows = judged & (table.features[:, columns.index(f"{name}.acts")] > 0.5)
        score = table.features[:, columns.index(f"{name}.log_bayes")]
        found[name] = _presence(estimate.inclusion[rows, number], table.effects[rows, number], score[rows])
    unexplained = table.truth("unexplained")
    nothing = (table.effects.sum(axis=1) + unexplained == 0).astype(float)
    first, pattern = (table.features[:, columns.index(name)] for name in ("first", "pattern"))
    found["none"] = _presence(estimate.none[judged], nothing[judged], -np.maximum(first, pattern)[judged])
    found["unexplained"] = _presence(estimate.unexplained[judged], unexplained[judged], pattern[judged])
    return found


def _presence(chance: Array, there: Array, evidence: Array) -> dict[str, float]:
    """AUC of network and evidence, log score relative to the base rate [nat], and calibration of probabilities."""
    if not len(there) or not 0 < there.sum() < len(there):
        return {"histories": len(there), "present": float(there.sum())}
    limited, rate = np.clip(chance, 1e-4, 1 - 1e-4), float(there.mean())
    log_score = np.where(there > 0, np.log(limited), np.log1p(-limited))
    entropy = rate * np.log(rate) + (1 - rate) * np.log1p(-rate)
    order = np.argsort(chance)
    parts = [part for part in np.array_split(order, RANK_BINS) if len(part)]
    off = [abs(chance[part].mean() - there[part].mean()) * len(part) for part in parts]
    return {
        "histories": len(there),
        "present": float(there.sum()),
        "auc": auc(chance, there),
        "linear_auc": auc(evidence, there),
        "gain": float(log_score.mean() - entropy),
        "calibration_error": float(sum(off) / len(there)),
    }


def auc(score: Float[Array, "history"], there: Float[Array, "history"]) -> float:
    """Probability that a history with the effect scores above one without, ties by half. [1]"""
    present = there > 0.5
    count, others = int(present.sum()), int((~present).sum())
    if not count or not others:
        return float("nan")
    return float((rankdata(score)[present].sum() - count * (count + 1) / 2) / (count * others))
