"""Scores of the linear pass, with and without its calibrated width, and of the networks on simulated histories."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import rankdata

from fieldkit.model.causes import NAMES
from fieldkit.scoring.proper_scores import crps
from fieldkit.shapes import Array, Flags, Integers
from studies.quick_network.network import FlightsNetwork, answers
from studies.quick_network.tables import WorldTable

NORMAL_DRAWS = np.random.default_rng(0).normal(size=400)
STUDENT_DRAWS = np.random.default_rng(0).standard_t(4, size=400)
"""Draws of standard distributions."""


def auc(score: Array, there: Array) -> float:
    """Probability that a case with the effect scores above one without, ties by half. [1]"""
    present = there > 0.5
    count, others = int(present.sum()), int((~present).sum())
    if not count or not others:
        return float("nan")
    return float((rankdata(score)[present].sum() - count * (count + 1) / 2) / (count * others))


def scored(draws: Array, flown: float) -> tuple[float, float, float, float]:
    """CRPS and error of the median relative to the flown apogee, whether it is in the 90% interval, and its width."""
    low, middle, high = np.quantile(draws, (0.05, 0.5, 0.95))
    return crps(draws, flown) / flown, abs(middle / flown - 1), float(low <= flown <= high), (high - low) / flown


def log_scores(log_odds: Array, there: Array) -> Array:
    """Log score of each probability, given as log odds. [nat]"""
    return -np.where(there > 0.5, np.logaddexp(0, -log_odds), np.logaddexp(0, log_odds))


def pooled(parts: Sequence[Array], there: Array, fold: Integers) -> tuple[Array, list[float]]:
    """Log odds of the logarithmic pool of some log odds and a level, with weights learned from the other half of the
    histories by log score, and the weights from all."""
    columns = np.column_stack([*parts, np.ones(len(parts[0]))])

    def weights(rows: Flags) -> Array:
        def cost(weight: Array) -> float:
            return -float(log_scores(columns[rows] @ weight, there[rows]).mean())

        start = np.r_[np.full(len(parts), 1 / len(parts)), 0.0]
        return np.asarray(minimize(cost, start, method="BFGS").x)

    whole = np.zeros(len(there))
    for side in (0, 1):
        whole[fold == side] = columns[fold == side] @ weights(fold != side)
    return whole, [round(float(x), 3) for x in weights(np.ones(len(there), bool))]


def of_probabilities(ways: Mapping[str, Array], there: Array) -> dict[str, Any]:
    """AUC and log score of each way of answering, as log odds, and the difference of its log score from the first."""
    first = log_scores(next(iter(ways.values())), there)
    found = {}
    for name, odds in ways.items():
        own = log_scores(odds, there)
        error = (own - first).std() / np.sqrt(len(own))
        found[name] = {
            "auc": round(auc(odds, there), 4),
            "log_score": round(float(own.mean()), 5),
            "gain": round(float((own - first).mean()), 5),
            "gain_sd": round(float(error), 5),
        }
    return found


def _logit(chance: Array) -> Array:
    limited = np.clip(chance.astype(float), 1e-7, 1 - 1e-7)
    return np.asarray(np.log(limited / (1 - limited)))


def scores(networks: Mapping[str, list[FlightsNetwork]], table: WorldTable) -> dict[str, Any]:
    """All scores on a table."""
    flown = np.exp(table.column("log_apogee").astype(float))
    mean, sd = table.column("mean")[:, None].astype(float), table.column("sd")[:, None].astype(float)
    forecasts = {"linear": mean + sd * NORMAL_DRAWS, "linear, calibrated width": table.mixture.astype(float)}
    acts = table.acts > 0.5
    fold = np.broadcast_to(np.arange(len(acts))[:, None] // 6 % 2, acts.shape)[acts]
    there, effect_odds = table.present[acts].astype(float), {"closed form": table.odds[acts].astype(float)}
    nothing = (table.present.sum(axis=1) + table.column("unexplained") == 0).astype(float)
    none_odds = {"closed form": table.column("none_odds").astype(float)}
    judged = table.judged > 0.5
    cause, usual = table.causes[judged], len(NAMES)
    chances = {"closed form": table.cause_chance[judged].astype(float)}
    for name, some in networks.items():
        causes, effects, middle, width = answers(some, table)
        forecasts[name] = middle[:, None] + width[:, None] * STUDENT_DRAWS
        effect_odds[name] = _logit(effects[:, :-2][acts])
        none_odds[name] = _logit(effects[:, -2])
        chances[name] = causes[judged]
    rows = {
        name: np.array([scored(np.exp(np.clip(row, -5, 12)), one) for row, one in zip(draws, flown, strict=True)])
        for name, draws in forecasts.items()
    }
    effect_odds["closed form, weighted"], closed_weights = pooled([effect_odds["closed form"]], there, fold)
    weights: dict[str, list[float]] = {"closed form": closed_weights}
    for name in networks:
        key = f"{name} pooled"
        effect_odds[key], weights[name] = pooled([effect_odds["closed form"], effect_odds[name]], there, fold)
    has = (cause != usual).astype(float)
    one_hot = {name: np.log(np.clip(own[np.arange(len(cause)), cause], 1e-7, 1)) for name, own in chances.items()}
    each = {
        name: {
            kind: round(auc(_logit(own[:, place]), (cause == place).astype(float)), 3)
            for place, kind in enumerate(NAMES)
            if (cause == place).any()
        }
        for name, own in chances.items()
    }
    return {
        "histories": len(flown),
        "forecast": {
            name: {
                "crps": round(float(own[:, 0].mean()), 5),
                "ratio": round(float(own[:, 0].mean() / rows["linear"][:, 0].mean()), 4),
                "median_error": round(float(np.median(own[:, 1])), 4),
                "coverage90": round(float(own[:, 2].mean()), 4),
                "width": round(float(np.median(own[:, 3])), 4),
            }
            for name, own in rows.items()
        },
        "effects": of_probabilities(effect_odds, there) | {"present": int(there.sum())},
        "pooling_weights": weights,
        "none": of_probabilities(none_odds, nothing),
        "causes": {
            **of_probabilities({name: -_logit(own[:, usual]) for name, own in chances.items()}, has),
            "flights": len(cause),
            "with": int(has.sum()),
            "log_score_of_cause": {name: round(float(own.mean()), 4) for name, own in one_hot.items()},
            "auc_of_cause": each,
        },
    }


def compared_with_fit(rows: Mapping[str, Sequence[Sequence[float]]]) -> Any:
    """Means, and the ratio of each CRPS to the fit's with its 90% bootstrap interval."""
    fit = np.array(rows["fit"])[:, 0]
    some = np.random.default_rng(1).integers(len(fit), size=(2000, len(fit)))
    found: dict[str, Any] = {"flights": len(fit)}
    for name, scores in rows.items():
        own = np.array(scores)
        ratios = own[some, 0].mean(axis=1) / fit[some].mean(axis=1)
        found[name] = {
            "crps": round(float(own[:, 0].mean()), 4),
            "ratio": round(float(own[:, 0].mean() / fit.mean()), 3),
            "ratio90": [round(float(x), 3) for x in np.quantile(ratios, (0.05, 0.95))],
            "coverage90": round(float(own[:, 2].mean()), 3),
            "width": round(float(np.median(own[:, 3])), 3),
        }
    return found
