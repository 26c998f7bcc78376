"""Rockets for the bench, and the motors and delays that a careful flyer would choose."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from bench import barrowman
from bench.motors import motors
from bench.vertical import climb
from bench.world import Air, Airframe, Drag, Launch, Motor

CLASSES: Mapping[str, tuple[tuple[str, ...], tuple[float, float], tuple[float, float]]] = {
    "tiny": (("C6", "C11", "D13W", "D24T"), (0.025, 0.034), (0.045, 0.095)),
    "small": (("C11", "D12", "D15T", "E12", "E20W", "E28T"), (0.034, 0.042), (0.10, 0.22)),
    "medium": (("E28T", "E35W", "F24W", "F39T", "F35W"), (0.041, 0.066), (0.26, 0.52)),
    "large": (("F26FJ", "F27R", "F37W", "F40W", "F52T", "F67W", "G38FJ", "G40W", "G54W"), (0.056, 0.079), (0.5, 1.0)),
    "heavy": (("G40W", "G64W", "G80T", "G125T", "H100W", "H128W", "H165R"), (0.066, 0.102), (0.9, 1.7)),
    "fast": (("F52T", "F67W", "G54W", "G80T", "G125T"), (0.031, 0.040), (0.14, 0.30)),
}
"""Sizes of rocket: the motors they take, diameters in m, dry masses in kg."""


@dataclass(frozen=True, slots=True)
class Needs:
    """Requirements of a scenario for the rocket and the season."""

    classes: tuple[str, ...] = ("tiny", "small", "medium", "medium", "large", "large", "heavy")
    configs: int = 0
    """Exact number of configurations; 0 means one or two."""
    sites: int = 0
    """Minimum number; 0 means one to three."""
    margin: tuple[float, float] = (1.2, 1.8)
    """Static margin on the pad. [caliber]"""
    rail: tuple[float, float] = (1.5, 2.4)
    conditions: str = ""
    """Declared conditions: `all`, `wind` or `none`; empty for a random choice."""
    readouts: tuple[str, ...] = ("all", "all", "three", "apogee")
    """Possible readouts: all ten, apogee with speed and coast, or the apogee alone."""
    scatter: float = 1.0
    """Factor on the scatter of thrust and drag."""
    lift: tuple[float, float] = (5.0, 40.0)
    """Minimum thrust-to-weight ratio over the first 0.4 s. [1]"""
    cd: tuple[float, float] = (0.38, 0.75)
    top_speed: float = 0.0
    """Minimum top speed with the fastest motor. [m/s]"""
    high: float = 1500.0
    """Maximum elevation of sites if all conditions are declared. [m]"""


@dataclass(frozen=True, slots=True)
class Combination:
    """A motor in a configuration, with the delay that a careful flyer would choose."""

    motor: Motor
    key: str
    config: str
    mass: float
    delay: float
    coast: float
    top_speed: float


@dataclass(frozen=True, slots=True)
class Rocket:
    """An airframe with its drag, rail and parachute [m^2], and the motors that it flies on."""

    frame: Airframe
    drag: Drag
    rail: float
    chute: float
    launch_angle: float
    """Nominal angle of the rail, declared. [rad]"""
    combinations: tuple[Combination, ...] = field(default=())


def draw_rocket(rng: np.random.Generator, needs: Needs, conditions: str) -> Rocket:
    """A rocket with at least two motors that have enough thrust and a suitable delay."""
    while True:
        names, diameters, masses = CLASSES[str(rng.choice(list(needs.classes)))]
        diameter, mass = float(rng.uniform(*diameters)), float(rng.uniform(*masses))
        configs = {"A": mass}
        if needs.configs == 2 or (needs.configs == 0 and rng.random() < 0.5):
            configs["B"] = mass * float(rng.uniform(1.08, 1.35))
        frame = Airframe(
            diameter=diameter,
            length=diameter * float(rng.uniform(13, 19)),
            nose=diameter * float(rng.uniform(3, 5)),
            fins=int(rng.choice([3, 4])),
            root=diameter * float(rng.uniform(1.4, 2.0)),
            tip=diameter * float(rng.uniform(0.7, 1.1)),
            span=diameter * float(rng.uniform(0.9, 1.2)),
            sweep=diameter * float(rng.uniform(0.5, 1.0)),
            dry_cg=0.0,
        )
        heaviest = max((motors()[n] for n in names), key=lambda m: m.total_mass)
        margin = float(rng.uniform(*needs.margin))
        cg = barrowman.cg_for_margin(frame, mass, heaviest.total_mass, heaviest.length, margin)
        if not 0.35 * frame.length < cg < 0.75 * frame.length:
            continue
        rocket = Rocket(
            frame=replace(frame, dry_cg=cg),
            drag=Drag(float(rng.uniform(*needs.cd))),
            rail=float(rng.uniform(*needs.rail)),
            chute=mass * float(rng.uniform(0.35, 0.9)),
            launch_angle=float(np.radians(rng.choice([0, 0, 0, 3, 5]))) if conditions == "all" else 0.0,
        )
        found = _combinations(rocket, names, configs, needs)
        usable = sorted({c.key for c in found if {d.config for d in found if d.key == c.key} == set(configs)})
        chosen = [str(key) for key in rng.permutation(usable)[: int(rng.integers(2, 5))]]
        picked = tuple(c for c in found if c.key in chosen)
        if len(chosen) >= 2 and max(c.top_speed for c in picked) > needs.top_speed:
            return replace(rocket, combinations=picked)


def _combinations(
    rocket: Rocket, names: tuple[str, ...], configs: Mapping[str, float], needs: Needs
) -> list[Combination]:
    """Motors and configurations with enough speed off the rail and a delay near the coast time."""
    found = []
    for key in names:
        motor = motors()[key]
        early = np.linspace(0, 0.4, 41)
        push = float(np.interp(early, motor.time, motor.thrust).mean())
        for config, mass in configs.items():
            weight = 9.80665 * (mass + motor.total_mass)
            if not needs.lift[0] < push / weight < needs.lift[1]:
                continue
            flight = climb(Launch(rocket.frame, mass, motor, rocket.drag, Air(), rocket.rail))
            suitable = [d for d in motor.delays if -0.4 <= d - flight.coast <= 2.5]
            if suitable and flight.apogee > 60:
                delay = float(min(suitable, key=lambda d: abs(d - flight.coast - 0.5)))
                found.append(Combination(motor, key, config, mass, delay, flight.coast, flight.top_speed))
    return found
