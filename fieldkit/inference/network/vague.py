"""Unusually uncertain readouts for a network that was trained with the usual noise of an altimeter.

The network's posterior is right for readouts with the usual noise. If the recorded standard deviation of a readout is
larger, the value that the usual altimeter would have shown is unknown: it is drawn from the recorded value and the
prediction from the other readouts, and the posteriors of the draws are averaged (multiple imputation: Rubin, Multiple
Imputation for Nonresponse in Surveys, 1987). A smaller standard deviation than usual is not used.
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
"""Number of draws of an uncertain readout, evenly over its distribution, so that the answer is deterministic."""


def excess_sd(observed: Observed) -> Float[Array, "flight seen"]:
    """The root of the excess of a readout's recorded variance over the usual noise, on the scale of `shown`; 0 if there
    is none. [1]
    """
    if observed.sd is None:
        return np.zeros((len(observed), len(INDEPENDENT_READOUTS)))
    columns = [READOUT_NAMES.index(name) for name in INDEPENDENT_READOUTS]
    beyond = np.nan_to_num(observed.sd**2 - expected_sd(observed) ** 2, nan=0.0)[:, columns]
    return np.asarray(np.sqrt(np.maximum(beyond, 0.0)) * _slope(observed))


def plausible(observed: Observed, mean: Float[Array, "flight seen"], sd: Float[Array, "flight seen"]) -> list[Observed]:
    """`DRAWS` versions of the flights as the usual altimeter could have shown them.

    `mean` and `sd` are the prediction of each readout from the others, in the units of `shown`.
    """
    middle, spread = _combined(observed, mean, sd)
    rng = np.random.default_rng(0)
    normal = np.array([NormalDist().inv_cdf((number + 0.5) / DRAWS) for number in range(DRAWS)])
    steps = np.stack([rng.permutation(normal) for _ in INDEPENDENT_READOUTS], axis=-1)
    return [_moved(observed, middle + step * spread) for step in steps]


def likeliest(observed: Observed, mean: Float[Array, "flight seen"], sd: Float[Array, "flight seen"]) -> Observed:
    """The flights as the usual altimeter most likely showed them; `mean` and `sd` as in `plausible`, in its
    units."""
    return _moved(observed, _combined(observed, mean, sd)[0])


def _combined(observed: Observed, mean: Array, sd: Array) -> tuple[Array, Array]:
    """Mean and standard deviation of the reading of the usual altimeter, on the scale of `shown`, from the recorded
    value and the prediction; nan for readouts with no more than the usual noise."""
    beyond = excess_sd(observed)
    own = np.where(beyond > 0, beyond, np.nan)
    variance = 1 / (1 / own**2 + 1 / sd**2)
    return variance * (shown(observed) / own**2 + mean / sd**2), np.sqrt(variance)


def _slope(observed: Observed) -> Float[Array, "flight seen"]:
    """The derivative of `shown` with respect to each readout; 0 if it is missing."""
    with np.errstate(invalid="ignore", divide="ignore"):
        slopes = {name: 1 / observed.readout(name) for name in INDEPENDENT_READOUTS}
        slopes["peak_accel"] = 1 / (observed.readout("peak_accel") + GRAVITY)
        slopes["apogee_to_eject"] = 2 / np.hypot(1.0, 2 * observed.readout("apogee_to_eject"))
        stacked = np.stack([slopes[name] for name in INDEPENDENT_READOUTS], axis=-1)
    return np.where(np.isfinite(stacked), stacked, 0.0)


def _moved(observed: Observed, to: Float[Array, "flight seen"]) -> Observed:
    """The flights with their readouts replaced by `to`, which is on the scale of `shown`."""
    readouts = observed.readouts.copy()
    change = to - shown(observed)
    for number, name in enumerate(INDEPENDENT_READOUTS):
        moved = np.isfinite(change[:, number])
        column = readouts[:, READOUT_NAMES.index(name)]
        factor = np.exp(change[moved, number])
        offset = GRAVITY if name == "peak_accel" else 0.0
        ratio = (column[moved] + offset) * factor - offset
        column[moved] = np.sinh(to[moved, number]) / 2 if name == "apogee_to_eject" else ratio
        if name in ("top_speed", "burn_time"):  # average acceleration would still give their ratio
            readouts[moved, READOUT_NAMES.index("avg_accel")] = np.nan
    return replace(observed, readouts=readouts, sd=None)
