"""Rockets, seasons and flights to put effects into: everything honest, nothing hidden yet.

A `Flown` is a flight as planned by an all-knowing flyer (`launch`), the luck it meets (`scatter`) and what is
written down of it (`declared`). Effects bend the launch and leave luck and paper alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date, datetime, timedelta

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
SITES = ("North Field", "Quarry", "Lake Bed", "Old Airstrip", "School", "Ridge")
ROCKETS = ("Astra", "Bolide", "Corvus", "Draco", "Ember", "Falcon", "Gannet", "Heron", "Ibis", "Juno")


@dataclass(frozen=True, slots=True)
class Needs:
    """What a scenario asks of the rocket and the season before anything is bent."""

    classes: tuple[str, ...] = ("tiny", "small", "medium", "medium", "large", "large", "heavy")
    configs: int = 0
    """Exactly so many; 0: one or two."""
    sites: int = 0
    """At least so many; 0: one to three."""
    margin: tuple[float, float] = (1.2, 1.8)
    """Static margin on the pad. [calibre]"""
    rail: tuple[float, float] = (1.5, 2.4)
    conditions: str = ""
    """`all`, `wind` or `none` of the conditions are declared; empty: by chance."""
    readouts: tuple[str, ...] = ("all", "all", "three", "apogee")
    """What may be read: all ten, apogee with speed and coast, or the apogee alone."""
    scatter: float = 1.0
    """Factor on the scatter of thrust and drag."""
    lift: tuple[float, float] = (5.0, 40.0)
    """Thrust over weight in the first 0.4 s."""
    cd: tuple[float, float] = (0.38, 0.75)
    top_speed: float = 0.0
    """That the fastest motor must exceed. [m/s]"""
    high: float = 1500.0
    """Elevation up to which sites lie where all conditions are declared. [m]"""


@dataclass(frozen=True, slots=True)
class Scatter:
    """The luck of one flight: factors, and a small lean of the rail."""

    thrust: float = 1.0
    stretch: float = 1.0
    drag: float = 1.0
    mass: float = 0.0
    """Error of the scale. [kg]"""
    delay: float = 1.0
    wind: float = 1.0
    lean: tuple[float, float] = (0.0, 0.0)
    """Downwind and across. [rad]"""


@dataclass(frozen=True, slots=True)
class Flown:
    """One flight before it is flown."""

    launch: Launch
    scatter: Scatter
    when: datetime
    motor: str
    config: str
    site: str
    declared: Mapping[str, str | float]
    coast: float
    """From burnout to apogee, if nothing ejects before. [s]"""
    gain: float = 1.0
    """Of the altimeter's barometer."""


@dataclass(frozen=True, slots=True)
class Season:
    """The flights of one rocket in time order; the last `future` of them are yet to come."""

    rocket: str
    flights: tuple[Flown, ...]
    future: int
    readouts: str
    conditions: str
    imperial: bool


@dataclass(frozen=True, slots=True)
class _Day:
    date: date
    site: str
    elevation: float
    temperature: float
    qnh: float
    wind: float


@dataclass(frozen=True, slots=True)
class _Combination:
    """A motor in a configuration, with the delay a careful flyer picks for it."""

    motor: Motor
    key: str
    config: str
    mass: float
    delay: float
    coast: float
    top_speed: float


@dataclass(frozen=True, slots=True)
class _Plan:
    frame: Airframe
    drag: Drag
    rail: float
    chute: float
    lean: float
    """Nominal tilt of the rail, declared. [rad]"""
    combinations: tuple[_Combination, ...] = field(default=())


def draw(rng: np.random.Generator, needs: Needs) -> Season:
    """A season: one rocket in one or two configurations, two to four motors, several days."""
    conditions = needs.conditions or str(rng.choice(["all", "wind", "none"], p=[0.45, 0.2, 0.35]))
    plan = _plan(rng, needs, conditions)
    history, future = int(rng.integers(16, 25)), int(rng.integers(8, 13))
    days = _days(rng, needs, conditions, history + future)
    flights = []
    for day, count in days:
        hours = np.sort(rng.uniform(9.5, 16.5, count))
        for hour in hours:
            flights.append(_flown(rng, needs, plan, day, float(hour), conditions))
    return Season(
        rocket=str(rng.choice(ROCKETS)),
        flights=_all_seen(rng, flights, history, plan),
        future=future,
        readouts=str(rng.choice(list(needs.readouts))),
        conditions=conditions,
        imperial=bool(rng.random() < 0.3),
    )


