"""Recorded flights as arrays, and the priors of what was not recorded.

Derivation: frontal areas are those of circles; the extremes of drag area are those of Cd and diameter combined. The
mean time of thrust and its standard deviation are the moments of the thrust curve.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from fieldkit.flight import CONDITIONS, Flight
from fieldkit.flight.recovery import recovery_column
from fieldkit.motors import Found, Motor
from fieldkit.physics.setups import delays, dry_masses, recorded
from fieldkit.shapes import Array, Float

CD_RANGE = (0.2, 1.5)
"""The prior of Cd: uniform in its logarithm. [1]"""
ALPHA_RANGE, ALPHA_SD = (0.6, 1.4), 0.13
"""The prior of alpha: normal around 1 with this standard deviation, between these ends. [1]

The impulse of single certified motors has a standard deviation of at most 6.7% (NFPA 1125); alpha also absorbs the
effect on thrust of a scale or a launch rod that is further off than assumed.
"""
MIN_PRIOR_DIAMETER, MAX_PRIOR_DIAMETER = 0.013, 0.1
"""Bounds of the diameter's prior; the motor's diameter replaces the lower one if it is larger. [m]"""

READOUT_NAMES = (
    "apogee",
    "top_speed",
    "burn_time",
    "peak_accel",
    "avg_accel",
    "coast_to_apogee",
    "apogee_to_eject",
    "eject_altitude",
    "descent_speed",
    "duration",
)
"""The readouts that a simulated flight has, in the order in which the ensembles were trained on them. A readout that is
only recorded is not among them."""
DECLARED_FIELDS = ("dry_mass", "diameter", "delay", *(column.name for column in CONDITIONS))
"""What a flyer may record besides the readouts; only the dry mass is required."""
INDEPENDENT_READOUTS = tuple(name for name in READOUT_NAMES if name != "avg_accel")
"""The independent readouts, without average acceleration, which is top speed over burn time."""
FIGURES = (
    "total_impulse",
    "burn_time",
    "burnout",
    "peak_thrust",
    "middle",
    "spread",
    "propellant",
    "casing",
    "diameter",
)
"""Figures of a motor for the ensemble, in SI: `middle` and `spread` are the mean and standard deviation of time
weighted by thrust."""


@dataclass(frozen=True, slots=True)
class Observed:
    """Recorded flights in SI, one entry per flight, nan for "not recorded".

    `motor` has a column for each of `FIGURES`, `declared` for each of `DECLARED_FIELDS`, and `readouts` for each of
    `READOUT_NAMES`. `sd` has the recorded standard deviation of each readout; None if none is recorded.
    """

    motor: Float[Array, "flight figure"]
    declared: Float[Array, "flight declared"]
    readouts: Float[Array, "flight readout"]
    sd: Float[Array, "flight readout"] | None = None

    def __len__(self) -> int:
        return len(self.motor)

    def figure(self, name: str) -> Float[Array, "flight"]:
        """One figure of all motors, in SI."""
        return self.motor[:, FIGURES.index(name)]

    def given(self, name: str) -> Float[Array, "flight"]:
        """One declared field of all flights in SI; nan if it was not recorded."""
        return self.declared[:, DECLARED_FIELDS.index(name)]

    def readout(self, name: str) -> Float[Array, "flight"]:
        """One readout of all flights in SI; nan if it is missing."""
        return self.readouts[:, READOUT_NAMES.index(name)]

    def rows(self, which: Any) -> "Observed":
        """The selected flights."""
        sd = None if self.sd is None else self.sd[which]
        return Observed(self.motor[which], self.declared[which], self.readouts[which], sd)

    def without(self, *names: str) -> "Observed":
        """A copy with some readouts removed."""
        readouts = self.readouts.copy()
        readouts[:, [READOUT_NAMES.index(name) for name in names]] = np.nan
        return replace(self, readouts=readouts)

    def with_readouts(self, readouts: Float[Array, "flight readout"]) -> "Observed":
        """A copy with these readouts, in SI."""
        return replace(self, readouts=readouts)

    def only(self, *names: str) -> "Observed":
        """A copy with only these readouts."""
        return self.without(*(name for name in READOUT_NAMES if name not in names))


@cache
def figures(motor: Motor) -> Float[Array, "figure"]:
    """The figures of a motor in SI, in the order of `FIGURES`."""
    middle, variance = motor.moments
    return np.array(
        [
            motor.total_impulse,
            motor.burn_time,
            motor.burnout,
            motor.peak_thrust,
            middle,
            np.sqrt(variance),
            motor.propellant_mass,
            motor.casing_mass,
            motor.diameter,
        ]
    )


def readouts_on_one_device(flights: Sequence[Flight], names: Sequence[str]) -> Float[Array, "flight readout"]:
    """Readouts of every flight in SI, nan if missing. A duration on a drogue and a main counts as missing, because the
    simulated descent is on one device."""
    values = np.stack([recorded(flights, name) for name in names], axis=-1)
    two = np.array([recovery_column(flight, "main_altitude") is not None for flight in flights], bool)
    if "duration" in names:
        values[two, names.index("duration")] = np.nan
    return values


def observe(flights: Sequence[Flight], found: Sequence[Found]) -> Observed:
    """Flights and their motors as arrays. Raises ImpossibleFlight for a flight without a dry mass."""
    declared = np.stack([recorded(flights, name) for name in DECLARED_FIELDS], axis=-1)
    declared[:, DECLARED_FIELDS.index("dry_mass")] = dry_masses(flights)
    declared[:, DECLARED_FIELDS.index("delay")] = delays(flights, found)
    readouts = readouts_on_one_device(flights, READOUT_NAMES)
    sd = np.array([[flight.sd.get(name, np.nan) for name in READOUT_NAMES] for flight in flights], float)
    motor = np.stack([figures(item.motor) for item in found])
    return Observed(motor, declared, readouts, sd if np.isfinite(sd).any() else None)


def diameter_range(
    motor_diameter: Float[Array, "flight"], dry_mass: Float[Array, "flight"]
) -> tuple[Float[Array, "flight"], Float[Array, "flight"]]:
    """Smallest and largest body diameter for a motor and a mass; the prior is uniform in the logarithm between them.
    [m]

    The body is at least as wide as the motor and a wall, at most five motors wide, and no lighter than the lightest
    kits of its diameter: 7 g at 20 mm, growing with the square to 105 g at 77 mm. The largest diameter is at least 1.3
    times the smallest.
    """
    slim = np.maximum(MIN_PRIOR_DIAMETER, motor_diameter + 0.001)
    wide = np.minimum(np.minimum(MAX_PRIOR_DIAMETER, 5 * motor_diameter), 0.02 * np.sqrt(dry_mass / 0.007))
    return slim, np.maximum(wide, 1.3 * slim)


def disc(diameter: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """Area of a circle of this diameter. [m^2]"""
    return np.pi / 4 * diameter**2


def drag_area_range(observed: Observed) -> tuple[Float[Array, "flight"], Float[Array, "flight"]]:
    """Logarithm of the smallest and the largest drag area that the prior allows. [log m^2]"""
    diameter = observed.given("diameter")
    slim, wide = diameter_range(observed.figure("diameter"), observed.given("dry_mass"))
    slim, wide = (np.where(np.isnan(diameter), limit, diameter) for limit in (slim, wide))
    return np.log(CD_RANGE[0] * disc(slim)), np.log(CD_RANGE[1] * disc(wide))
