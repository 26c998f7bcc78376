"""From flights and their motors to a set-up in the field physics: certified curves, real air, a rail.

What was not recorded takes a stated default: standard air at sea level, a one-meter rail that stands
upright, a parachute that falls at 5 m/s. Declared wind is not in the set-up: it acts through the `wind`
effect alone, whose strength says how strongly this rocket turns into it.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import Flight
from fieldkit.flight.recovery import rail_direction
from fieldkit.motors import Found, Motor
from fieldkit.physics.atmosphere import altimeter_gain, pad_air
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import STEPS, Burns, burns
from fieldkit.shapes import Array, Float

RAIL_LENGTH = 1.0
"""Of a rod if none was recorded. [m]"""
DESCENT_SPEED = 5.0
"""Under a parachute if none was recorded. [m/s]"""


def recorded(flights: Sequence[Flight], name: str) -> Float[Array, "flight"]:
    """A number of every flight in SI, nan if it was not recorded."""
    values = [flight.number(name) for flight in flights]
    return np.array([np.nan if value is None else value for value in values], float)


def delays(flights: Sequence[Flight], found: Sequence[Found]) -> Float[Array, "flight"]:
    """From burnout to the ejection charge: as recorded, else as the motor's name says, else nan. [s]"""
    stated = [
        flight.delay if flight.delay is not None else motor.delay for flight, motor in zip(flights, found, strict=True)
    ]
    return np.array([np.nan if delay is None or not np.isfinite(delay) else delay for delay in stated], float)


def field_setup(
    flights: Sequence[Flight],
    found: Sequence[Found],
    drag_area: Float[Array, "*draw flight"],
    thrust_factor: Float[Array, "*draw flight"] | float = 1.0,
    steps: int = STEPS,
    knots: int | None = None,
    stride: float = 1.0,
) -> Setup:
    """Flights on their motors, one entry a flight along the last axis, in SI units; `steps` and `knots` as in `burns`,
    `stride` as in `Setup`.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    motors = {id(item.motor): item.motor for item in found}
    row = {key: number for number, key in enumerate(motors)}
    along, across = rail_angles(flights)
    conditions = [recorded(flights, name) for name in ("site_elevation", "temperature", "pressure")]
    return Setup(
        burns=_burns(tuple(motors.values()), steps, knots),
        air=pad_air(conditions[0], conditions[1], conditions[2], recorded(flights, "humidity")),
        motor=np.array([row[id(item.motor)] for item in found]),
        dry_mass=dry_masses(flights),
        drag_area=np.asarray(drag_area, float),
        thrust_factor=np.asarray(thrust_factor, float),
        rail_length=np.nan_to_num(recorded(flights, "rail_length"), nan=RAIL_LENGTH),
        rail_angle=along,
        rail_across=across,
        delay=delays(flights, found),
        descent_speed=np.nan_to_num(recorded(flights, "descent_speed"), nan=DESCENT_SPEED),
        altimeter_gain=altimeter_gain(conditions[0], conditions[1], conditions[2]),
        stride=stride,
    )


def rail_angles(flights: Sequence[Flight]) -> tuple[Float[Array, "flight"], Float[Array, "#flight"]]:
    """Angle of every rail from vertical, away from the wind and across it to the right; 0 if not recorded. [rad]

    A recorded angle is into the wind by default, a negative one away from it.
    """
    angle = np.nan_to_num(recorded(flights, "rail_angle"), nan=0.0)
    turned = [row for row, flight in enumerate(flights) if angle[row] and flight.extra.get("rail_direction")]
    if not turned:
        return 0.0 - angle, np.zeros(1)
    direction = np.zeros(len(flights))
    direction[turned] = [rail_direction(flights[row]) for row in turned]
    across = np.round(np.sin(direction), 12) * angle
    return 0.0 - angle * np.round(np.cos(direction), 12), across if across.any() else np.zeros(1)


def dry_masses(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    """Mass of every flight without its motor. Raises ImpossibleFlight for one that has none. [kg]"""
    found = recorded(flights, "dry_mass")
    if np.isnan(found).any():
        name = flights[int(np.argmax(np.isnan(found)))].flight_id or "the flight"
        raise ImpossibleFlight(f"{name}: found no dry mass, expected dry_mass_g, the rocket's mass without its motor")
    return found


@lru_cache(maxsize=64)
def _burns(motors: tuple[Motor, ...], steps: int, knots: int | None) -> Burns:
    """The same motors fly again and again while a model is fitted."""
    return burns(motors, steps=steps, knots=knots)
