"""The readouts as a function of terms and random effects, simulated or linear, and their derivatives at a point."""

from collections.abc import Callable, Mapping

import numpy as np

from fieldkit.inference.laplace.linearization import STEPS, Tangent
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model
from fieldkit.model.simulated_readouts import bent, shown
from fieldkit.shapes import Array, Float

STEP_SIZES = {**STEPS, "opening": 0.1, "delay": 0.02}
"""Central finite-difference steps of the force."""
MIN_TIME_FROM_APOGEE = 0.4
"""Minimum time of ejection before and after apogee for the two sets of derivatives. [s]"""
EJECTION = OBSERVED_READOUTS.index("apogee_to_eject")

Readouts = Callable[[Array, Mapping[str, Array]], Array]
"""Compared readouts by terms [draw term] and random effects of flights [draw flight], as [draw flight readout]."""


def simulated(model: Model) -> Readouts:
    """Simulated readouts."""

    def read(values: Array, scatter: Mapping[str, Array]) -> Array:
        readings = shown(model, values, scatter)
        return compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))

    return read


def linear(model: Model, near: Tangent) -> Readouts:
    """Linear readouts at the fit's last point."""
    slopes = {str(term.bends): near.slope[..., i] for i, term in enumerate(model.terms) if term.weight.all()}
    slopes |= {str(kind.bends): near.scatter_slope[..., i] / kind.sd for i, kind in enumerate(model.scatter)}

    there = np.nan_to_num(near.values)  # readouts that the simulator does not give are not compared

    def read(values: Array, scatter: Mapping[str, Array]) -> Array:
        moved = np.einsum("fot,dt->dfo", near.slope, values - near.at)
        for name, change in scatter.items():
            moved = moved + change[..., None] * slopes[name]
        return np.asarray(there + moved)

    return read


def side_slopes(model: Model, exact: Readouts, at: Float[Array, "term"]) -> Float[Array, "side flight readout kind"]:
    """Derivatives of readouts with respect to every property, for ejection after apogee and before it."""
    return np.stack([_slopes(exact, at, delay) for delay in _delays(model, exact, at)])


def _delays(model: Model, exact: Readouts, at: Float[Array, "term"]) -> tuple[Float[Array, "flight"], ...]:
    """Shifts of each flight's log delay that move the ejection after, and before, apogee. [1]"""
    step = np.full((2, len(model.flights)), 0.02) * [[0], [1]]
    here, moved = exact(np.stack([at, at]), {"delay": step})[..., EJECTION]
    with np.errstate(invalid="ignore", divide="ignore"):
        here = here - bent(model, at[None], OBSERVED_READOUTS[EJECTION])[0]
        rate = (moved - bent(model, at[None], OBSERVED_READOUTS[EJECTION])[0] - here) / 0.02
        sides = (
            (np.maximum(here, MIN_TIME_FROM_APOGEE) - here) / rate,
            (np.minimum(here, -MIN_TIME_FROM_APOGEE) - here) / rate,
        )
    return tuple(np.clip(np.nan_to_num(side, posinf=0.0, neginf=0.0), -0.5, 0.5) for side in sides)


def _slopes(
    exact: Readouts, at: Float[Array, "term"], delay: Float[Array, "flight"]
) -> Float[Array, "flight readout kind"]:
    """Derivatives of readouts with respect to every property, with shifted delays."""
    count = 2 * len(STEP_SIZES)
    rows = {kind: np.zeros((count, len(delay))) for kind in STEP_SIZES}
    for number, (kind, step) in enumerate(STEP_SIZES.items()):
        rows[kind][2 * number], rows[kind][2 * number + 1] = step, -step
    rows["delay"] = rows["delay"] + delay
    flown = exact(np.repeat(at[None], count, axis=0), rows)
    steps = np.array(list(STEP_SIZES.values()))
    return np.asarray(np.nan_to_num(np.moveaxis(flown[::2] - flown[1::2], 0, -1) / (2 * steps)))
