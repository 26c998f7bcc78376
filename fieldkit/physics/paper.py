"""The reference paper's simulator, exactly as published.

Vertical flight, exponential density, g of 9.81, and three motors with declared figures. Thrust rises linearly to its
peak over the first 8% of the burn and falls linearly to the MEAN thrust at burnout; propellant burns off linearly in
time; there is no casing mass. The profile delivers 41.3, 64.5 and 61.0 N s, while the certificates state 39.4, 47.3 and
49.7; it is reproduced as published.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from fieldkit.errors import UnknownMotor
from fieldkit.motors.motor import impulse
from fieldkit.physics.atmosphere import Air
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import Burns, burns
from fieldkit.shapes import Array, Float, Int

RISE = 0.08
"""Fraction of the burn over which thrust rises to its peak. [1]"""
GRAVITY = 9.81
"""The paper's value. [m/s^2]"""
SEA_LEVEL_DENSITY = 1.225
"""The paper's value. [kg/m^3]"""
SCALE_HEIGHT = 8500.0
"""The paper's value. [m]"""
DIAMETER = 0.066
"""Diameter of the paper's rocket. [m]"""
DRY_MASS: Mapping[str, float] = MappingProxyType({"A": 0.322, "B": 0.448})
"""Dry masses of its two configurations. [kg]"""


@dataclass(frozen=True, slots=True)
class DeclaredMotor:
    """A motor with the figures that the paper declares, in SI units."""

    name: str
    total_impulse: float
    mean_thrust: float
    peak_thrust: float
    burn_time: float
    propellant_mass: float
    casing_mass: float = 0.0

    @property
    def burnout(self) -> float:
        """Burnout time of the published profile. [s]"""
        return self.burn_time

    @property
    def time(self) -> Float[Array, "knot"]:
        """Knot times of the published profile. [s]"""
        return np.array([0.0, RISE * self.burn_time, self.burn_time])

    @property
    def thrust(self) -> Float[Array, "knot"]:
        """Thrust at the knots. [N]"""
        return np.array([0.0, self.peak_thrust, self.mean_thrust])

    @property
    def delivered_impulse(self) -> float:
        """Total impulse of the published profile. [N s]"""
        return impulse(self.time, self.thrust)


MOTORS = (
    DeclaredMotor("E35-5W", 39.4, 33.8, 44.0, 1.1, 0.025),
    DeclaredMotor("F24-4W", 47.3, 22.2, 41.0, 2.1, 0.019),
    DeclaredMotor("F39", 49.7, 37.3, 59.5, 1.3, 0.023),
)
"""The paper's three motors; the position is the paper's motor index."""


_SPELLING = re.compile(r"(?:aerotech\s+)?(?P<name>[a-z]\d+)[a-z]*(?:\s*-\s*\d*[a-z]*)?", re.IGNORECASE)
"""Optional manufacturer, letter and number, optional propellant, optional delay."""


def motor_index(name: str) -> int:
    """The paper's index of a motor by name, such as F24-4W, F24W-4 or AeroTech F24. Raises UnknownMotor."""
    spelt = _SPELLING.fullmatch(name.strip())
    for index, motor in enumerate(MOTORS):
        if spelt and spelt["name"].upper() == motor.name.split("-")[0]:
            return index
    known = ", ".join(motor.name for motor in MOTORS)
    raise UnknownMotor(f"the paper flew no motor {name!r}, only {known}")


def paper_burns() -> Burns:
    """The paper's motors on the integrator's steps."""
    return burns(MOTORS, steps=8, linear_burn=True)


def paper_setup(
    motor: Int[Any, "*#draw"],
    dry_mass: Float[Array, "*#draw"],
    cd: Float[Array, "*#draw"],
    alpha: Float[Array, "*#draw"],
    diameter: Float[Array, "*#draw"] | float = DIAMETER,
    curves: Burns | None = None,
) -> Setup:
    """A setup in the paper's physics: motor index, dry mass [kg], Cd [1], alpha [1], diameter [m]."""
    return Setup(
        burns=curves or paper_burns(),
        air=Air(np.asarray(SEA_LEVEL_DENSITY), np.asarray(288.15), SCALE_HEIGHT),
        motor=np.asarray(motor),
        dry_mass=np.asarray(dry_mass, float),
        drag_area=np.asarray(cd) * (np.pi / 4) * np.asarray(diameter) ** 2,
        thrust_factor=np.asarray(alpha, float),
        gravity=GRAVITY,
    )
