"""Readouts that are known less well than an altimeter's usual noise, shown to a network that knows that noise alone.

The network's posterior is right for a readout as the usual altimeter would have shown it. Of a readout whose recorded
standard deviation is larger, what that altimeter would have shown is not known: it is drawn from what was recorded and
from what the other readouts predict, and the posteriors of the draws are averaged (multiple imputation: Rubin,
Multiple Imputation for Nonresponse in Surveys, 1987). A smaller standard deviation than usual cannot be made use of.
"""

from dataclasses import replace
from statistics import NormalDist

import numpy as np

from fieldkit.model.field_features import shown
from fieldkit.model.observation_noise import expected_sd
from fieldkit.model.observations import INDEPENDENT_READOUTS, READOUT_NAMES, Observed
from fieldkit.physics.atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

DRAWS = 16
"""How often a vague readout is drawn: evenly over its distribution, so that one flight always has one answer."""


def excess_sd(observed: Observed) -> Float[Array, "flight seen"]:
    """What the recorded standard deviation of a readout has beyond the usual noise, on the scale of `shown`; else 0.

    Beyond is meant as the root of the difference of squares.
    """
    if observed.sd is None:
        return np.zeros((len(observed), len(INDEPENDENT_READOUTS)))
    columns = [READOUT_NAMES.index(name) for name in INDEPENDENT_READOUTS]
    beyond = np.nan_to_num(observed.sd**2 - expected_sd(observed) ** 2, nan=0.0)[:, columns]
    return np.asarray(np.sqrt(np.maximum(beyond, 0.0)) * _slope(observed))


def plausible(observed: Observed, mean: Float[Array, "flight seen"], sd: Float[Array, "flight seen"]) -> list[Observed]:
    """The flights as the usual altimeter may have shown them, `DRAWS` times.

    `mean` and `sd` are what the other readouts predict for each, on the scale of `shown`.
    """
    middle, spread = _combined(observed, mean, sd)
    rng = np.random.default_rng(0)
    normal = np.array([NormalDist().inv_cdf((number + 0.5) / DRAWS) for number in range(DRAWS)])
    steps = np.stack([rng.permutation(normal) for _ in INDEPENDENT_READOUTS], axis=-1)
    return [_moved(observed, middle + step * spread) for step in steps]


def likeliest(observed: Observed, mean: Float[Array, "flight seen"], sd: Float[Array, "flight seen"]) -> Observed:
    """The flights as the usual altimeter is likeliest to have shown them; `mean` and `sd` as in `plausible`."""
    return _moved(observed, _combined(observed, mean, sd)[0])


def _combined(observed: Observed, mean: Array, sd: Array) -> tuple[Array, Array]:
    """Mean and standard deviation of what the usual altimeter would have shown, on the scale of `shown`, by what was
    recorded and what is predicted; nan for readouts that are no vaguer than usual."""
    beyond = excess_sd(observed)
    own = np.where(beyond > 0, beyond, np.nan)
    variance = 1 / (1 / own**2 + 1 / sd**2)
    return variance * (shown(observed) / own**2 + mean / sd**2), np.sqrt(variance)


def _slope(observed: Observed) -> Float[Array, "flight seen"]:
    """The derivative of `shown` by each readout; 0 if there is none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        slopes = {name: 1 / observed.readout(name) for name in INDEPENDENT_READOUTS}
        slopes["peak_accel"] = 1 / (observed.readout("peak_accel") + GRAVITY)
        slopes["apogee_to_eject"] = 2 / np.hypot(1.0, 2 * observed.readout("apogee_to_eject"))
        stacked = np.stack([slopes[name] for name in INDEPENDENT_READOUTS], axis=-1)
    return np.where(np.isfinite(stacked), stacked, 0.0)


def _moved(observed: Observed, to: Float[Array, "flight seen"]) -> Observed:
    """The flights with the readouts that `to` has on the scale of `shown` in place of theirs."""
    readouts = observed.readouts.copy()
    change = to - shown(observed)
    for number, name in enumerate(INDEPENDENT_READOUTS):
        moved = np.isfinite(change[:, number])
        column = readouts[:, READOUT_NAMES.index(name)]
        factor = np.exp(change[moved, number])
        offset = GRAVITY if name == "peak_accel" else 0.0
        ratio = (column[moved] + offset) * factor - offset
        column[moved] = np.sinh(to[moved, number]) / 2 if name == "apogee_to_eject" else ratio
        if name in ("top_speed", "burn_time"):  # whose ratio average acceleration would still say
            readouts[moved, READOUT_NAMES.index("avg_accel")] = np.nan
    return replace(observed, readouts=readouts, sd=None)
