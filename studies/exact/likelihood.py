"""The exact likelihood of simulated flights as a function of their standard normal inputs.

Every random property of a simulated flight is a function of these inputs: Cd and alpha of the first two, the errors of
the accelerometer of the next two, winds, motors and so on of the rest. Given all inputs, a readout is the simulated
value plus noise, the sum of two Student t, rounded to the device's resolution.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri, stdtr, stdtrit

from fieldkit.model.observation_noise import GAIN, NOISE, OFFSET
from fieldkit.model.observations import (
    ALPHA_RANGE,
    ALPHA_SD,
    CD_RANGE,
    DECLARED_FIELDS,
    READOUT_NAMES,
    Observed,
    disc,
    figures,
)
from fieldkit.model.prior_predictive import STEPS, TAIL, Truth, flown_field
from fieldkit.motors import Motor
from fieldkit.physics.flight import fly
from fieldkit.physics.thrust_steps import Burns, burns
from fieldkit.shapes import Array, Float, Int

PARAMETERS = 2
"""Indices of the inputs for Cd and alpha."""
DEVICE = 2
"""Indices of the inputs for offset and gain of the accelerometer."""
_MIN_LOG_CD, _MAX_LOG_CD = np.log(CD_RANGE)
_ENDS = ndtr((np.array(ALPHA_RANGE) - 1.0) / ALPHA_SD)
_ANGLES = np.linspace(0.0, np.pi / 2, 33)
_REACH = np.sinh(np.linspace(-9.0, 9.0, 721))


class Latent:
    """Replaces a random number generator: each call returns the next column of given normal inputs."""

    def __init__(self, normals: Float[Array, "draw latent"]) -> None:
        self.normals, self.used = normals, 0

    def _next(self) -> Array:
        self.used += 1
        return self.normals[:, self.used - 1]

    def normal(self, loc: float = 0.0, scale: float = 1.0, size: int = 0) -> Array:
        return loc + scale * self._next()

    def uniform(self, low: float = 0.0, high: float = 1.0, size: int = 0) -> Array:
        return np.asarray(low + (high - low) * ndtr(self._next()))

    def standard_t(self, df: float, size: int = 0) -> Array:
        return np.asarray(stdtrit(df, ndtr(self._next())))


def _count_latents() -> int:
    counter = Latent(np.zeros((1, 64)))
    one = {name: np.ones(1) for name in DECLARED_FIELDS}
    flown_field(counter, np.ones((1, 9)), one, np.ones(1), np.ones(1))
    return PARAMETERS + DEVICE + counter.used


LATENTS = _count_latents()
"""Number of normal inputs of a flight."""


def parameters(
    normals: Float[Array, "draw latent"], diameter: Float[Array, "draw"]
) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
    """Logarithm of the drag area [log m^2] and alpha [1] from the first two inputs."""
    alpha = 1.0 + ALPHA_SD * ndtri(_ENDS[0] + (_ENDS[1] - _ENDS[0]) * ndtr(normals[:, 1]))
    return _MIN_LOG_CD + (_MAX_LOG_CD - _MIN_LOG_CD) * ndtr(normals[:, 0]) + np.log(disc(diameter)), np.asarray(alpha)


def normals_of(
    values: Float[Array, "*draw flight 2"], diameter: Float[Array, "flight"]
) -> Float[Array, "*draw flight 2"]:
    """The two normal inputs for a logarithm of drag area and an alpha."""
    cd = (values[..., 0] - np.log(disc(diameter)) - _MIN_LOG_CD) / (_MAX_LOG_CD - _MIN_LOG_CD)
    alpha = (ndtr((values[..., 1] - 1.0) / ALPHA_SD) - _ENDS[0]) / (_ENDS[1] - _ENDS[0])
    return np.asarray(ndtri(np.clip(np.stack([cd, alpha], axis=-1), 1e-9, 1 - 1e-9)))


@cache
def _sum_table() -> Float[Array, "angle reach"]:
    """Distribution of cos(a) t + sin(a) t' for two Student t, on a grid of angles and values."""
    nodes = stdtrit(TAIL, (np.arange(300) + 0.5) / 300)
    rows = [stdtr(TAIL, _REACH)]
    rows += [stdtr(TAIL, (_REACH[:, None] - np.cos(a) * nodes) / np.sin(a)).mean(axis=1) for a in _ANGLES[1:-1]]
    return np.stack([*rows, stdtr(TAIL, _REACH)])


def _below(values: Array, floor: Array, relative: Array) -> Array:
    """Probability that noise of these two parts is below a value."""
    table = _sum_table()
    size = np.hypot(floor, relative)
    place = np.arctan2(relative, floor) / _ANGLES[1]
    row = np.clip(place.astype(int), 0, len(_ANGLES) - 2)
    part = place - row
    column = np.clip(np.arcsinh(values / size) / 9.0, -1, 1) * 360 + 360
    left = np.clip(column.astype(int), 0, 719)
    step = column - left
    low = table[row, left] * (1 - step) + table[row, left + 1] * step
    high = table[row + 1, left] * (1 - step) + table[row + 1, left + 1] * step
    return np.asarray(low * (1 - part) + high * part)


