"""Random rockets, motors, days and weather for training the history network."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Any

import numpy as np

from fieldkit.flight import Flight
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.motors import Found, Motor, catalogue
from fieldkit.physics.atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

CLASSES = ("1/8A", "1/4A", "1/2A", "A", "B", "C", "D", "E", "F", "G", "H", "I")
"""Impulse classes of the motors flown."""
MIN_MOTOR_DIAMETER = 0.008
"""Motors up to this diameter cannot lift an altimeter. [m]"""
HELD_OUT = "Quest"
"""The manufacturer whose motors are held out of training and used for evaluation."""
MAX_FLIGHTS = 60
"""Maximum number of flights in a history. [1]"""
MOTOR_COUNTS = (0.25, 0.3, 0.2, 0.1, 0.06, 0.04, 0.03, 0.02)
"""Probabilities of one, two, ... motor types. [1]"""
CONFIG_COUNTS = (0.65, 0.25, 0.1)
SITE_COUNTS = (0.5, 0.3, 0.2)
"""Probabilities of one, two or three configurations, and sites. [1]"""
DECLARED_SETS = ("all", "temperature and wind", "only wind", "nothing")
DECLARED_ODDS = (0.35, 0.1, 0.2, 0.35)
"""Conditions that a flyer may record, and the probability of each set. [1]"""
READOUT_SETS = (
    ("apogee",),
    ("apogee", "top_speed", "coast_to_apogee"),
    ("apogee", "top_speed", "burn_time", "peak_accel", "coast_to_apogee", "apogee_to_eject"),
)
READOUT_ODDS = (0.35, 0.25, 0.2, 0.2)
"""Probabilities of each of `READOUT_SETS`, and of the apogee with each readout of the last set at even odds. [1]"""
OF_YEARS, PAUSE, PAUSES = 0.3, 0.2, (150, 1000)
"""Probability that a rocket is flown over several years, probability of a pause after each of its days, and bounds of
the pause. [1], [1], [d]"""
THRUST_TO_WEIGHT = (3.5, 25.0)
"""Bounds of the first motor's average thrust over the weight at lift-off, unless the rocket would then be too light for
its motor. [1]"""
WORKABLE_THRUST_TO_WEIGHT = (2.8, 40.0)
"""Bounds of the same ratio of the other motors. [1]"""
LOTS_RECORDED, NEW_LOT = 0.2, 0.15
"""Probability that a flyer records the lots of motors, and that a motor is the first of a new lot. [1]"""
SENSORS, SENSOR_ODDS = ("", "baro", "accel"), (0.75, 0.15, 0.1)
"""Sources of the readouts of a rocket, empty for readouts that were typed, and their probabilities. [1]"""
SD_RECORDED = {"": 0.1, "baro": 0.9, "accel": 0.9}
"""Probability that the standard deviations of readouts are recorded, by source. [1]"""
RECORDED_SDS = (0.2, 2.0)
"""Bounds of recorded standard deviations, relative to the hyperprior's. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class Stock:
    """Motors to draw from, with the figures that decide which fit the same rocket: average thrust [N], loaded mass
    [kg], diameter [m], and the odds of drawing it [1]."""

    motors: tuple[Motor, ...]
    thrust: Float[Array, "motor"]
    loaded: Float[Array, "motor"]
    diameter: Float[Array, "motor"]
    odds: Float[Array, "motor"]


def split_motors() -> tuple[list[Motor], list[Motor]]:
    """The motors up to class I of all manufacturers but the held-out one, and the motors of that one."""
    flown = [one for one in catalogue().motors if one.impulse_class in CLASSES and one.diameter > MIN_MOTOR_DIAMETER]
    return [one for one in flown if one.maker != HELD_OUT], [one for one in flown if one.maker == HELD_OUT]


