"""The columns of the features: for the history, for the evidence of all effects, and for each effect.

Derivation: counts and ratios enter as logarithms. Kurtosis, lag-1 autocorrelation and trend are ratios of sample
moments of the residuals. The evidence of an effect is the log of the mean Bayes factor of its places, by the prior
weights of these; evidence is limited and compressed by the inverse hyperbolic sine.
"""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from fieldkit.inference.history.evidence import Trials, conditional
from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.records import History
from fieldkit.inference.laplace.leave_one_out import LeaveOneOut
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data
from fieldkit.model.rocket_model import groups
from fieldkit.physics.setups import recorded
from fieldkit.shapes import Array, Float

MAX_LOG_BAYES = 60.0
"""Limit of the evidence in the features. [nat]"""
LOG_BAYES_SCALE = 4.0
"""Unit of evidence under the inverse hyperbolic sine, which is linear for weak evidence. [nat]"""
PER_EFFECT = (
    "log_bayes",
    "robust",
    "best",
    "beside_best",
    "beside_pattern",
    "by_forecast_fit",
    "places",
    "size",
    "z",
    "acts",
)
"""Features of every effect."""
OF_HISTORY = (
    "flights",
    *(f"seen_{name}" for name in OBSERVED_READOUTS[:6]),
    "motors",
    "configs",
    "sites",
    "days",
    "wind",
    "temperature",
    "diameter",
    "mach",
    "offset",
    "scatter",
    "reading",
    "scatter_of_forecast",
    "reading_of_forecast",
    "misfit",
    "largest_residual",
    "largest_of_any",
    "kurtosis",
    "lag",
    "trend",
    "any_effect",
    "first",
    "second",
    "pattern",
    "pattern_robust",
    "pattern_best",
    "pattern_beside_best",
    "pattern_by_forecast_fit",
    "forecast_sd",
    "parameter_sd",
    "shift",
    "shift_sd",
    "shift_of_first",
    "robust_shift",
    "trust",
    "on_motor",
    "on_config",
    "cd_sd",
    "alpha_sd",
    "cd_alpha",
)
"""Features of the whole history and of the plan."""


def of_history(
    history: History, selection: LinearFit, plain: LinearFit, robustly: LinearFit, data: Data, left_out: LeaveOneOut
) -> dict[str, float | Array]:
    """Columns of the flights, and for the number of earlier flights of each plan's motor and configuration."""
    count = len(history.used_in_fit)
    flown = history.flights[:count]
    used = max(int(data.seen.any(axis=1).sum()), 1)
    kinds = {per: groups(history.flights, history.found, per) for per in ("motor", "config", "site", "day")}
    wind, temperature, diameter = (recorded(flown, name) for name in ("wind", "temperature", "diameter"))
    residual = _residuals(left_out, data)
    apogee = residual[data.seen[:, 0], 0] if data.seen[:, 0].any() else np.zeros(1)
    centered = apogee - apogee.mean()
    variance = max(float((centered**2).mean()), 1e-9)
    order = np.linspace(-1, 1, len(centered)) if len(centered) > 1 else np.zeros(1)
    speed = np.exp(np.nanmedian(selection.fit.tangent.values[:, 1]))
    fraction = {name: float(data.seen[:, i].mean()) for i, name in enumerate(OBSERVED_READOUTS[:6])}
    return {
        "flights": float(np.log(used)),
        **{f"seen_{name}": value for name, value in fraction.items()},
        **{f"{per}s": float(np.log(len(set(kind[:count])))) for per, kind in kinds.items()},
        "wind": float(np.nan_to_num(wind).std()),
        "temperature": float(np.isfinite(temperature).mean()),
        "diameter": float(np.isfinite(diameter).mean()),
        "mach": float(speed / 340.0),
        "offset": selection.offset,
        **_scales(selection, ""),
        **_scales(plain, "_of_forecast"),
        "misfit": float(np.log(max(float((apogee**2).mean()), 1e-3))),
        "largest_residual": float(np.log1p(np.abs(apogee).max())),
        "largest_of_any": float(np.log1p(np.nanmax(np.abs(residual), initial=0.0))),
        "kurtosis": float(np.log((centered**4).mean() / variance**2 + 0.1)),
        "lag": float((centered[1:] * centered[:-1]).sum() / (variance * len(centered))) if len(centered) > 2 else 0.0,
        "trend": float((centered * order).mean() / np.sqrt(variance) * np.sqrt(len(centered))),
        "trust": float(np.log(max(float(robustly.fit.data.trust.min(initial=1.0)), 1e-3))),
        "on_motor": _before(kinds["motor"], data),
        "on_config": _before(kinds["config"], data),
    }


