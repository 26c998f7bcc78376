"""A measured climb and the model: at every sample, the measured push minus the model's thrust and drag.

Nothing is integrated: thrust and drag are computed from the measured speed and height, so the difference belongs to
that moment.
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis import Forces
from fieldkit.motors.motor import Motor
from fieldkit.physics.atmosphere import GRAVITY, Air
from fieldkit.shapes import Array, Flags, Float

STEP = 0.001
"""Time step of the thrust curve in the comparison. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class ClimbTrack:
    """A measured vertical climb on one clock, in SI units.

    `push` is thrust minus drag over mass, as an axial accelerometer measures it, with its standard deviation; heights
    are above the pad. `burning` is true up to burnout. `window` is the averaging time of each push [s].
    """

    time_from_liftoff: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"]
    push: Float[Array, "time"]
    push_sd: Float[Array, "time"]
    burning: Flags
    window: float = 0.0

    def part(self, rows: Flags) -> "ClimbTrack":
        """A subset of its samples."""
        return replace(self, **{name: getattr(self, name)[rows] for name in SAMPLED_FIELDS})


SAMPLED_FIELDS = tuple(name for name in ClimbTrack.__dataclass_fields__ if name != "window")
"""Fields of a climb that have one value per sample."""


def track_of(measured: Forces) -> ClimbTrack:
    """The measured climb."""
    return ClimbTrack(**{name: getattr(measured, name) for name in SAMPLED_FIELDS}, window=measured.window or 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class RocketInputs:
    """The simulated rocket: motor, mass without it [kg], Cd times area [m^2], the air, the rail [m]."""

    motor: Motor
    dry_mass: float
    drag_area: float
    air: Air
    rail_length: float = 1.0
    thrust_factor: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Missing:
    """The missing force per mass along the climb [m/s^2], and the model's own thrust and drag per mass there.

    `burning` is true until the motor's curve ends, which is after top speed if thrust dies away slowly.
    """

    track: ClimbTrack
    rocket: RocketInputs
    force: Float[Array, "time"]
    thrust: Float[Array, "time"]
    steepness: Float[Array, "time"]
    """Rate of change of thrust per mass. [m/s^3]"""
    drag: Float[Array, "time"]
    burning: Flags


def beside_model(track: ClimbTrack, rocket: RocketInputs) -> Missing:
    """The missing force and the modeled thrust and drag at every sample."""
    thrust, steepness, mass, burning = _thrust(track.time_from_liftoff, rocket, track.window)
    density = rocket.air.density * rocket.air.density_ratio(track.height)
    drag = 0.5 * density * rocket.drag_area * track.speed * np.abs(track.speed) / mass
    return Missing(track, rocket, track.push - thrust + drag, thrust, steepness, drag, burning)


def _thrust(
    time: Float[Array, "time"], rocket: RocketInputs, window: float
) -> tuple[Float[Array, "time"], Float[Array, "time"], Float[Array, "time"], Flags]:
    """Thrust per mass [m/s^2], its rate of change [m/s^3], mass [kg] and whether the motor burns, at times from
    lift-off.

    Thrust is averaged over the same window [s] as the measurement.
    """
    motor, factor = rocket.motor, rocket.thrust_factor
    full = rocket.dry_mass + motor.casing_mass + motor.propellant_mass
    knots = np.arange(-window, motor.thrust_end + window + STEP, STEP)
    curve = factor * np.interp(knots, motor.time, motor.thrust, left=0.0, right=0.0)
    lift_off = knots[int(np.argmax(curve > full * GRAVITY))]
    spent = np.concatenate([[0.0], np.cumsum((curve[1:] + curve[:-1]) / 2 * STEP)])
    mass = full - motor.propellant_mass * np.interp(time + lift_off, knots, spent / spent[-1])
    if window:
        ends = [np.interp(knots + half, knots, spent) for half in (-window / 2, window / 2)]
        curve = (ends[1] - ends[0]) / window
    slope = np.gradient(curve, knots)
    push, steep = (np.interp(time + lift_off, knots, values, left=0.0, right=0.0) for values in (curve, slope))
    return push / mass, steep / mass, mass, time + lift_off < motor.thrust_end
