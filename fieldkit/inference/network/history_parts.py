"""The outputs of each member of the history network: inclusion, a forecast, drag and thrust.

Derivation: the steps between quantiles are softplus functions of the raw outputs, so they are positive and the
quantiles ascend; between quantiles and beyond them, a value is a linear function of the standard normal quantile.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from fieldkit.shapes import Array, Float

LEVELS = (0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.975)
"""Levels of the quantiles of the forecast. [1]"""
STANDARD = tuple(NormalDist().inv_cdf(level) for level in LEVELS)
"""The same quantiles of a standard normal distribution, which the network adjusts. [1]"""
MEDIAN = LEVELS.index(0.5)
PARAMETERS = ("cd", "alpha", "log_sd_cd", "log_sd_alpha", "coupling")
"""Outputs for the posterior of log Cd and log alpha relative to the linear fit's."""
OVERALL_OUTPUTS = 2
"""Outputs between effects and forecast: nothing is missing, and something unexplained is present."""
LOG_SD_RANGE = (-2.5, 2.5)
"""Bounds of the logs of the standard deviations in `PARAMETERS`. [1]"""


def width(effects: int) -> int:
    """Number of outputs of a member for this number of effects."""
    return effects + OVERALL_OUTPUTS + len(LEVELS) + len(PARAMETERS)


def quantile_steps() -> Float[Array, "step"]:
    """The offset of raw outputs that makes zeros the steps between standard normal quantiles. [1]"""
    return np.asarray(np.log(np.expm1(np.diff(STANDARD))))


@dataclass(frozen=True, slots=True)
class HistoryAnswer:
    """The combined outputs of the members, one row per history, or per plan of one.

    `inclusion` is the probability of each effect, `none` the probability that nothing is missing, and `unexplained` the
    probability of something that no effect represents. `quantiles` are of (log apogee - mean) / sd, with mean and sd
    from the linear fit. `shift` and `scale` are the mean and standard deviation of log Cd and log alpha, standardized
    in the same way, and `coupling` is added to Fisher's z of their correlation. [1]
    """

    inclusion: Float[Array, "history effect"]
    none: Float[Array, "history"]
    unexplained: Float[Array, "history"]
    quantiles: Float[Array, "history level"]
    shift: Float[Array, "history 2"]
    scale: Float[Array, "history 2"]
    coupling: Float[Array, "history"]


def answer(parts: Float[Array, "history member part"], effects: int) -> HistoryAnswer:
    """Probabilities and quantiles averaged over members; drag and thrust as the moments of their mixture. [1]"""
    chances = 1 / (1 + np.exp(-parts[..., : effects + OVERALL_OUTPUTS]))
    mean = chances.mean(axis=1)
    first = effects + OVERALL_OUTPUTS
    quantiles = monotone(parts[..., first : first + len(LEVELS)]).mean(axis=1)
    own = parts[..., first + len(LEVELS) :]
    shift = own[..., :2].mean(axis=1)
    sds = np.exp(np.clip(own[..., 2:4], *LOG_SD_RANGE))
    scale = np.sqrt((sds**2).mean(axis=1) + own[..., :2].var(axis=1))
    return HistoryAnswer(
        mean[:, :effects],
        mean[:, effects],
        mean[:, effects + 1],
        quantiles,
        shift,
        scale,
        own[..., 4].mean(axis=1),
    )


def monotone(raw: Float[Array, "*many level"]) -> Float[Array, "*many level"]:
    """Quantiles in ascending order, from the median and the steps to both sides. [1]"""
    inner = np.delete(raw, MEDIAN, axis=-1) + quantile_steps()
    steps = np.logaddexp(0.0, inner)
    middle = raw[..., MEDIAN : MEDIAN + 1]
    below = middle - np.cumsum(steps[..., :MEDIAN][..., ::-1], axis=-1)[..., ::-1]
    above = middle + np.cumsum(steps[..., MEDIAN:], axis=-1)
    return np.concatenate([below, middle, above], axis=-1)


def quantile_draws(quantiles: Sequence[float] | Float[Array, "level"], count: int) -> Float[Array, "draw"]:
    """Equally likely values of a distribution with these quantiles at `LEVELS` and normal tails, in the unit of the
    quantiles."""
    levels = (np.arange(count) + 0.5) / count
    normal = np.array([NormalDist().inv_cdf(float(level)) for level in levels])
    known, standard = np.asarray(quantiles, float), np.array(STANDARD)
    inside = np.interp(normal, standard, known)
    left, right = (
        (known[1] - known[0]) / (standard[1] - standard[0]),
        (known[-1] - known[-2]) / (standard[-1] - standard[-2]),
    )
    inside = np.where(normal < standard[0], known[0] + left * (normal - standard[0]), inside)
    return np.asarray(np.where(normal > standard[-1], known[-1] + right * (normal - standard[-1]), inside))