def _residuals(left_out: LeaveOneOut, data: Data) -> Float[Array, "flight readout"]:
    """Standardized leave-one-out residuals; nan if not observed."""
    weight = np.exp(left_out.log_weight - np.logaddexp.reduce(left_out.log_weight, axis=0))
    return np.where(data.seen, np.einsum("sf,sfo->fo", weight, left_out.residual), np.nan)


def _scales(linear: LinearFit, suffix: str) -> dict[str, float]:
    """Posterior mean logarithms of both scales, in prior standard deviations."""
    prior = linear.model.hyperprior
    scatter, reading, _ = prior.scales()
    weights = linear.fit.weights
    return {
        f"scatter{suffix}": float(weights @ np.log(scatter / prior.scatter.median) / prior.scatter.log_sd),
        f"reading{suffix}": float(weights @ np.log(reading / prior.reading.median) / prior.reading.log_sd),
    }


def _before(kinds: Sequence[str], data: Data) -> Float[Array, "plan"]:
    """Log of one plus the number of earlier flights in each plan's group."""
    count = len(data.seen)
    flown = Counter(kind for kind, seen in zip(kinds[:count], data.seen[:, 0].tolist(), strict=True) if seen)
    return np.asarray(np.log1p(np.array([flown[kind] for kind in kinds[count:]], float)))


def shown_evidence(log_bayes: Array | float) -> Array:
    """Evidence in the form that the network receives. [1]"""
    limited = np.minimum(np.maximum(log_bayes, -MAX_LOG_BAYES), MAX_LOG_BAYES)
    return np.asarray(np.arcsinh(limited / LOG_BAYES_SCALE))


def families(trials: Trials) -> dict[str, list[int]]:
    """Rows of trials by the name in a verdict; patterns have an empty name."""
    found: dict[str, list[int]] = {}
    for row, name in enumerate(trials.family):
        found.setdefault(name, []).append(row)
    return found


def _sum(trials: Trials, rows: Sequence[int], which: str = "log_bayes") -> float:
    some = list(rows)
    return float(np.logaddexp.reduce(getattr(trials, which)[some] + trials.log_share[some]))


def _leaders(trials: Trials) -> dict[str, int]:
    """The strongest trial of each family."""
    weight = trials.weight.tolist()
    return {name: max(rows, key=weight.__getitem__) for name, rows in families(trials).items()}


