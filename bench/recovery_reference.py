"""RocketPy simulations down to the ground, as a reference for durations and landings.

`python -m bench.recovery_reference FILE` writes them.

Each rocket flies a thrust curve of the catalog with one drag coefficient, opens one parachute or a drogue and a main,
and lands in a wind that grows with height. RocketPy has six degrees of freedom and shares no code with fieldkit.
"""

import json
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from rocketpy import Environment, Flight, GenericMotor, Rocket

from fieldkit.motors import Motor, catalogue

MODEL: dict[str, Any] = {
    "dry_mass": 0.34,
    "diameter": 0.066,
    "length": 0.8,
    "cd": 0.6,
    "rail_length": 1.5,
    "first_speed": 5.5,
    "main_speed": 0.0,
    "main_altitude": 0.0,
    "lag": 0.5,
    "rail_into": 0.0,
    "rail_across": 0.0,
}
DUAL: dict[str, Any] = {
    "cd": 0.55,
    "rail_length": 2.4,
    "first_speed": 20.0,
    "main_speed": 6.0,
    "main_altitude": 150.0,
    "lag": 0.5,
    "rail_into": 0.0,
    "rail_across": 0.0,
}
"""Common values of the cases of model rockets, and of high-power rockets with a drogue and a main."""
CASES: dict[str, dict[str, Any]] = {
    "model, one parachute": MODEL | {"motor": "F24W", "wind": 3.0},
    "model, rail into the wind": MODEL | {"motor": "F39T", "wind": 4.0, "rail_into": 5.0},
    "model, rail across the wind": MODEL | {"motor": "F39T", "wind": 4.0, "rail_across": 7.0},
    "dual, rail upright": DUAL | {"motor": "H128W", "dry_mass": 1.2, "diameter": 0.079, "length": 1.3, "wind": 4.0},
    "dual, rail into the wind": DUAL
    | {"motor": "I284W", "dry_mass": 2.0, "diameter": 0.102, "length": 1.6, "wind": 5.0, "rail_into": 5.0},
    "dual, strong wind aloft": DUAL
    | {
        "motor": "I284W",
        "dry_mass": 2.0,
        "diameter": 0.102,
        "length": 1.6,
        "wind": 3.0,
        "wind_aloft": 12.0,
        "wind_aloft_height": 600.0,
        "rail_into": 3.0,
    },
    "model of 60 g": MODEL
    | {"motor": "C6", "dry_mass": 0.06, "diameter": 0.034, "length": 0.5, "cd": 0.7}
    | {"wind": 2.0, "rail_into": 3.0, "rail_length": 0.9, "first_speed": 4.5},
    "model, rail away from the wind": MODEL
    | {"motor": "D12", "dry_mass": 0.12, "diameter": 0.042, "length": 0.6, "wind": 3.0, "rail_into": -4.0},
    "contest rocket, 8 degrees": MODEL
    | {"motor": "F42T", "dry_mass": 0.5, "length": 0.75, "cd": 0.55, "wind": 4.0, "rail_into": 8.0, "rail_length": 1.8},
    "G80T, rail across the wind": MODEL
    | {"motor": "G80T", "dry_mass": 0.75, "diameter": 0.075, "length": 1.1, "cd": 0.5}
    | {"wind": 5.0, "rail_across": 5.0, "rail_length": 1.8, "first_speed": 6.5},
    "streamer": MODEL | {"motor": "F24W", "wind": 5.0, "rail_into": 5.0, "first_speed": 10.0},
    "dual, wind of 6 m/s, rail across": DUAL
    | {"motor": "H128W", "dry_mass": 1.4, "diameter": 0.076, "length": 1.5, "wind": 6.0, "rail_across": -6.0}
    | {"main_altitude": 200.0, "first_speed": 25.0},
    "dual, 3.5 kg": DUAL
    | {"motor": "J350W", "dry_mass": 3.5, "diameter": 0.098, "length": 2.0, "wind": 2.0, "rail_into": 6.0}
    | {"first_speed": 30.0, "main_altitude": 250.0, "rail_length": 3.0},
    "dual, wind of 8 m/s aloft": DUAL
    | {"motor": "I161W", "dry_mass": 1.8, "diameter": 0.102, "length": 1.5, "wind": 5.0, "rail_into": 4.0}
    | {"wind_aloft": 8.0, "wind_aloft_height": 300.0},
    "dual, 6 kg": DUAL
    | {"motor": "K550W", "dry_mass": 6.0, "diameter": 0.130, "length": 2.3, "wind": 4.0, "rail_into": 5.0}
    | {"rail_length": 3.0, "first_speed": 25.0, "main_speed": 7.0, "main_altitude": 200.0},
}
"""Descent speeds near the ground [m/s], wind at the pad [m/s], angles in degrees, the rest in SI."""
CHORD, TIP, SPAN, BALANCE = 0.15, 0.6, 0.8, 0.5
"""Proportions in the chosen cases: the fins' root chord over the rocket's length, their tip chord and span over the
root chord, and the balance point of the rocket without its motor over its length. [1]"""
SIZES = (
    ("C6", 0.07, 0.034, 1.0),
    ("D12", 0.11, 0.041, 1.0),
    ("E12", 0.15, 0.042, 1.0),
    ("F24W", 0.35, 0.060, 1.8),
    ("F39T", 0.40, 0.066, 1.8),
    ("G80T", 0.80, 0.075, 1.8),
    ("H128W", 1.20, 0.079, 2.6),
    ("I161W", 1.80, 0.098, 2.6),
    ("J350W", 3.00, 0.098, 2.6),
    ("K550W", 6.00, 0.130, 2.6),
)
"""Motors of the drawn cases, with a typical rocket for each: dry mass [kg], diameter [m], rail [m]."""
DUAL_MASS = 1.0
"""Dry mass above which a drawn case has a drogue and a main. [kg]"""
STABILITY_DRAWN = (1.0, 4.0)
"""Static margins on the pad of the drawn cases that are flown. [body diameters]"""
DRAWN, SEED = 40, 11


