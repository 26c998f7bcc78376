"""Build a setup for the field physics from flights and their motors: certified thrust curves, real air, a rail.

What was not recorded gets a stated default: standard air at sea level, a vertical one-meter rail, a parachute that
descends at 5 m/s. Wind does not turn a rocket by itself: it acts only through the `wind` effect, whose strength is how
strongly this rocket weathercocks. Among flights with a recorded wind, one without it flew in an unknown wind, not in
calm air.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import Flight
from fieldkit.flight.launch_conditions import LaunchConditions
from fieldkit.flight.recovery import DESCENT_SPEED
from fieldkit.flight.short_name import flight_label
from fieldkit.motors import Found, Motor
from fieldkit.physics.atmosphere import altimeter_gain, pad_air, standard_temperature
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import FORECAST_RESOLUTION, Burns, Resolution, burns
from fieldkit.physics.wind import WindProfile
from fieldkit.shapes import Array, Float

RAIL_LENGTH = 1.0
"""Default rail length. [m]"""
USUAL_WIND = 3.5
"""Wind for the `wind` effect on a flight without a recorded one: the root mean square of a Rayleigh distribution with
mean 3.1 m/s, because the height lost by weathercocking grows with the square of the
wind. [m/s]"""
WIND_ALOFT_HEIGHT = 300.0
"""Default height of a wind aloft that was given as a speed only. [m]"""
USUAL_STABILITY = 2.0
"""Default static margin. [body diameters]"""
TURN_FACTOR = 1.39
"""Distance over which a rocket with the default stability turns into the wind, divided by the square root of its mass
per diameter. [m^1.5/kg^0.5]"""


def recorded(flights: Sequence[Flight], name: str) -> Float[Array, "flight"]:
    """One number of every flight in SI, nan if it was not recorded."""
    values = [flight.number(name) for flight in flights]
    return np.array([np.nan if value is None else value for value in values], float)


def differs_from_zero(flights: Sequence[Flight], name: str) -> bool:
    """Whether a condition is recorded for some flight and not zero for all, so that an effect of it acts."""
    column = recorded(flights, name)
    return bool(np.isfinite(column).any() and (column != 0).any())


def delays(flights: Sequence[Flight], found: Sequence[Found]) -> Float[Array, "flight"]:
    """Time from burnout to the ejection charge: as recorded, else from the motor's name; nan if unknown, and for one
    without a charge: a plugged motor, or a booster (a delay of 0). [s]"""
    stated = [
        flight.delay if flight.delay is not None else motor.delay for flight, motor in zip(flights, found, strict=True)
    ]
    return np.array([delay if delay and np.isfinite(delay) else np.nan for delay in stated], float)


def setup_of(
    flights: Sequence[Flight],
    found: Sequence[Found],
    conditions: Sequence[LaunchConditions],
    drag_area: Float[Array, "*draw flight"],
    thrust_factor: Float[Array, "*draw flight"] | float = 1.0,
    resolution: Resolution = FORECAST_RESOLUTION,
) -> Setup:
    """Flights on their motors, one entry per flight along the last axis, in SI units. Raises ImpossibleFlight for a
    flight without a dry mass."""
    motors = {motor: row for row, motor in enumerate(dict.fromkeys(item.motor for item in found))}
    along, across = rail_angles(recorded(flights, "rail_angle"), conditions)
    wind_power, wind_top = _wind_laws(flights, conditions)
    opening = [one.opening_time for one in conditions]
    elevation, temperature, pressure = (
        recorded(flights, name) for name in ("site_elevation", "temperature", "pressure")
    )
    return Setup(
        burns=_burns(tuple(motors), resolution.steps, resolution.knots),
        air=pad_air(elevation, temperature, pressure, recorded(flights, "humidity")),
        motor=np.array([motors[item.motor] for item in found]),
        dry_mass=dry_masses(flights),
        drag_area=np.asarray(drag_area, float),
        thrust_factor=np.asarray(thrust_factor, float),
        rail_length=np.nan_to_num(recorded(flights, "rail_length"), nan=RAIL_LENGTH),
        rail_angle=along,
        rail_across=across,
        turn_length=turn_lengths(flights, conditions),
        wind_power=wind_power,
        wind_top=wind_top,
        opening_time=np.array(opening if len(set(opening)) > 1 else opening[:1]),
        delay=delays(flights, found),
        descent_speed=np.nan_to_num(recorded(flights, "descent_speed"), nan=DESCENT_SPEED),
        altimeter_gain=altimeter_gain(elevation, temperature, pressure),
        recorded_wind=np.nan_to_num(recorded(flights, "wind"), nan=USUAL_WIND),
        temperature_recorded=np.isfinite(temperature),
        stride=resolution.stride,
    )


def rail_angles(
    recorded_angle: Float[Array, "flight"], conditions: Sequence[LaunchConditions]
) -> tuple[Float[Array, "flight"], Float[Array, "#flight"]]:
    """Angle of every rail from vertical, away from the wind and across it to the right; 0 if not recorded. [rad]

    A recorded angle points into the wind by default; a negative one points away from it.
    """
    angle, direction = np.nan_to_num(recorded_angle, nan=0.0), np.array([one.rail_direction for one in conditions])
    if not direction.any():
        return 0.0 - angle, np.zeros(1)
    across = np.round(np.sin(direction), 12) * angle
    return 0.0 - angle * np.round(np.cos(direction), 12), across if across.any() else np.zeros(1)


def wind_profile(surface: float | None, conditions: LaunchConditions) -> WindProfile:
    """The wind profile above a wind at the pad [m/s]; calm if none was recorded."""
    if conditions.wind_aloft is None:
        return WindProfile(surface or 0.0)
    height = conditions.wind_aloft_height or WIND_ALOFT_HEIGHT
    return WindProfile(surface or 0.0, conditions.wind_aloft, height, conditions.wind_aloft_turn)


def _wind_laws(
    flights: Sequence[Flight], conditions: Sequence[LaunchConditions]
) -> tuple[Float[Array, "#flight"], Float[Array, "#flight"]]:
    """Exponent of the wind's power law [1] and the height above which the wind is constant [m], for every flight.

    Climb and descent follow the wind profile; only the descent includes the change of direction with height.
    """
    laws = [wind_profile(flight.wind, one).law for flight, one in zip(flights, conditions, strict=True)]
    if len(set(laws)) == 1:
        laws = laws[:1]
    return np.array([power for power, _ in laws]), np.array([top for _, top in laws])


def at_elevation(setup: Setup, higher: Float[Array, "*#draw"]) -> Setup:
    """The setup with all pads higher than recorded by `higher` [m]: lower pressure, and lower temperature if none was
    recorded.

    An altimeter assumes standard air at the pressure it measures, which is colder the higher the pad. If the
    temperature was recorded, it is the true one, and the altimeter reads lower.
    """
    coolness = standard_temperature(higher) / standard_temperature(np.zeros(()))
    thinness = _standard_density(higher) / _standard_density(np.zeros(()))
    known = setup.temperature_recorded
    density = setup.air.density * thinness * np.where(known, coolness, 1.0)
    air = replace(setup.air, density=density, temperature=setup.air.temperature * np.where(known, 1.0, coolness))
    return setup.with_changes(air=air, altimeter_gain=setup.altimeter_gain * np.where(known, coolness, 1.0))


def _standard_density(elevation: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
    """Density of standard air at a height above sea level [m]. [kg/m^3]"""
    unknown = np.full((), np.nan)
    return pad_air(elevation, unknown, unknown, unknown).density


def in_other_weather(setup: Setup, flights: Sequence[Flight], off: Mapping[str, Float[Array, "*draw flight"]]) -> Setup:
    """The setup with errors of the recorded temperature [K], pressure [Pa] and wind [m/s], by name; what was not
    recorded stays as it is."""
    elevation, humidity = recorded(flights, "site_elevation"), recorded(flights, "humidity")
    temperature, pressure, wind = (
        recorded(flights, name) + off.get(name, 0.0) for name in ("temperature", "pressure", "wind")
    )
    return setup.with_changes(
        air=pad_air(elevation, temperature, pressure, humidity),
        altimeter_gain=altimeter_gain(elevation, temperature, pressure),
        recorded_wind=np.nan_to_num(np.maximum(wind, 0.0), nan=USUAL_WIND),
    )


def turn_lengths(flights: Sequence[Flight], conditions: Sequence[LaunchConditions]) -> Float[Array, "flight"]:
    """Distance off the rail over which each rocket turns into the relative wind. [m]

    A quarter of its pitching wavelength, 2 pi sqrt(2 I / (rho A C s)) (Mandell, Caporaso and Bengen, Topics in Advanced
    Model Rocketry, 1973, dynamic stability), with the moment of inertia I = m L^2 / 12 of a slender body of length L =
    12 diameters, the normal force slope C = 16 of a nose with fins, and the static margin s. A heavy rocket therefore
    turns later, a stable one sooner. With a quarter, landing points agree best with six-degree-of-freedom simulations,
    to within 10% (`tests/physics/test_descent.py`). Raises ImpossibleFlight for a flight without a dry mass.
    """
    size = dry_masses(flights) / diameters(flights)
    return np.asarray(
        TURN_FACTOR
        * np.sqrt(size * USUAL_STABILITY / np.array([one.stability or USUAL_STABILITY for one in conditions]))
    )


def diameters(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    """Body diameter of every flight; if not recorded, the typical diameter for its dry mass. [m]

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    known = recorded(flights, "diameter")
    return np.where(np.isnan(known), typical_diameters(flights), known)


