"""The category of a rocket under laws and club codes: model or high power, class and certification level."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fieldkit import units
from fieldkit.messages import of_unit
from fieldkit.motors.motor import Motor
from fieldkit.planning.rules import RuleSet

ROUNDING = 1e-6
"""Excess over a limit that is only the rounding of a sum of masses. [g]"""


@dataclass(frozen=True, slots=True)
class Build:
    """The properties of a rocket that rules refer to: installed motors, mass on the pad [kg] (nan: not known), whether
    it has more than one stage or motor, and the total installed impulse [N s]."""

    motors: tuple[Motor, ...]
    mass: float
    complex: bool

    @property
    def impulse(self) -> float:
        """Total installed impulse. [N s]"""
        return sum(motor.total_impulse for motor in self.motors)

    @property
    def propellant(self) -> float:
        """Total propellant mass. [kg]"""
        return sum(motor.propellant_mass for motor in self.motors)

    @property
    def rated_thrust(self) -> float:
        """Certified average thrust of all motors together. [N]"""
        return sum(motor.rated_thrust for motor in self.motors)


def build_of(motor: Motor, dry_mass: float) -> Build:
    """The build of a rocket of a dry mass [kg] on its motor, or on all motors of its cluster or stages."""
    parts = motor.parts or (motor,)
    return Build(parts, dry_mass + motor.loaded_mass, len(parts) > 1)


def why_high_power(build: Build, sets: Sequence[RuleSet]) -> str:
    """What makes a rocket high power, with marked amounts; an empty text if nothing does.

    A motor's certified average thrust counts, or else its certified impulse over its burn time; not that of its curve,
    and never the number in its name.
    """
    limit: Mapping[str, Any] = next((one.definition for one in sets if one.definition), {})
    if not limit:
        return ""
    for motor in build.motors:
        if why := _why_motor(motor, limit):
            return why
    if build.impulse > limit["impulse_of_several_ns"]:
        return f"more than {limit['impulse_of_several_ns']:g} N s in all its motors"
    if build.propellant * 1e3 > limit["propellant_g"] + ROUNDING:
        return f"more than {_grams(limit['propellant_g'])} of propellant"
    if build.mass * 1e3 > limit["mass_g"] + ROUNDING:
        return f"more than {_grams(limit['mass_g'])} at lift-off"
    return ""


def _grams(limit: float) -> str:
    """A limit [g] as a marked amount."""
    grams = units.unit("mass", "g")
    return of_unit(grams.to_si(limit), "g", scale=grams)


def _why_motor(motor: Motor, limit: Mapping[str, Any]) -> str:
    """What makes a single motor high power."""
    if motor.total_impulse > limit["impulse_of_one_ns"]:
        return f"more than {limit['impulse_of_one_ns']:g} N s"
    if motor.rated_thrust > limit["average_thrust_n"]:
        if motor.certified_average is None:
            return f"its impulse over its burn time, {motor.rated_thrust:.1f} N"
        return f"its certified average thrust of {motor.rated_thrust:.1f} N"
    if motor.propellant_mass * 1e3 > limit["propellant_g"]:
        return f"more than {_grams(limit['propellant_g'])} of propellant"
    if motor.kind in limit["kinds"]:
        return f"its type, {motor.kind}"
    if motor.designation.upper().startswith(tuple(limit["designations"])):
        return "the HP in its designation"
    if motor.propellant in limit.get("sparky", ()):
        return f"its propellant, {motor.propellant}, which throws sparks"
    return ""


def legal_class(build: Build, laws: Mapping[str, Any]) -> int:
    """Class 1, 2 or 3 of a rocket under the bounds of an air law."""
    if build.impulse > laws["class2_impulse_ns"]:
        return 3
    light = not build.mass * 1e3 > laws["class1_mass_g"] + ROUNDING
    return 1 if light and build.propellant * 1e3 <= laws["class1_propellant_g"] + ROUNDING else 2