def drawn(rng: np.random.Generator, number: int) -> dict[str, Any]:
    """A random case; every third has a stronger wind aloft."""
    motor, mass, diameter, rail = SIZES[number % len(SIZES)]
    wind = rng.uniform(2, 6)
    case = {
        "motor": motor,
        "dry_mass": mass * rng.uniform(0.85, 1.15),
        "diameter": diameter,
        "length": diameter * rng.uniform(11, 16),
        "balance": rng.uniform(0.46, 0.53),
        "chord": 1.6 * diameter,
        "tip": 0.5,
        "span": diameter * rng.uniform(0.8, 1.3),
        "fins": int(rng.integers(3, 5)),
        "cd": rng.uniform(0.45, 0.7),
        "rail_length": rail,
        "rail_into": rng.uniform(-2, 6),
        "rail_across": rng.uniform(-5, 5) if number % 2 else 0.0,
        "lag": 0.5,
        "wind": wind,
    }
    if number % 3 == 0:
        case |= {"wind_aloft": wind * rng.uniform(1.2, 3), "wind_aloft_height": float(rng.choice([200, 400, 600]))}
    if mass < DUAL_MASS:
        return case | {"first_speed": rng.uniform(4, 6.5), "main_speed": 0.0, "main_altitude": 0.0}
    devices = {"main_speed": rng.uniform(5, 7), "main_altitude": rng.uniform(120, 250)}
    return case | {"first_speed": rng.uniform(15, 28)} | devices


def cases() -> dict[str, dict[str, Any]]:
    """The chosen cases, and the drawn ones with a static margin in `STABILITY_DRAWN`."""
    rng = np.random.default_rng(SEED)
    more = {f"drawn {number}": drawn(rng, number) for number in range(DRAWN)}
    margins = {
        name: _rocket(case, catalogue().resolve(case["motor"]).motor).static_margin(0) for name, case in more.items()
    }
    low, high = STABILITY_DRAWN
    return CASES | {name: case for name, case in more.items() if low < margins[name] < high}


