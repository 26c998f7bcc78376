"""A measured climb beside the model: at every sample, the push that was felt less the model's thrust and drag there.

Nothing is integrated: thrust and drag are computed from the measured speed and height, so that what is left belongs
to that moment.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from fieldkit.motors.motor import Motor
from fieldkit.shapes import Array, Flags, Float
from fieldkit.simulator.atmosphere import GRAVITY, Air


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A measured climb, straight up, on one clock in SI units.

    `push` is thrust less drag over mass, as an axial accelerometer feels it, with its standard deviation; heights are
    above the pad. `burning` is true up to burnout.
    """

    time_from_liftoff: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"]
    push: Float[Array, "time"]
    push_sd: Float[Array, "time"]
    burning: Flags


@runtime_checkable
class Measured(Protocol):
    """What is taken of forces measured in a log, whoever measured them; as in `Track`."""

    @property
    def time_from_liftoff(self) -> Float[Array, "time"]: ...
    @property
    def height(self) -> Float[Array, "time"]: ...
    @property
    def speed(self) -> Float[Array, "time"]: ...
    @property
    def push(self) -> Float[Array, "time"]: ...
    @property
    def push_sd(self) -> Float[Array, "time"]: ...
    @property
    def burning(self) -> Flags: ...


def track_of(measured: Measured) -> Track:
    """The climb of which forces were measured."""
    return Track(*(getattr(measured, name) for name in Track.__dataclass_fields__))


@dataclass(frozen=True, slots=True, eq=False)
class Rocket:
    """What the model flies: motor, mass without it [kg], Cd times area [m^2], the air, the rail [m]."""

    motor: Motor
    dry_mass: float
    drag_area: float
    air: Air
    rail_length: float = 1.0
    thrust_factor: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Missing:
    """The missing force per mass along the climb [m/s^2], and the model's own thrust and drag per mass there."""

    track: Track
    rocket: Rocket
    force: Float[Array, "time"]
    thrust: Float[Array, "time"]
    steepness: Float[Array, "time"]
    """Rate of change of thrust per mass. [m/s^3]"""
    drag: Float[Array, "time"]


def beside_model(track: Track, rocket: Rocket) -> Missing:
    """Every sample beside the model's thrust and drag there."""
    thrust, steepness, mass = _thrust(track.time_from_liftoff, rocket)
    density = rocket.air.density * rocket.air.thinning(track.height)
    drag = 0.5 * density * rocket.drag_area * track.speed * np.abs(track.speed) / mass
    return Missing(track, rocket, track.push - thrust + drag, thrust, steepness, drag)


def _thrust(
    time: Float[Array, "time"], rocket: Rocket
) -> tuple[Float[Array, "time"], Float[Array, "time"], Float[Array, "time"]]:
    """Thrust per mass [m/s^2], its rate of change [m/s^3] and mass [kg] at times from lift-off."""
    motor, factor = rocket.motor, rocket.thrust_factor
    full = rocket.dry_mass + motor.casing_mass + motor.propellant_mass
    knots = np.linspace(0.0, motor.thrust_end, 2000)
    curve = factor * np.interp(knots, motor.time, motor.thrust)
    lift_off = knots[int(np.argmax(curve > full * GRAVITY))]
    spent = np.concatenate([[0.0], np.cumsum((curve[1:] + curve[:-1]) / 2)])
    mass = full - motor.propellant_mass * np.interp(time + lift_off, knots, spent / spent[-1])
    slope = np.gradient(curve, knots)
    push, steep = (np.interp(time + lift_off, knots, values, right=0.0) for values in (curve, slope))
    return push / mass, steep / mass, mass
