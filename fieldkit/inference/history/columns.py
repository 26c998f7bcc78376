"""The columns of the features: for the history, for the evidence of all effects, and for each effect.

Derivation: counts and ratios enter as logarithms. Kurtosis, lag-1 autocorrelation and trend are ratios of sample
moments of the residuals. The evidence of an effect is the log of the mean Bayes factor of its places, by the prior
weights of these; evidence is limited and compressed by the inverse hyperbolic sine. Log odds are those of sets of at
most two effects.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from fieldkit.inference.history.evidence import Trials, conditional
from fieldkit.inference.history.joint_evidence import log_odds
from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.laplace.leave_one_out import LeaveOneOut
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data
from fieldkit.physics.history import History
from fieldkit.shapes import Array, Float

MAX_LOG_BAYES = 60.0
"""Limit of the evidence in the features. [nat]"""
NAME_OF_NOTHING = "nothing"
"""The name that `odds_of` gives to a model without any effect or pattern."""
LOG_BAYES_SCALE = 4.0
"""Unit of evidence under the inverse hyperbolic sine, which is linear for weak evidence. [nat]"""
ODDS, NONE_ODDS, PATTERN_ODDS = "odds", "none_odds", "pattern_odds"
"""The log odds of an effect, of nothing and of a pattern, from sets of at most two effects. [nat]"""
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
    ODDS,
)
"""Features of every effect."""
EVIDENCE_COLUMNS = PER_EFFECT.index("places")
"""Number of an effect's first features, which are evidence. [1]"""
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
    NONE_ODDS,
    PATTERN_ODDS,
)
"""Features of the whole history and of the plan."""


def of_history(
    history: History, selection: LinearFit, plain: LinearFit, robustly: LinearFit, data: Data, left_out: LeaveOneOut
) -> dict[str, float | Array]:
    """Columns of the flights, and for the number of earlier flights with an apogee on each plan's motor and in its
    configuration."""
    count = history.flown
    used = max(int(data.seen.any(axis=1).sum()), 1)
    kinds = {per: history.groups(per) for per in ("motor", "config", "site", "day")}
    wind, temperature, diameter = (history.column(name)[:count] for name in ("wind", "temperature", "diameter"))
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
    """Log of one plus the number of earlier flights with an apogee in each plan's group."""
    count = len(data.seen)
    flown = Counter(kind for kind, seen in zip(kinds[:count], data.seen[:, 0].tolist(), strict=True) if seen)
    return np.asarray(np.log1p(np.array([flown[kind] for kind in kinds[count:]], float)))


def shown_evidence(log_bayes: Array | float) -> Array:
    """Evidence [nat] in the form that the network receives, elementwise. [1]"""
    limited = np.minimum(np.maximum(log_bayes, -MAX_LOG_BAYES), MAX_LOG_BAYES)
    return np.asarray(np.arcsinh(limited / LOG_BAYES_SCALE))


def families(trials: Trials) -> Mapping[str, list[int]]:
    """Rows of trials by the name in a verdict; patterns have an empty name."""
    return _rows_of(trials.family)


@lru_cache(maxsize=16)
def _rows_of(family: tuple[str, ...]) -> Mapping[str, list[int]]:
    """Cached, because each readout that is typed asks several times for the same candidates."""
    found: dict[str, list[int]] = {}
    for row, name in enumerate(family):
        found.setdefault(name, []).append(row)
    return MappingProxyType(found)