def flown(case: dict[str, Any]) -> dict[str, float]:
    """Apogee [m], duration [s], apogee and landing downwind and across [m], and static margin on the pad [1] of a
    case."""
    motor = catalogue().resolve(case["motor"]).motor
    rocket = _rocket(case, motor)
    flight = Flight(
        rocket=rocket,
        environment=_environment(case),
        rail_length=case["rail_length"],
        inclination=90 - float(np.hypot(case["rail_into"], case["rail_across"])),
        heading=float(np.degrees(np.arctan2(-case["rail_into"], -case["rail_across"]))),
        max_time_step=0.05,
    )
    return {
        "apogee": float(flight.apogee),
        "rise": float(flight.apogee_time),
        "duration": float(flight.t_final),
        "stability": float(rocket.static_margin(0)),
        "apogee_along": float(flight.apogee_x),
        "apogee_across": -float(flight.apogee_y),
        "along": float(flight.x_impact),
        "across": -float(flight.y_impact),
    }


def _environment(case: dict[str, Any]) -> Any:
    """Standard air over flat ground at sea level, and the wind of a case toward the east."""
    from fieldkit.physics.wind import WindProfile

    height = np.unique(np.concatenate([np.linspace(0, 50, 26), np.linspace(50, 4000, 200)]))
    blow, _ = WindProfile(case["wind"], case.get("wind_aloft"), case.get("wind_aloft_height")).components(height)
    field = Environment(latitude=45.0, longitude=0.0, elevation=0.0)
    field.set_atmospheric_model(type="custom_atmosphere", wind_u=np.column_stack([height, blow]).tolist(), wind_v=0)
    return field


def _rocket(case: dict[str, Any], motor: Motor) -> Any:
    """A stable rocket about the motor: an ogive, four fins, and its parachutes."""
    length, diameter, dry = case["length"], case["diameter"], case["dry_mass"]
    inertia = dry * (0.27 * length) ** 2
    rocket = Rocket(
        radius=diameter / 2,
        mass=dry,
        inertia=(inertia, inertia, dry * diameter**2 / 6),
        power_off_drag=case["cd"],
        power_on_drag=case["cd"],
        center_of_mass_without_motor=case.get("balance", BALANCE) * length,
        coordinate_system_orientation="nose_to_tail",
    )
    rocket.add_motor(
        GenericMotor(
            thrust_source=np.column_stack([motor.time, motor.thrust]).tolist(),
            burn_time=float(motor.time[-1]),
            chamber_radius=motor.diameter / 2.2,
            chamber_height=motor.length * 0.8,
            chamber_position=motor.length / 2,
            propellant_initial_mass=motor.propellant_mass,
            nozzle_radius=motor.diameter / 6,
            dry_mass=motor.casing_mass,
            center_of_dry_mass_position=motor.length / 2,
        ),
        position=length,
    )
    rocket.add_nose(length=0.2 * length, kind="ogive", position=0)
    chord = case.get("chord", CHORD * length)
    rocket.add_trapezoidal_fins(
        n=case.get("fins", 4),
        root_chord=chord,
        tip_chord=case.get("tip", TIP) * chord,
        span=case.get("span", SPAN * chord),
        position=length - chord,
    )
    weight = 2 * (dry + motor.casing_mass) * 9.80665 / 1.225
    rocket.add_parachute("first", cd_s=weight / case["first_speed"] ** 2, trigger="apogee", lag=case["lag"])
    if case["main_altitude"]:
        rocket.add_parachute(
            "main", cd_s=weight / case["main_speed"] ** 2, trigger=case["main_altitude"], lag=case["lag"]
        )
    return rocket


def main() -> None:
    """Fly every case and write them to a file."""
    document = {"rocketpy": version("rocketpy"), "command": "python -m bench.recovery_reference FILE"}
    every = [{"name": name, **case, "flown": flown(case)} for name, case in cases().items()]
    Path(sys.argv[1]).write_text(json.dumps({**document, "cases": every}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
