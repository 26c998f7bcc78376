"""The network's answer for a whole history: probabilities of effects, the forecast of a plan, its drag and thrust."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.errors import DamagedModel
from fieldkit.inference.history.columns import NONE_ODDS, ODDS, PATTERN_ODDS
from fieldkit.inference.history.features import (
    HistorySummary,
    PreparedHistory,
    effect_names,
    feature_names,
    modeled,
    summarized,
)
from fieldkit.inference.history.moments import FORECAST_READOUTS, parameter_moments, readout_moments
from fieldkit.inference.history.placed_effects import Candidates
from fieldkit.inference.history.response import respond
from fieldkit.inference.network.ensemble import load
from fieldkit.inference.network.history_parts import (
    LEVELS,
    OVERALL_OUTPUTS,
    PARAMETERS,
    STANDARD,
    answer,
    quantile_draws,
)
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.history import History
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

NAME = "history"
MAX_LOG_APOGEE = float(np.log(1e5))
"""Largest apogee of an answer, for rockets far from those of the training. [log m]"""
SMALLEST_CHANCE = 1e-9
"""Limit of the network's probabilities, so that their odds are finite. [1]"""
NORMAL_95 = STANDARD[LEVELS.index(0.95)]
"""The 95% quantile of a standard normal distribution. [1]"""


@dataclass(frozen=True, slots=True)
class QuickAnswer:
    """The network's answer for a history and its plan.

    `inclusion` is the probability of each effect that the network knows and these flights can show, `none` the
    probability that nothing is missing, and `unexplained` the probability of something that no effect represents; all
    are `pooled`. Effects do not exclude each other. `log_apogee` are quantiles of the plan's log apogee [log m] at
    `levels`; `log_cd` and `log_alpha` are mean and standard deviation, and `correlation` is the correlation of the two.
    [1] `readouts` are the 5, 50 and 95% quantiles of the plan's other readouts, without reading errors, in SI, from the
    linear fit with the network's Cd and alpha.
    `plan` is the number of the plan in the history.
    """

    inclusion: Mapping[str, float]
    none: float
    unexplained: float
    levels: tuple[float, ...]
    log_apogee: Float[Array, "level"]
    log_cd: tuple[float, float]
    log_alpha: tuple[float, float]
    correlation: float
    readouts: Mapping[str, tuple[float, float, float]]
    summary: HistorySummary
    model: str
    plan: int = 0

    def apogee_at(self, level: float) -> float:
        """The quantile of the plan's apogee at one of `levels`. [m]"""
        return float(np.exp(min(self.log_apogee[self.levels.index(level)], MAX_LOG_APOGEE)))

    def apogee_draws(self, count: int) -> Float[Array, "draw"]:
        """Equally likely apogees of the plan, in ascending order. [m]"""
        return np.exp(np.minimum(quantile_draws(self.log_apogee, count), MAX_LOG_APOGEE))


@cache
def load_history() -> "Ensemble":
    """The shipped network. Raises DamagedModel if its features differ from those of this version."""
    return checked(load(NAME))


def checked(ensemble: "Ensemble") -> "Ensemble":
    """A history network whose card fits this version of fieldkit. Raises DamagedModel."""
    known = tuple(ensemble.card.get("effects", ()))
    outputs = len(known) + OVERALL_OUTPUTS + len(LEVELS) + len(PARAMETERS)
    if ensemble.features != feature_names(known) or list(ensemble.card.get("parts", ()))[-1:] != [outputs]:
        raise DamagedModel(
            f"{ensemble.name}: its card has other features than this version of fieldkit; train it again"
        )
    return ensemble


def prepared(history: History, candidates_of: Candidates, shared: SharedPrior | None = None) -> PreparedHistory:
    """The part of a history that does not depend on its readouts; arguments as in `modeled`, errors as in
    `quick_answer`."""
    own = modeled(history, candidates_of, shared)
    return PreparedHistory(own, respond(history, own.acting))