def stock(motors: Sequence[Motor]) -> Stock:
    """The motors, with equal odds for every impulse class, and for every motor in it."""
    names = np.array([motor.impulse_class for motor in motors])
    weight = 1.0 / np.array([(names == name).sum() for name in names])
    return Stock(
        tuple(motors),
        np.array([motor.average_thrust for motor in motors]),
        np.array([motor.loaded_mass for motor in motors]),
        np.array([motor.diameter for motor in motors]),
        weight / weight.sum(),
    )


@dataclass(frozen=True, slots=True)
class DrawnRocket:
    """Flights without readouts in the order flown, the last one planned, with their motors; and for the flown ones, the
    names of the readouts each will have, and whether it is used in the fit.

    `source` is the source of all readouts, one of `SENSORS`. `sds` are their recorded standard deviations relative to
    the hyperprior's, nan if they are not recorded. [1]
    """

    flights: tuple[Flight, ...]
    found: tuple[Found, ...]
    shows: tuple[tuple[str, ...], ...]
    used_in_fit: tuple[bool, ...]
    source: str
    sds: Float[Array, "flight readout"]


def draw_rocket(rng: np.random.Generator, choice: Stock, count: int | None = None) -> DrawnRocket:
    """One rocket with `count` flights and a plan; by default the count is 1 to `MAX_FLIGHTS`, uniform in the
    logarithm."""
    if count is None:
        count = int(np.clip(np.rint(np.exp(rng.uniform(np.log(0.6), np.log(MAX_FLIGHTS + 0.4)))), 1, MAX_FLIGHTS))
    motors, mass = _motors(rng, choice, count)
    configs = _masses(rng, mass, min(count, 1 + int(rng.choice(len(CONFIG_COUNTS), p=CONFIG_COUNTS))))
    widest = max(motor.diameter for motor in motors)
    slim, wide = diameter_range(widest, mass)
    diameter = float(np.exp(rng.uniform(np.log(slim), np.log(wide))))
    delays = {(i, name): _delay(rng, motor, own, diameter) for i, motor in enumerate(motors) for name, own in configs}
    declared = str(rng.choice(DECLARED_SETS, p=DECLARED_ODDS))
    weighed, known = bool(rng.uniform() < 0.7), bool(rng.uniform() < 0.85)
    days = _days(rng, count, declared)
    flights: list[Flight] = []
    found: list[Found] = []
    for number, day in enumerate(days):
        again = number == count and rng.uniform() < 0.3
        motor = _like_last(found, motors) if again else int(rng.integers(len(motors)))
        if number == count and rng.uniform() < 0.2:
            motor = -1
        name, own = configs[int(rng.integers(len(configs)))]
        kind = _another(rng, choice, motors, own) if motor < 0 else motors[motor]
        delay = delays.get((motor, name), np.nan) if motor >= 0 else _delay(rng, kind, own, diameter)
        flights.append(
            replace(
                day,
                flight_id=f"{number + 1}",
                config=name,
                motor=kind.name,
                dry_mass=own * float(np.exp(0.006 * rng.normal())) if weighed else own,
                diameter=diameter if known else None,
            )
        )
        found.append(Found(kind, delay if np.isfinite(delay) else None))
    clean = rng.uniform(size=count) > (0.06 if rng.uniform() < 0.3 else 0.0)
    source = str(rng.choice(SENSORS, p=SENSOR_ODDS))
    return DrawnRocket(
        tuple(_with_lots(rng, flights) if rng.uniform() < LOTS_RECORDED else flights),
        tuple(found),
        _shows(rng, count),
        tuple(bool(x) for x in clean),
        source,
        _recorded_sds(rng, count + 1, SD_RECORDED[source]),
    )


def _with_lots(rng: np.random.Generator, flights: Sequence[Flight]) -> list[Flight]:
    """Flights with the lots of their motors, numbered for each type in the order flown."""
    last: dict[str, int] = {}
    found = []
    for flight in flights:
        last[flight.motor] = last.get(flight.motor, 1) + int(rng.uniform() < NEW_LOT)
        found.append(replace(flight, extra={"motor_lot": str(last[flight.motor])}))
    return found