def of_evidence(trials: Trials, beside_forecast: Trials) -> dict[str, float | Array]:
    """The strongest effects, patterns, and the shift of each plan's forecast by effects."""
    by_family = families(trials)
    bayes = {name: _sum(trials, rows) for name, rows in by_family.items()}
    named = sorted((value for name, value in bayes.items() if name), reverse=True)
    columns: dict[str, float | Array] = {
        "any_effect": float(shown_evidence(np.logaddexp.reduce(named) - np.log(len(named)))) if named else 0.0,
        "first": float(shown_evidence(named[0])) if named else 0.0,
        "second": float(shown_evidence(named[1])) if len(named) > 1 else 0.0,
    }
    leaders = _leaders(trials)
    pattern = by_family.get("", [])
    columns |= {
        "pattern": float(shown_evidence(bayes[""])) if pattern else 0.0,
        "pattern_robust": float(shown_evidence(_sum(trials, pattern, "robust"))) if pattern else 0.0,
        "pattern_best": float(shown_evidence(trials.log_bayes[leaders[""]])) if pattern else 0.0,
        "pattern_beside_best": 0.0,
        "pattern_by_forecast_fit": 0.0,
    }
    if pattern and named:
        first = max((name for name in bayes if name), key=lambda name: bayes[name])
        beside = conditional(trials, [leaders[""], leaders[first]])
        columns["pattern_beside_best"] = float(shown_evidence(beside[0, 1]))
        rows = families(beside_forecast)[""]
        columns["pattern_by_forecast_fit"] = float(shown_evidence(_sum(beside_forecast, rows)))
    return columns | _shifts(beside_forecast)


def _shifts(trials: Trials) -> dict[str, Array]:
    """The shift of each plan's log apogee by effects, averaged over their posteriors."""
    by_family = {name: rows for name, rows in families(trials).items() if name}
    if not by_family:
        return dict.fromkeys(("shift", "shift_sd", "shift_of_first"), np.zeros(len(trials.forecast_gain)))
    moved = trials.forecast_gain * trials.mean
    moved_sd = trials.forecast_gain * trials.sd
    odds = {name: _sum(trials, rows) - np.log(2.0 * len(by_family)) for name, rows in by_family.items()}
    total = np.logaddexp.reduce([0.0, *odds.values()])
    shift, square = np.zeros((2, len(moved)))
    for name, rows in by_family.items():
        share = np.exp(trials.weight[rows] - np.logaddexp.reduce(trials.weight[rows]))
        part = float(np.exp(odds[name] - total))
        shift += part * (moved[:, rows] @ share)
        square += part * ((moved[:, rows] ** 2 + moved_sd[:, rows] ** 2) @ share)
    first = max(odds, key=lambda name: odds[name])
    leader = max(by_family[first], key=lambda row: float(trials.weight[row]))
    return {
        "shift": shift,
        "shift_sd": np.sqrt(np.maximum(square - shift**2, 0.0)),
        "shift_of_first": moved[:, leader],
    }


def of_effects(trials: Trials, beside_forecast: Trials, names: Sequence[str]) -> list[Mapping[str, float]]:
    """Features of each effect; zeros for one that these flights cannot show."""
    by_family, other = families(trials), families(beside_forecast)
    leaders = _leaders(trials)
    present = [name for name in leaders if name]
    order = [*present, *([""] if "" in leaders else [])]
    beside = conditional(trials, [leaders[name] for name in order]) if order else np.empty((0, 0))
    rows: list[Mapping[str, float]] = []
    for name in names:
        if name not in by_family:
            rows.append(dict.fromkeys(PER_EFFECT, 0.0))
            continue
        own, leader, place = by_family[name], leaders[name], order.index(name)
        others = [i for i, one in enumerate(order) if one and one != name]
        strongest = max(others, key=lambda i: float(beside[i, i]), default=None)
        rows.append(
            {
                "log_bayes": float(shown_evidence(_sum(trials, own))),
                "robust": float(shown_evidence(_sum(trials, own, "robust"))),
                "best": float(shown_evidence(trials.log_bayes[leader])),
                "beside_best": 0.0 if strongest is None else float(shown_evidence(beside[place, strongest])),
                "beside_pattern": float(shown_evidence(beside[place, -1])) if "" in leaders else 0.0,
                "by_forecast_fit": float(shown_evidence(_sum(beside_forecast, other[name]))),
                "places": float(np.log(len(own))),
                "size": float(trials.mean[leader] / trials.prior_sd[leader]),
                "z": float(trials.mean[leader] / trials.sd[leader] / 4.0),
                "acts": 1.0,
            }
        )
    return rows