def quick_answer(
    history: History, candidates_of: Candidates, shared: SharedPrior | None = None, ensemble: "Ensemble | None" = None
) -> QuickAnswer:
    """The network's answer for one history, by default the shipped network's; other arguments as in `modeled`.

    Effects that the network was not trained with are not in the answer. Raises ImpossibleFlight for a flight without a
    dry mass, DamagedModel if the network cannot be loaded.
    """
    network = ensemble or load_history()
    ready = prepared(history, candidates_of, shared)
    return answers(summarized(ready, ready.flown, tuple(network.card["effects"])), network)[0]


def answers(summary: HistorySummary, network: "Ensemble") -> list[QuickAnswer]:
    """The network's answers for the plans of a history, in one batch."""
    names = tuple(network.card["effects"])
    estimate = answer(network.members(summary.features), len(names))
    columns = feature_names(names)
    odds = [*(f"{name}.{ODDS}" for name in names), NONE_ODDS, PATTERN_ODDS]
    chances = pooled(
        np.column_stack([estimate.inclusion, estimate.none, estimate.unexplained]),
        summary.features[:, [columns.index(name) for name in odds]],
    ).tolist()
    base = summary.baseline
    acting = set(summary.trials.family)
    middle = np.stack(
        [base.cd + base.cd_sd * estimate.shift[:, 0], base.alpha + base.alpha_sd * estimate.shift[:, 1]], axis=-1
    )
    sds = np.stack([base.cd_sd * estimate.scale[:, 0], base.alpha_sd * estimate.scale[:, 1]], axis=-1)
    correlation = np.tanh(np.arctanh(np.clip(base.correlation, -0.99, 0.99)) + estimate.coupling)
    apogees = base.apogee[:, None] + base.apogee_sd[:, None] * estimate.quantiles
    plans = readout_moments(summary.forecast).given(
        parameter_moments(base.cd, base.cd_sd, base.alpha, base.alpha_sd, base.correlation),
        parameter_moments(middle[:, 0], sds[:, 0], middle[:, 1], sds[:, 1], correlation),
    )
    readouts = _readouts(plans.mean, plans.sd)
    return [
        QuickAnswer(
            {name: chance for name, chance in zip(names, chances[plan], strict=False) if name in acting},
            chances[plan][len(names)],
            chances[plan][len(names) + 1],
            LEVELS,
            apogees[plan],
            (float(middle[plan, 0]), float(sds[plan, 0])),
            (float(middle[plan, 1]), float(sds[plan, 1])),
            float(correlation[plan]),
            readouts[plan],
            summary,
            network.name,
            plan,
        )
        for plan in range(len(apogees))
    ]


def pooled(chance: Float[Array, "*many"], log_odds: Float[Array, "*many"]) -> Float[Array, "*many"]:
    """The probability whose odds are the geometric mean of the network's odds and the closed-form ones [nat],
    elementwise. [1]

    The network is the better judge of rockets like those of its training; the closed form depends less on what those
    were. Source: the logarithmic opinion pool with equal weights (Genest and Zidek, Combining Probability
    Distributions, Statistical Science 1, 1986).
    """
    limited = np.clip(chance, SMALLEST_CHANCE, 1 - SMALLEST_CHANCE)
    return np.asarray(1 / (1 + np.exp(-0.5 * (np.log(limited / (1 - limited)) + log_odds))))


def _readouts(
    mean: Float[Array, "plan readout"], sd: Float[Array, "plan readout"]
) -> list[dict[str, tuple[float, float, float]]]:
    """For each plan, the quantiles in SI of readouts that are normal in the form that is compared; a readout that the
    plan lacks is left out."""
    logarithmic = [bool(IS_LOGARITHMIC[OBSERVED_READOUTS.index(name)]) for name in FORECAST_READOUTS]
    ends = mean[..., None] + sd[..., None] * np.array([-NORMAL_95, 0.0, NORMAL_95])
    ends[:, logarithmic] = np.exp(ends[:, logarithmic])
    known = np.isfinite(ends).all(axis=-1).tolist()
    return [
        {
            name: (low, middle, high)
            for name, (low, middle, high), shown in zip(FORECAST_READOUTS, own, has, strict=True)
            if shown
        }
        for own, has in zip(ends.tolist(), known, strict=True)
    ]


def untrained_effects(ensemble: "Ensemble") -> tuple[str, ...]:
    """Installed effects that a network was not trained with."""
    return tuple(name for name in effect_names() if name not in ensemble.card["effects"])