def _sums(trials: Trials, which: str = "log_bayes") -> dict[str, float]:
    """The evidence of each family, averaged over its trials by their prior weights. [nat]"""
    groups = families(trials)
    if not groups:
        return {}
    order = [row for rows in groups.values() for row in rows]
    starts = np.cumsum([0, *(len(rows) for rows in groups.values())])[:-1]
    joint = (getattr(trials, which) + trials.log_fraction)[order]
    return dict(zip(groups, np.logaddexp.reduceat(joint, starts).tolist(), strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class RankedFamilies:
    """Trials with the evidence of their families [nat], the row of the strongest trial of each by evidence with its
    prior, and the evidence of these trials beside each other, alone on the diagonal [nat]."""

    trials: Trials
    log_bayes: Mapping[str, float]
    leaders: Mapping[str, int]
    beside: Float[Array, "family family"]


def ranked(trials: Trials) -> RankedFamilies:
    """The evidence of the families of trials, compared with each other."""
    weight = trials.weight.tolist()
    leaders = {name: max(rows, key=weight.__getitem__) for name, rows in families(trials).items()}
    beside = conditional(trials, list(leaders.values())) if leaders else np.empty((0, 0))
    return RankedFamilies(trials, _sums(trials), leaders, beside)


def of_evidence(found: RankedFamilies, beside_forecast: Trials, odds: Mapping[str, float]) -> dict[str, float | Array]:
    """The strongest effects, patterns, and the shift of each plan's forecast by effects; `odds` are as in
    `odds_of`."""
    trials, bayes = found.trials, found.log_bayes
    named = sorted((value for name, value in bayes.items() if name), reverse=True)
    columns: dict[str, float | Array] = {
        "any_effect": float(shown_evidence(np.logaddexp.reduce(named) - np.log(len(named)))) if named else 0.0,
        "first": float(shown_evidence(named[0])) if named else 0.0,
        "second": float(shown_evidence(named[1])) if len(named) > 1 else 0.0,
        NONE_ODDS: odds[NAME_OF_NOTHING],
        PATTERN_ODDS: odds.get("", 0.0),
    }
    pattern = "" in bayes
    columns |= {
        "pattern": float(shown_evidence(bayes[""])) if pattern else 0.0,
        "pattern_robust": float(shown_evidence(_sums(trials, "robust")[""])) if pattern else 0.0,
        "pattern_best": float(shown_evidence(trials.log_bayes[found.leaders[""]])) if pattern else 0.0,
        "pattern_beside_best": 0.0,
        "pattern_by_forecast_fit": 0.0,
    }
    if pattern and named:
        order = list(found.leaders)
        first = max((name for name in bayes if name), key=lambda name: bayes[name])
        columns["pattern_beside_best"] = float(shown_evidence(found.beside[order.index(""), order.index(first)]))
        columns["pattern_by_forecast_fit"] = float(shown_evidence(_sums(beside_forecast)[""]))
    return columns | _shifts(beside_forecast)


def odds_of(found: RankedFamilies) -> dict[str, float]:
    """The log odds that each family is present beside the others, and that none is (`NAME_OF_NOTHING`). [nat]"""
    each, none = log_odds(np.array([found.log_bayes[name] for name in found.leaders]), found.beside)
    return dict(zip(found.leaders, each.tolist(), strict=True)) | {NAME_OF_NOTHING: none}


def _shifts(trials: Trials) -> dict[str, Array]:
    """The shift of each plan's log apogee by effects, averaged over their posteriors."""
    by_family = {name: rows for name, rows in families(trials).items() if name}
    if not by_family:
        return dict.fromkeys(("shift", "shift_sd", "shift_of_first"), np.zeros(len(trials.forecast_gain)))
    rows = [row for some in by_family.values() for row in some]
    moved, moved_sd = (trials.forecast_gain[:, rows] * part[rows] for part in (trials.mean, trials.sd))
    weight = trials.weight[rows] - np.log(2.0 * len(by_family))
    chance = np.exp(weight - np.logaddexp.reduce([0.0, *weight.tolist()]))
    bayes = _sums(trials)
    first = by_family[max(by_family, key=lambda name: bayes[name])]
    leader = max(first, key=lambda row: float(trials.weight[row]))
    shift = moved @ chance
    square = (moved**2 + moved_sd**2) @ chance
    return {
        "shift": shift,
        "shift_sd": np.sqrt(np.maximum(square - shift**2, 0.0)),
        "shift_of_first": moved[:, rows.index(leader)],
    }


def of_effects(
    found: RankedFamilies, beside_forecast: Trials, odds: Mapping[str, float], names: Sequence[str]
) -> Float[Array, "effect column"]:
    """The columns `PER_EFFECT` of each effect; zeros for one that these flights cannot show. [1]"""
    trials, leaders, beside = found.trials, found.leaders, found.beside
    by_family, order = families(trials), list(leaders)
    robust, by_forecast = _sums(trials, "robust"), _sums(beside_forecast)
    columns = np.zeros((len(names), len(PER_EFFECT)))
    for row, name in enumerate(names):
        if name not in by_family:
            continue
        leader, place = leaders[name], order.index(name)
        others = [i for i, other in enumerate(order) if other and other != name]
        strongest = max(others, key=lambda i: float(beside[i, i]), default=None)
        columns[row] = (
            found.log_bayes[name],
            robust[name],
            trials.log_bayes[leader],
            0.0 if strongest is None else beside[place, strongest],
            beside[place, order.index("")] if "" in leaders else 0.0,
            by_forecast[name],
            np.log(len(by_family[name])),
            trials.mean[leader] / trials.prior_sd[leader],
            trials.mean[leader] / trials.sd[leader] / 4.0,
            1.0,
            odds[name],
        )
    columns[:, :EVIDENCE_COLUMNS] = shown_evidence(columns[:, :EVIDENCE_COLUMNS])
    return columns
