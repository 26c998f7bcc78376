"""Small OpenRocket designs written for the tests, from the figures of the examples that OpenRocket 24.12 comes with.

`examples.csv` has those figures: 17 designs, 60 simulations. A design here has the diameter of its example, its mass as
a weighed stage, and for every simulation a stored flight with its top speed, times and Cd, written as that version
does: three decimals. Nothing else is taken from the example.
"""

import csv
import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

TABLE = Path(__file__).with_name("examples.csv")
TYPES = (
    "Time,Altitude,Vertical velocity,Total velocity,Mass,Motor mass,Drag force,Drag coefficient,"
    "Reference length,Reference area,Air density"
)
DENSITY, MOTOR_MASS = 1.2, 0.05
WOBBLE, SLOW = 0.01, 0.2
"""Decrease of the Cd of a coast with speed, and its increase near apogee. [1]"""

Example = dict[str, str]


def examples() -> list[tuple[str, list[Example]]]:
    """The designs of the table by name, with their simulations."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return [(name, list(rows)) for name, rows in groupby(csv.DictReader(file), lambda row: row["design"])]


def decimals(value: float) -> str:
    """A number as version 24.12 stores it: three decimals, exponential if it is small or large."""
    if value and (abs(value) < 0.001 or abs(value) >= 10_000):
        return f"{value:.3E}".replace("E-0", "E-").replace("E+0", "E")
    return f"{value:.3f}".rstrip("0").rstrip(".") or "0"


def design(name: str, flown: Sequence[Example], *, dry_mass: float, reference: str = "maximum") -> bytes:
    """A design as plain XML in bytes: a nose and a tube with weighed mass, and its stored simulations."""
    radius = float(flown[0]["diameter_mm"]) / 2e3
    return f"""<?xml version="1.0" encoding="utf-8"?><openrocket version="1.10" creator="OpenRocket 24.12"><rocket>
<name>{name}</name><referencetype>{reference}</referencetype><subcomponents><stage><name>Stage</name>
<overridemass>{dry_mass}</overridemass><overridesubcomponentsmass>true</overridesubcomponentsmass><subcomponents>
<nosecone><name>Nose</name><length>0.1</length><thickness>0.001</thickness><shape>ogive</shape>
<aftradius>auto {radius}</aftradius></nosecone><bodytube><name>Body</name><length>0.4</length>
<thickness>0.001</thickness><radius>{radius}</radius></bodytube></subcomponents></stage></subcomponents></rocket>
<simulations>{"".join(simulation(row, dry_mass) for row in flown)}</simulations></openrocket>""".encode()


def simulation(row: Example, dry_mass: float) -> str:
    """A stored flight: speed rises linearly to its maximum and falls linearly to apogee, with the last burnout between
    them."""
    burnout, apogee, top = (float(row[key]) for key in ("burnout_s", "to_apogee_s", "top_speed_mps"))
    time = np.concatenate([np.linspace(0, burnout, 15), np.linspace(burnout, apogee, 60)[1:]])
    speed = np.interp(time, [0, burnout, apogee], [0, top, 0])
    points = "".join(f"<datapoint>{','.join(one)}</datapoint>" for one in _points(row, time, speed, dry_mass))
    return f"""<simulation status="uptodate"><name>{row["motors"]}</name><conditions><configid>x</configid>
<launchrodlength>{row["rod_m"]}</launchrodlength></conditions><flightdata maxaltitude="{row["apogee_m"]}"
maxvelocity="{top}"><databranch name="Stage" types="{TYPES}"><event time="0.3" type="burnout"/>
<event time="{burnout}" type="burnout"/><event time="{apogee}" type="apogee"/>
<event time="{apogee + 9}" type="burnout"/>{points}</databranch></flightdata></simulation>"""


def _points(row: Example, time: Sequence[float], speed: Sequence[float], dry_mass: float) -> Iterator[list[str]]:
    diameter, burnout, top = (float(row[key]) for key in ("diameter_mm", "burnout_s", "top_speed_mps"))
    area = math.pi / 4 * (diameter / 1e3) ** 2
    for t, v in zip(time, speed, strict=True):
        middle = 0.65 * top  # of the coast above 30% of the top speed
        cd = float(row["cd_thrust"]) if t <= burnout else float(row["cd_coast"]) * (1 + WOBBLE * (1 - v / middle))
        cd *= 1 + SLOW if t > burnout and v < 0.3 * top else 1
        motor = MOTOR_MASS * max(1 - t / burnout, 0.4)
        force = cd * DENSITY / 2 * v**2 * area
        yield [
            *map(decimals, (t, 10 * t, v, v, dry_mass + motor, motor, force, cd, diameter / 1e3)),
            row["stored_area_m2"],
            decimals(DENSITY),
        ]