def _recorded_sds(rng: np.random.Generator, count: int, odds: float) -> Float[Array, "flight readout"]:
    """Standard deviations of the readouts of flights relative to the hyperprior's, nan if they are not recorded: a
    level for each readout, and a little variation among flights."""
    low, high = np.log(RECORDED_SDS)
    level = rng.uniform(low, high, len(OBSERVED_READOUTS))
    sds = np.exp(level + 0.2 * rng.normal(size=(count, len(OBSERVED_READOUTS))))
    return sds if rng.uniform() < odds else np.full_like(sds, np.nan)


def _motors(rng: np.random.Generator, choice: Stock, count: int) -> tuple[list[Motor], float]:
    """Motor types for one rocket, and its dry mass. [kg]"""
    first = int(rng.choice(len(choice.motors), p=choice.odds))
    lift = float(np.exp(rng.uniform(*np.log(THRUST_TO_WEIGHT))))
    loaded = choice.loaded[first]
    mass = float(max(choice.thrust[first] / (lift * GRAVITY) - loaded, 0.35 * loaded, 0.008))
    wanted = min(count, 1 + int(rng.choice(len(MOTOR_COUNTS), p=MOTOR_COUNTS)))
    others = np.flatnonzero(_can_fly(choice, mass, choice.diameter[first]))
    others = others[others != first]
    more: list[int] = []
    if len(others) and wanted > 1:
        more = rng.choice(others, min(wanted - 1, len(others)), replace=False).tolist()
    return [choice.motors[i] for i in (first, *more)], mass


def _can_fly(choice: Stock, mass: float, diameter: float) -> Flags:
    lift = choice.thrust / ((mass + choice.loaded) * GRAVITY)
    low, high = WORKABLE_THRUST_TO_WEIGHT
    return np.asarray((lift > low) & (lift < high) & (choice.diameter <= diameter) & (choice.diameter > 0.6 * diameter))


def _another(rng: np.random.Generator, choice: Stock, motors: Sequence[Motor], mass: float) -> Motor:
    """A motor that is not among the rocket's motors, if one fits, or else its first one."""
    free = [i for i in np.flatnonzero(_can_fly(choice, mass, motors[0].diameter)) if choice.motors[i] not in motors]
    return choice.motors[int(rng.choice(free))] if free else motors[0]


def _like_last(found: Sequence[Found], motors: Sequence[Motor]) -> int:
    return next(i for i, motor in enumerate(motors) if motor is found[-1].motor)


def _masses(rng: np.random.Generator, mass: float, count: int) -> list[tuple[str, float]]:
    ratios = [1.0, *np.exp(0.15 * rng.normal(size=count - 1))]
    return [("ABC"[number], mass * float(ratio)) for number, ratio in enumerate(ratios)]


def _delay(rng: np.random.Generator, motor: Motor, mass: float, diameter: float) -> float:
    """A delay on sale, mostly near the expected coast time; nan for none. [s]"""
    sold = np.array([delay for delay in motor.delays if np.isfinite(delay)])
    if not len(sold):
        return float("nan")
    coast = coast_time(motor, mass, 0.6 * np.pi / 4 * diameter**2)
    return float(sold[int(np.argmax(-np.abs(sold - coast) + rng.gumbel(size=len(sold))))])


def diameter_range(motor_diameter: float, dry_mass: float) -> tuple[float, float]:
    """Smallest and largest body diameter for a motor [m] and a mass [kg]. [m]

    The body is at least as wide as the motor and a wall, at most five motors wide, and no lighter than the lightest
    kits of its diameter: 7 g at 20 mm, growing with the square to 105 g at 77 mm. The largest diameter is at least 1.3
    times the smallest.

    Derivation: the mass of the lightest tubes and nose cones grows with their surface, the square of the diameter.
    """
    slim = max(0.013, motor_diameter + 0.001)
    return slim, max(min(0.1, 5 * motor_diameter, 0.02 * np.sqrt(dry_mass / 0.007)), 1.3 * slim)