def scattered(flown: Flown) -> Launch:
    """The launch as luck has it."""
    launch, luck = flown.launch, flown.scatter
    lean = np.array([launch.tilt * np.cos(launch.heading), launch.tilt * np.sin(launch.heading)]) + luck.lean
    motor = replace(
        launch.motor,
        time=launch.motor.time * luck.stretch,
        thrust=launch.motor.thrust * luck.thrust / luck.stretch,
    )
    return replace(
        launch,
        motor=motor,
        dry_mass=launch.dry_mass + luck.mass,
        drag=replace(launch.drag, cd=launch.drag.cd * luck.drag),
        air=replace(launch.air, wind=launch.air.wind * luck.wind),
        tilt=float(np.hypot(*lean)),
        heading=float(np.arctan2(lean[1], lean[0])),
        delay=launch.delay * luck.delay,
    )


def _plan(rng: np.random.Generator, needs: Needs, conditions: str) -> _Plan:
    """A rocket with at least two motors that lift it well and have a delay that suits it."""
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
        plan = _Plan(
            frame=replace(frame, dry_cg=cg),
            drag=Drag(float(rng.uniform(*needs.cd))),
            rail=float(rng.uniform(*needs.rail)),
            chute=mass * float(rng.uniform(0.35, 0.9)),
            lean=float(np.radians(rng.choice([0, 0, 0, 3, 5]))) if conditions == "all" else 0.0,
        )
        found = _combinations(plan, names, configs, needs)
        usable = sorted({c.key for c in found if {d.config for d in found if d.key == c.key} == set(configs)})
        chosen = [str(key) for key in rng.permutation(usable)[: int(rng.integers(2, 5))]]
        picked = tuple(c for c in found if c.key in chosen)
        if len(chosen) >= 2 and max(c.top_speed for c in picked) > needs.top_speed:
            return replace(plan, combinations=picked)


def _combinations(
    plan: _Plan, names: tuple[str, ...], configs: Mapping[str, float], needs: Needs
) -> list[_Combination]:
    """Motors and configurations that leave the rail well and find a delay near the coast they need."""
    found = []
    for key in names:
        motor = motors()[key]
        early = np.linspace(0, 0.4, 41)
        push = float(np.interp(early, motor.time, motor.thrust).mean())
        for config, mass in configs.items():
            weight = 9.80665 * (mass + motor.total_mass)
            if not needs.lift[0] < push / weight < needs.lift[1]:
                continue
            flight = climb(Launch(plan.frame, mass, motor, plan.drag, Air(), plan.rail))
            fitting = [d for d in motor.delays if -0.4 <= d - flight.coast <= 2.5]
            if fitting and flight.apogee > 60:
                delay = float(min(fitting, key=lambda d: abs(d - flight.coast - 0.5)))
                found.append(_Combination(motor, key, config, mass, delay, flight.coast, flight.top_speed))
    return found


def _days(rng: np.random.Generator, needs: Needs, conditions: str, total: int) -> list[tuple[_Day, int]]:
    """Flying days with their weather, and how many flights each has."""
    number = max(needs.sites, int(rng.integers(1, 4)))
    names = [str(s) for s in rng.choice(SITES, number, replace=False)]
    high = needs.high if conditions == "all" else 120.0
    elevations = {name: float(round(rng.uniform(0, high))) for name in names}
    days: list[tuple[_Day, int]] = []
    when, left, turn = date(2023, 3, 1) + timedelta(days=int(rng.integers(0, 200))), total, 0
    while left > 0:
        count = min(left, int(rng.integers(3, 7)))
        site = names[turn % number] if turn < 2 * number else str(rng.choice(names))
        standard = 288.15 - 0.0065 * elevations[site]
        if conditions == "all":
            kelvin, qnh = standard + rng.uniform(-12, 18), 101325 + 700 * rng.standard_normal()
        else:
            kelvin, qnh = standard + 1.5 * rng.standard_normal(), 101325 + 250 * rng.standard_normal()
        wind = float(rng.uniform(0, 1.2 if conditions == "none" else 3.0))
        days.append((_Day(when, site, elevations[site], float(kelvin), float(qnh), wind), count))
        when, left, turn = when + timedelta(days=int(rng.integers(6, 45))), left - count, turn + 1
    return days


