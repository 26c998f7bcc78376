"""Simulated flights as flyers record them, with noise, rounding and gaps."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from fieldkit.model.observations import DECLARED_FIELDS, READOUT_NAMES, Observed
from fieldkit.model.prior_predictive import TAIL, Truth
from fieldkit.physics.atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float


@dataclass(frozen=True, slots=True)
class Noise:
    """Noise of a readout in SI: `floor` and `relative` times its size, each times a Student t; the display rounds to
    `step`."""

    floor: float
    relative: float
    step: float


NOISE: Mapping[str, Noise] = MappingProxyType(
    {
        "apogee": Noise(0.8, 0.006, 0.3048),
        "top_speed": Noise(0.4, 0.015, 0.44704),
        "burn_time": Noise(0.05, 0.04, 0.1),
        "peak_accel": Noise(1.0, 0.15, 0.980665),
        "avg_accel": Noise(0.0, 0.0, 0.980665),
        "coast_to_apogee": Noise(0.1, 0.02, 0.1),
        "apogee_to_eject": Noise(0.15, 0.0, 0.1),
        "eject_altitude": Noise(1.5, 0.01, 0.3048),
        "descent_speed": Noise(0.3, 0.1, 0.44704),
        "duration": Noise(0.4, 0.015, 0.1),
    }
)
"""Independent error of each readout from the sensor, the detection of burnout and landing, and copying. Most errors are
small and a few are large: they follow a Student t with `TAIL` degrees of freedom. Average acceleration is computed from
the measured speed and burn time."""
OFFSET = 0.15 * GRAVITY
"""Standard deviation of the accelerometer's offset, which is set once on the pad, perhaps not quite vertical, and
drifts by tenths of a g. It adds to the peak acceleration and, times the burn time, to the speed: a tenth of it on a
slow flight. [m/s^2]"""
GAIN = 0.02
"""Standard deviation of the accelerometer's scale error, which peak acceleration and speed share. [1]"""
SUBSETS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "apogee": ("apogee",),
        "apogee, speed": ("apogee", "top_speed"),
        "apogee, speed, coast": ("apogee", "top_speed", "coast_to_apogee"),
        "all ten": READOUT_NAMES,
    }
)
"""Sets of readouts on which ensembles are evaluated, by name."""
_PROBABILITIES = (0.12, 0.12, 0.1, 0.2, 0.14, 0.32)
"""Probabilities in training of those four sets, of all readouts but one, and of any subset."""


def measure(rng: np.random.Generator, truth: Truth) -> Observed:
    """The flights as flyers could record them: every readout with its noise and rounding."""
    readouts = truth.readouts.copy()
    count = len(truth)
    speed, burn, peak = (READOUT_NAMES.index(name) for name in ("top_speed", "burn_time", "peak_accel"))
    offset, gain = OFFSET * rng.normal(size=count), 1 + GAIN * rng.normal(size=count)
    readouts[:, speed] = (readouts[:, speed] + offset * readouts[:, burn]) * gain
    readouts[:, peak] = (readouts[:, peak] + offset) * gain
    for number, name in enumerate(READOUT_NAMES):
        noise = NOISE[name]
        if noise.floor or noise.relative:
            readouts[:, number] += noise.floor * rng.standard_t(TAIL, size=count)
            readouts[:, number] *= np.maximum(1 + noise.relative * rng.standard_t(TAIL, size=count), 0.05)
    readouts[:, burn] = np.maximum(readouts[:, burn], 0.05)
    readouts[:, READOUT_NAMES.index("avg_accel")] = readouts[:, speed] / readouts[:, burn]
    steps = np.array([NOISE[name].step for name in READOUT_NAMES])
    readouts = np.round(readouts / steps) * steps
    signed = np.array(READOUT_NAMES) == "apogee_to_eject"
    return Observed(truth.motor, truth.declared, np.where(signed, readouts, np.maximum(readouts, 0.0)))


def expected_sd(observed: Observed) -> Float[Array, "flight readout"]:
    """The standard deviation of the error that `measure` adds to each readout, in SI; infinite for average
    acceleration.

    Derivation: variances of independent errors add; that of a Student t with `TAIL` degrees of freedom is `TAIL` /
    (`TAIL` - 2), and that of rounding to a step is its square / 12.
    """
    size = np.nan_to_num(observed.readouts, nan=0.0)
    noise = [NOISE[name] for name in READOUT_NAMES]
    floor, relative, step = (np.array([getattr(one, name) for one in noise]) for name in ("floor", "relative", "step"))
    variance = TAIL / (TAIL - 2) * (floor**2 + (relative * size) ** 2) + step**2 / 12
    speed, peak, average = (READOUT_NAMES.index(name) for name in ("top_speed", "peak_accel", "avg_accel"))
    burn = observed.readout("burn_time")
    burn = np.where(np.isnan(burn), observed.figure("burn_time"), burn)
    variance[:, speed] += (OFFSET * burn) ** 2 + (GAIN * size[:, speed]) ** 2
    variance[:, peak] += OFFSET**2 + (GAIN * size[:, peak]) ** 2
    variance[:, average] = np.inf
    return np.asarray(np.sqrt(variance))


def forget(rng: np.random.Generator, observed: Observed) -> Observed:
    """The same flights with the gaps that flyers leave in readouts, conditions and the diameter."""
    keep = _subsets(rng, len(observed))
    readouts = np.where(keep, observed.readouts, np.nan)
    declared = observed.declared.copy()
    count = len(observed)
    for name, probability in (("diameter", 0.25), ("delay", 0.3)):
        declared[rng.uniform(size=count) < probability, DECLARED_FIELDS.index(name)] = np.nan
    silence = rng.choice([0.0, 0.4, 1.0], size=count, p=[0.3, 0.35, 0.35])
    for name in DECLARED_FIELDS[3:]:
        declared[rng.uniform(size=count) < silence, DECLARED_FIELDS.index(name)] = np.nan
    return Observed(observed.motor, declared, readouts)


def _subsets(rng: np.random.Generator, count: int) -> Flags:
    """Whether each flight keeps each readout."""
    fixed = np.array([[name in kept for name in READOUT_NAMES] for kept in SUBSETS.values()])
    kind = rng.choice(len(_PROBABILITIES), size=count, p=_PROBABILITIES)
    width = len(READOUT_NAMES)
    but_one = np.arange(width) != rng.integers(width, size=count)[:, None]
    anything = rng.uniform(size=(count, width)) < rng.uniform(0.1, 1.0, size=(count, 1))
    anything[:, 0] |= rng.uniform(size=count) < 0.8
    keep: Flags = fixed[np.minimum(kind, len(fixed) - 1)]
    keep = np.where((kind == len(fixed))[:, None], but_one, keep)
    return np.where((kind > len(fixed))[:, None], anything, keep)
