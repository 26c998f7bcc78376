"""Seasons and flights before effects are added.

A `Flown` is the true launch without scatter (`launch`), its random draws (`scatter`) and its record (`declared`).
Effects change the launch, not the draws and records.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import date, datetime, timedelta

import numpy as np

from bench.altimeter import Altimeter
from bench.rockets import Combination, Needs, Rocket, draw_rocket
from bench.world import Air, Launch

SITES = ("North Field", "Quarry", "Lake Bed", "Old Airstrip", "School", "Ridge")
ROCKETS = ("Astra", "Bolide", "Corvus", "Draco", "Ember", "Falcon", "Gannet", "Heron", "Ibis", "Juno")


@dataclass(frozen=True, slots=True)
class Scatter:
    """The random draws of one flight: factors, and a small launch angle."""

    thrust: float = 1.0
    stretch: float = 1.0
    drag: float = 1.0
    mass: float = 0.0
    """Error of the scale. [kg]"""
    delay: float = 1.0
    wind: float = 1.0
    launch_angle: tuple[float, float] = (0.0, 0.0)
    """Launch angle downwind and across. [rad]"""


@dataclass(frozen=True, slots=True)
class Flown:
    """One flight before its simulation."""

    launch: Launch
    scatter: Scatter
    when: datetime
    motor: str
    config: str
    site: str
    declared: Mapping[str, str | float]
    coast: float
    """Time from burnout to apogee without an earlier ejection. [s]"""
    gain: float = 1.0
    """Gain of the altimeter's barometer. [1]"""


@dataclass(frozen=True, slots=True)
class Season:
    """The flights of one rocket in time order; the last `future` of them are later flights for evaluation."""

    rocket: str
    flights: tuple[Flown, ...]
    future: int
    readouts: str
    conditions: str
    imperial: bool
    altimeter: Altimeter = Altimeter()


@dataclass(frozen=True, slots=True)
class _Day:
    date: date
    site: str
    elevation: float
    temperature: float
    qnh: float
    wind: float


def draw(rng: np.random.Generator, needs: Needs) -> Season:
    """A season: one rocket in one or two configurations, two to four motors, several days."""
    conditions = needs.conditions or str(rng.choice(["all", "wind", "none"], p=[0.45, 0.2, 0.35]))
    rocket = draw_rocket(rng, needs, conditions)
    history, future = int(rng.integers(16, 25)), int(rng.integers(8, 13))
    days = _days(rng, needs, conditions, history + future)
    flights = []
    for day, count in days:
        hours = np.sort(rng.uniform(9.5, 16.5, count))
        for hour in hours:
            flights.append(_flown(rng, needs, rocket, day, float(hour), conditions))
    return Season(
        rocket=str(rng.choice(ROCKETS)),
        flights=_all_seen(rng, flights, history, rocket),
        future=future,
        readouts=str(rng.choice(list(needs.readouts))),
        conditions=conditions,
        imperial=bool(rng.random() < 0.3),
    )


def scattered(flown: Flown) -> Launch:
    """The launch with its random draws."""
    launch, random_draw = flown.launch, flown.scatter
    launch_angle = (
        np.array([launch.tilt * np.cos(launch.heading), launch.tilt * np.sin(launch.heading)])
        + random_draw.launch_angle
    )
    motor = replace(
        launch.motor,
        time=launch.motor.time * random_draw.stretch,
        thrust=launch.motor.thrust * random_draw.thrust / random_draw.stretch,
    )
    return replace(
        launch,
        motor=motor,
        dry_mass=launch.dry_mass + random_draw.mass,
        drag=replace(launch.drag, cd=launch.drag.cd * random_draw.drag),
        air=replace(launch.air, wind=launch.air.wind * random_draw.wind),
        tilt=float(np.hypot(*launch_angle)),
        heading=float(np.arctan2(launch_angle[1], launch_angle[0])),
        delay=launch.delay * random_draw.delay,
    )


def _days(rng: np.random.Generator, needs: Needs, conditions: str, total: int) -> list[tuple[_Day, int]]:
    """Days with their weather and numbers of flights."""
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


def _flown(rng: np.random.Generator, needs: Needs, rocket: Rocket, day: _Day, hour: float, conditions: str) -> Flown:
    """One flight of a day."""
    choice = rocket.combinations[int(rng.integers(len(rocket.combinations)))]
    wind = day.wind * float(rng.uniform(0.7, 1.3))
    air = Air(
        elevation=day.elevation,
        temperature=day.temperature + float(0.8 * (hour - 13)) * (conditions == "all"),
        qnh=day.qnh,
        wind=wind,
    )
    mass = choice.mass * (1 + 0.005 * float(rng.standard_normal()))
    launch = Launch(
        airframe=rocket.frame,
        dry_mass=mass,
        motor=choice.motor,
        drag=rocket.drag,
        air=air,
        rail_length=rocket.rail,
        tilt=rocket.launch_angle,
        heading=float(rng.uniform(0, 2 * np.pi)),
        delay=choice.delay,
        chute_area=rocket.chute,
        opening=0.4,
    )
    return Flown(
        launch=launch,
        scatter=_drawn_scatter(rng, needs.scatter),
        when=datetime(day.date.year, day.date.month, day.date.day) + timedelta(minutes=round(hour * 60)),
        motor=choice.key,
        config=choice.config,
        site=day.site,
        declared=_declared(launch, choice, conditions),
        coast=choice.coast,
    )


def _drawn_scatter(rng: np.random.Generator, factor: float) -> Scatter:
    """Ordinary scatter: thrust 2.5%, drag 2%, scale 1 g, delay 7%, gusts 15%, a launch angle up to 2 degrees."""
    thrust, stretch, drag, mass, delay, wind = rng.standard_normal(6)
    launch_angle, way = float(np.radians(rng.uniform(0, 2))), float(rng.uniform(0, 2 * np.pi))
    return Scatter(
        thrust=1 + 0.025 * factor * float(thrust),
        stretch=1 + 0.015 * float(stretch),
        drag=1 + 0.02 * factor * float(drag),
        mass=0.001 * float(mass),
        delay=1 + 0.07 * float(np.clip(delay, -2, 2)),
        wind=max(0.0, 1 + 0.15 * float(wind)),
        launch_angle=(launch_angle * float(np.cos(way)), launch_angle * float(np.sin(way))),
    )


def _declared(launch: Launch, choice: Combination, conditions: str) -> dict[str, str | float]:
    """The flyer's record, in the units of the flight table."""
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


def _all_seen(rng: np.random.Generator, flights: list[Flown], history: int, rocket: Rocket) -> tuple[Flown, ...]:
    """The flights, with every motor in every configuration flown about twice in the history."""
    for config in sorted({c.config for c in rocket.combinations}):
        for key in sorted({c.key for c in rocket.combinations}):
            seen = [f for f in flights[:history] if (f.config, f.motor) == (config, key)]
            if len(seen) >= 2:
                continue
            choice = next(c for c in rocket.combinations if (c.config, c.key) == (config, key))
            for place in rng.choice(history, 2, replace=False):
                flights[place] = _swap(flights[int(place)], choice)
    return tuple(flights)


def _swap(flown: Flown, choice: Combination) -> Flown:
    """The same flight on another motor or in another configuration."""
    launch = replace(flown.launch, dry_mass=choice.mass, motor=choice.motor, delay=choice.delay)
    row = dict(flown.declared) | {
        "motor": launch.motor.printed(choice.delay),
        "dry_mass_g": round(launch.dry_mass * 1000),
    }
    return replace(flown, launch=launch, declared=row, motor=choice.key, config=choice.config, coast=choice.coast)