def _flown(rng: np.random.Generator, needs: Needs, plan: _Plan, day: _Day, hour: float, conditions: str) -> Flown:
    """One flight of a day."""
    choice = plan.combinations[int(rng.integers(len(plan.combinations)))]
    wind = day.wind * float(rng.uniform(0.7, 1.3))
    air = Air(
        elevation=day.elevation,
        temperature=day.temperature + float(0.8 * (hour - 13)) * (conditions == "all"),
        qnh=day.qnh,
        wind=wind,
    )
    mass = choice.mass * (1 + 0.005 * float(rng.standard_normal()))
    launch = Launch(
        airframe=plan.frame,
        dry_mass=mass,
        motor=choice.motor,
        drag=plan.drag,
        air=air,
        rail_length=plan.rail,
        tilt=plan.lean,
        heading=float(rng.uniform(0, 2 * np.pi)),
        delay=choice.delay,
        chute_area=plan.chute,
        opening=0.4,
    )
    return Flown(
        launch=launch,
        scatter=_luck(rng, needs.scatter),
        when=datetime(day.date.year, day.date.month, day.date.day) + timedelta(minutes=round(hour * 60)),
        motor=choice.key,
        config=choice.config,
        site=day.site,
        declared=_declared(launch, choice, conditions),
        coast=choice.coast,
    )


def _luck(rng: np.random.Generator, factor: float) -> Scatter:
    """Honest scatter: thrust 2.5 %, drag 2 %, scale 1 g, delay 7 %, gusts 15 %, a lean up to 2 degrees."""
    thrust, stretch, drag, mass, delay, wind = rng.standard_normal(6)
    lean, way = float(np.radians(rng.uniform(0, 2))), float(rng.uniform(0, 2 * np.pi))
    return Scatter(
        thrust=1 + 0.025 * factor * float(thrust),
        stretch=1 + 0.015 * float(stretch),
        drag=1 + 0.02 * factor * float(drag),
        mass=0.001 * float(mass),
        delay=1 + 0.07 * float(np.clip(delay, -2, 2)),
        wind=max(0.0, 1 + 0.15 * float(wind)),
        lean=(lean * float(np.cos(way)), lean * float(np.sin(way))),
    )


def _declared(launch: Launch, choice: _Combination, conditions: str) -> dict[str, str | float]:
    """What the flyer writes down, in the units of the flight table."""
    row: dict[str, str | float] = {
        "motor": launch.motor.printed(choice.delay),
        "dry_mass_g": round(launch.dry_mass * 1000),
        "diameter_mm": round(launch.airframe.diameter * 1000, 1),
    }
    if conditions in ("all", "wind"):
        row["wind_mps"] = round(launch.air.wind * 2) / 2
    if conditions == "all":
        row["site_elevation_m"] = round(launch.air.elevation)
        row["temperature_c"] = round(launch.air.temperature - 273.15)
        row["pressure_hpa"] = round(launch.air.qnh / 100)
        row["rail_length_m"] = round(launch.rail_length, 2)
        row["rail_angle_deg"] = round(float(np.degrees(launch.tilt)))
    return row


def _all_seen(rng: np.random.Generator, flights: list[Flown], history: int, plan: _Plan) -> tuple[Flown, ...]:
    """The flights, with every motor in every configuration flown about twice in the history."""
    for config in sorted({c.config for c in plan.combinations}):
        for key in sorted({c.key for c in plan.combinations}):
            seen = [f for f in flights[:history] if (f.config, f.motor) == (config, key)]
            if len(seen) >= 2:
                continue
            choice = next(c for c in plan.combinations if (c.config, c.key) == (config, key))
            for place in rng.choice(history, 2, replace=False):
                flights[place] = _swap(flights[int(place)], choice)
    return tuple(flights)


def _swap(flown: Flown, choice: _Combination) -> Flown:
    """The same flight on another motor or in another configuration."""
    launch = replace(flown.launch, dry_mass=choice.mass, motor=choice.motor, delay=choice.delay)
    row = dict(flown.declared) | {
        "motor": launch.motor.printed(choice.delay),
        "dry_mass_g": round(launch.dry_mass * 1000),
    }
    return replace(flown, launch=launch, declared=row, motor=choice.key, config=choice.config, coast=choice.coast)
