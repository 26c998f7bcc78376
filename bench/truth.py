"""Simulation of a launch with RocketPy: six degrees of freedom, fins, nose, wind, rail, a measured thrust curve.

About one flight a second. RocketPy flies up to apogee or the ejection charge, whichever comes first; after that the
rocket is a point mass under an opening parachute (`bench.parachute`), because RocketPy's parachutes open by height or
speed and not after a delay. Rail friction, updrafts and Reynolds-number effects on drag are not supported.
"""

from typing import Any

import numpy as np
from rocketpy import Environment, Flight, GenericMotor, Rocket

from bench import barrowman, parachute
from bench.air import GRAVITY, pressure, station_pressure, temperature, turned, wind_speed
from bench.fast_truth import mach_factor
from bench.world import Launch, Track
from fieldkit.errors import BadValue
from fieldkit.shapes import Array, Float

STEP = 0.005


def fly(launch: Launch) -> Track:
    """The track of one launch. Raises BadValue for an unsupported launch."""
    if launch.beyond_rocketpy:
        raise BadValue(
            "found friction, an updraft or drag by Reynolds number, expected a launch without: use --truth fast"
        )
    charge = launch.motor.burn_time + launch.delay
    flight = Flight(
        rocket=_rocket(launch),
        environment=_environment(launch),
        rail_length=launch.rail_length,
        inclination=90 - np.degrees(launch.tilt),
        heading=90 - np.degrees(launch.heading),
        max_time=charge,
        max_time_step=0.05,
        terminate_on_apogee=True,
    )
    time = np.arange(0.0, min(charge, float(flight.t_final)), STEP)
    axis = _sampled(flight, ["attitude_vector_x", "attitude_vector_y", "attitude_vector_z"], time)
    place = _sampled(flight, ["x", "y", "altitude"], time)
    velocity = _sampled(flight, ["vx", "vy", "vz"], time)
    push = _sampled(flight, ["ax", "ay", "az"], time)
    push[2] += GRAVITY
    speed = np.sqrt((velocity**2).sum(axis=0))
    felt = (push * axis).sum(axis=0)
    liftoff = float(time[int(np.argmax(speed > 0.05))])
    end = np.concatenate([place[:, -1], velocity[:, -1]])
    hang, states = parachute.opening(end, float(time[-1]), charge, launch)
    height = np.concatenate([place[2], states[2, 1:]])
    mass = launch.dry_mass + launch.motor.total_mass - launch.motor.propellant_mass
    drag_area = launch.chute_area + launch.drag.cd * np.pi / 4 * launch.airframe.diameter**2
    fall, drop = parachute.descent(max(float(height[-1]), 0.0), mass, drag_area, launch.air)
    gone = np.full(len(drop), np.nan)
    return Track(
        time=np.concatenate([time, hang[1:], hang[-1] + fall]),
        height=np.concatenate([height, drop]),
        speed=np.concatenate([speed, np.sqrt((states[3:, 1:] ** 2).sum(axis=0)), gone]),
        push=np.concatenate([felt, np.zeros(len(hang) - 1), gone]),
        liftoff=liftoff,
        burnout=launch.motor.burn_time,
        ejection=charge if hang[-1] > charge else None,
    )


def _sampled(flight: Any, names: list[str], time: Float[Array, "step"]) -> Float[Array, "three step"]:
    return np.array([np.asarray(getattr(flight, name).get_value(list(time)), dtype=float) for name in names])


def _environment(launch: Launch) -> Any:
    air = launch.air
    station = station_pressure(air.qnh, air.elevation)
    field = Environment(latitude=45.0, longitude=0.0, elevation=air.elevation)
    levels = np.unique(np.concatenate([np.linspace(0, 30, 16), np.linspace(30, 3000, 100)]))
    msl = levels + air.elevation
    east, north = turned(wind_speed(levels, air.wind, air.wind_height, air.shear), levels, air.turn)
    field.set_atmospheric_model(
        type="custom_atmosphere",
        pressure=np.column_stack([msl, pressure(levels, air.temperature, station)]).tolist(),
        temperature=np.column_stack([msl, temperature(levels, air.temperature)]).tolist(),
        wind_u=np.column_stack([msl, east]).tolist(),
        wind_v=np.column_stack([msl, north]).tolist(),
    )
    return field


def _rocket(launch: Launch) -> Any:
    frame, motor = launch.airframe, launch.motor
    mach = np.linspace(0, 2, 81)
    curve = np.column_stack([mach, launch.drag.cd * mach_factor(mach, launch.drag.mach_rise)])
    off = curve * np.array([1.0, launch.drag.power_off])
    inertia = launch.dry_mass * (barrowman.GYRATION * frame.length) ** 2
    rocket = Rocket(
        radius=frame.diameter / 2,
        mass=launch.dry_mass,
        inertia=(inertia, inertia, launch.dry_mass * frame.diameter**2 / 6),
        power_off_drag=off.tolist(),
        power_on_drag=curve.tolist(),
        center_of_mass_without_motor=frame.dry_cg,
        coordinate_system_orientation="nose_to_tail",
    )
    rocket.add_motor(
        GenericMotor(
            thrust_source=np.column_stack([motor.time, motor.thrust]).tolist(),
            burn_time=motor.burn_time,
            chamber_radius=motor.diameter / 2.2,
            chamber_height=motor.length * 0.8,
            chamber_position=motor.length / 2,
            propellant_initial_mass=motor.propellant_mass,
            nozzle_radius=motor.diameter / 6,
            dry_mass=motor.total_mass - motor.propellant_mass,
            center_of_dry_mass_position=motor.length / 2,
        ),
        position=frame.length,
    )
    rocket.add_nose(length=frame.nose, kind="ogive", position=0)
    rocket.add_trapezoidal_fins(
        n=frame.fins,
        root_chord=frame.root,
        tip_chord=frame.tip,
        span=frame.span,
        sweep_length=frame.sweep,
        position=frame.length - frame.root,
    )
    return rocket