@dataclass(frozen=True, slots=True)
class Problem:
    """Observed flights, and the thrust curve of each."""

    observed: Observed
    curves: Burns
    row: Int[Any, "flight"]

    def __len__(self) -> int:
        return len(self.row)


def problem(truth: Truth, observed: Observed, motors: Sequence[Motor]) -> Problem:
    """Simulated flights as observed, with all conditions declared and their motors identified by mass, impulse and
    other figures."""
    known = {figures(motor).tobytes(): number for number, motor in enumerate(motors)}
    row = np.array([known[np.ascontiguousarray(one).tobytes()] for one in truth.motor])
    flown, place = np.unique(row, return_inverse=True)
    return Problem(observed, burns([motors[number] for number in flown], steps=STEPS), place)


def _clean(one: Problem, normals: Float[Array, "flight draw latent"]) -> tuple[Observed, dict[str, Array]]:
    """The observed readouts, and the simulated ones without noise and rounding [flight * draw]; nan if missing, and
    throughout if the rocket did not leave the pad.
    """
    flights, draws, _ = normals.shape
    flat = normals.reshape(flights * draws, -1)
    spread = np.repeat(np.arange(flights), draws)
    observed = one.observed.rows(spread)
    declared = {name: observed.given(name) for name in DECLARED_FIELDS}
    area, alpha = parameters(flat, declared["diameter"])
    setup = flown_field(Latent(flat[:, PARAMETERS + DEVICE :]), observed.motor, declared, np.exp(area), alpha)
    flown = fly(setup.with_changes(burns=one.curves, motor=one.row[spread]))
    clean = {name: flown.readouts()[name] for name in READOUT_NAMES}
    lifted = (flown.lift_off > 0) & (clean["apogee"] > 5.0) & (clean["top_speed"] > 3.0)
    offset, gain = OFFSET * flat[:, PARAMETERS], 1 + GAIN * flat[:, PARAMETERS + 1]
    clean["top_speed"] = (clean["top_speed"] + offset * clean["burn_time"]) * gain
    clean["peak_accel"] = (clean["peak_accel"] + offset) * gain
    return observed, {name: np.where(lifted, value, np.nan) for name, value in clean.items()}


def log_likelihood(one: Problem, normals: Float[Array, "flight draw latent"]) -> Float[Array, "flight draw"]:
    """Log probability of the observations of every flight, given its inputs. [nat]"""
    observed, clean = _clean(one, normals)
    total = np.where(np.isfinite(clean["apogee"]), 0.0, -np.inf)
    for name, (low, high) in _bins(observed).items():
        both = np.isfinite(low) & np.isfinite(clean[name])
        middle = np.where(both, clean[name], 1.0)
        relative, floor = NOISE[name].relative * np.abs(middle), np.full(len(middle), NOISE[name].floor)
        ends = [_below(np.where(both, end, 1.0) - middle, floor, relative) for end in (low, high)]
        log_probability = np.log(np.maximum(ends[1] - ends[0], 1e-300))
        total += np.where(both, log_probability, np.where(np.isfinite(low), -np.inf, 0.0))
    return np.asarray(total.reshape(normals.shape[:2]))


def misses(one: Problem, normals: Float[Array, "flight draw latent"]) -> Float[Array, "flight draw readout"]:
    """Observed minus simulated, in standard deviations of a normal about as wide as the noise; 0 if not recorded."""
    observed, clean = _clean(one, normals)
    found = [np.zeros(len(observed))]
    for name, (low, high) in _bins(observed).items():
        noise = NOISE[name]
        size = np.sqrt(1.3 * (noise.floor**2 + (noise.relative * clean[name]) ** 2) + (high - low) ** 2 / 12)
        found.append(np.nan_to_num((0.5 * (low + high) - clean[name]) / size))
    return np.clip(np.stack(found, axis=-1), -30, 30).reshape(*normals.shape[:2], -1)


def _bins(observed: Observed) -> dict[str, tuple[Array, Array]]:
    """Bounds of each readout before rounding; nan if it was not recorded.

    Average acceleration is speed over burn time, so it narrows the bounds of the burn time.
    """
    found = {}
    for name in READOUT_NAMES:
        value, half = observed.readout(name), 0.5 * NOISE[name].step
        if name != "avg_accel" and np.isfinite(value).any():
            found[name] = (value - half, value + half)
    if "burn_time" in found and "top_speed" in found:
        average, half = observed.readout("avg_accel"), 0.5 * NOISE["avg_accel"].step
        (slow, fast), (short, long) = found["top_speed"], found["burn_time"]
        with np.errstate(divide="ignore", invalid="ignore"):
            narrow = np.fmax(short, slow / (average + half)), np.fmin(long, fast / np.maximum(average - half, 1e-6))
        agrees = narrow[1] > narrow[0]
        found["burn_time"] = (np.where(agrees, narrow[0], short), np.where(agrees, narrow[1], long))
    return found