def typical_diameters(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    """Typical body diameter for the dry mass of every flight. [m]

    The rule of thumb d = 60 mm (m / 0.4 kg)^0.2 is a fit to the drag of 34 rockets from 36 g to 3.8 kg in a public
    launch ledger (jdsmith39/RocketLaunchJournal, flights to 2017), with the prior mean of Cd of
    `fieldkit.model.hyperprior`. Raises ImpossibleFlight for a flight without a dry mass.
    """
    return 0.060 * (dry_masses(flights) / 0.4) ** 0.2


def reference_area(flights: Sequence[Flight], flown: int | None = None) -> Float[Array, "flight"]:
    """Frontal area of the body, to which drag is relative. [m^2]

    A flight without a diameter has the mean diameter of its configuration over the first `flown` flights, by default
    over all, or else that of the rocket. If none of them has one, every flight, planned ones too, has the mean of the
    typical diameters for their dry masses: another area for a plan would change its drag, which the flights determine.
    For a rocket never flown, each plan has its own diameter, or else its typical one. Derivation: the area of a circle.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    typical, diameter = typical_diameters(flights), recorded(flights, "diameter")
    if flown == 0:
        return np.asarray(np.pi / 4 * np.where(np.isnan(diameter), typical, diameter) ** 2)
    if not diameter_known(flights, flown):
        return np.full(len(flights), np.pi / 4 * typical[:flown].mean() ** 2)
    config, known = np.array([flight.config for flight in flights]), np.isfinite(diameter)[:flown]
    for row in np.flatnonzero(np.isnan(diameter)):
        own = known & (config[:flown] == config[row])
        diameter[row] = diameter[:flown][own if own.any() else known].mean()
    return np.asarray(np.pi / 4 * diameter**2)


def diameter_known(flights: Sequence[Flight], flown: int | None = None) -> bool:
    """Whether any of the first `flown` flights, by default of all, has a diameter; for a rocket never flown, whether
    every plan has one."""
    known = np.isfinite(recorded(flights, "diameter"))
    return bool(known.all() if flown == 0 else known[:flown].any())


def dry_masses(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    """Mass of every flight without its motor. Raises ImpossibleFlight if one is missing. [kg]"""
    found = recorded(flights, "dry_mass")
    if np.isnan(found).any():
        first = flights[int(np.argmax(np.isnan(found)))]
        name = flight_label(first.flight_id) if first.flight_id else first.rocket or "the plan"
        raise ImpossibleFlight(f"{name}: no dry mass, expected the rocket's mass without its motor")
    return found


@lru_cache(maxsize=64)
def _burns(motors: tuple[Motor, ...], steps: int, knots: int | None) -> Burns:
    """Cached `burns`, because a fit simulates the same motors many times."""
    return burns(motors, steps=steps, knots=knots)