def coast_time(motor: Motor, dry_mass: float, drag_area: float) -> float:
    """Time from burnout to apogee of a vertical flight at constant thrust, mass and air density (1.2 kg/m^3), for a dry
    mass [kg] and a drag area [m^2]. [s]

    Source: Fehskens and Malewicki (Malewicki, Model Rocket Altitude Prediction Charts, 1967).
    """
    empty = dry_mass + motor.casing_mass
    mass = empty + 0.5 * motor.propellant_mass
    push = motor.total_impulse / motor.burn_time
    net = max(push - mass * GRAVITY, 0.1 * push)
    drag = 0.5 * 1.2 * drag_area
    limit = np.sqrt(net / drag)
    speed = limit * np.tanh(min(drag * limit * motor.burn_time / mass, 300.0))
    drag_to_weight = drag * speed**2 / (empty * GRAVITY)
    return float(np.sqrt(empty / (GRAVITY * drag)) * np.arctan(np.sqrt(drag_to_weight)))


def _days(rng: np.random.Generator, count: int, declared: str) -> list[Flight]:
    """Flights and a plan with site, time, and the conditions that `declared`, one of `DECLARED_SETS`, names."""
    sites = 1 + int(rng.choice(len(SITE_COUNTS), p=SITE_COUNTS))
    heights = rng.choice([200.0, 800.0, 1800.0], p=[0.7, 0.2, 0.1]) * rng.uniform(size=sites)
    windy = 2.5 * float(np.exp(0.5 * rng.normal()))
    when, flights, number = datetime(2024, 4, 1) + timedelta(days=int(rng.integers(200))), [], 0
    dated, length = bool(rng.uniform() < 0.9), float(np.exp(rng.uniform(np.log(0.9), np.log(2.5))))
    slanted = bool(declared == "all" and rng.uniform() < 0.3)
    pause = PAUSE if rng.uniform() < OF_YEARS else 0.0
    while number < count + 1:
        many = int(rng.integers(1, 7))
        hours = np.sort(rng.uniform(9.0, 17.0, many))
        site = int(rng.integers(sites))
        temperature = 288.0 + 8.0 * rng.normal() - 0.006 * heights[site]
        wind = rng.rayleigh(windy / 1.25)
        for hour in hours[: count + 1 - number]:
            known: dict[str, Any] = {}
            if declared != "nothing":
                known["wind"] = round(2 * max(wind * float(np.exp(0.25 * rng.normal())), 0.0)) / 2
            if declared in ("all", "temperature and wind"):
                known["temperature"] = float(temperature + 0.8 * (hour - 13.0))
            if declared == "all":
                known |= {"site_elevation": float(heights[site]), "rail_length": length}
                known["pressure"] = float(101325.0 + 600.0 * rng.normal())
            if slanted:
                known["rail_angle"] = float(np.radians(abs(np.rint(4.0 * rng.normal()))))
            at = when + timedelta(minutes=round(hour * 60))
            flights.append(Flight(rocket="drawn", site=f"site {site}", date_time=at if dated else None, **known))
            number += 1
        when += timedelta(days=int(rng.integers(*(PAUSES if rng.uniform() < pause else (3, 40)))))
    return flights


def _shows(rng: np.random.Generator, count: int) -> tuple[tuple[str, ...], ...]:
    """The names of the readouts that each flown flight has."""
    which = int(rng.choice(len(READOUT_ODDS), p=READOUT_ODDS))
    whole: tuple[str, ...] = READOUT_SETS[min(which, len(READOUT_SETS) - 1)]
    if which == len(READOUT_SETS):
        whole = tuple(name for name in whole if name == "apogee" or rng.uniform() < 0.5)
    gaps = 0.2 if rng.uniform() < 0.3 else 0.0
    missed = 0.05 if gaps else 0.0
    return tuple(
        tuple(name for name in whole if rng.uniform() >= (missed if name == "apogee" else gaps)) for _ in range(count)
    )
