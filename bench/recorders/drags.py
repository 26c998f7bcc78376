"""Cd from a single logged flight, `python -m bench.recorders.drags`: how much a log adds to the ten readouts.

A rocket of known mass and diameter flies once on a motor of the catalog, recorded by one of the subsonic recorders of
the bench. Its Cd follows from the log, and from the ten readouts of the same log as if they had been typed in. Printed
are the flights whose log shows the drag of the coast: the median error of Cd with the log and without, how often the
true Cd is within two standard deviations, and the median ratio of the two standard deviations. The rockets have one Cd
under power and in the coast, as in fieldkit; it rises with the Mach number.
"""

import argparse
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.recorders.flights import paths, sport_launch
from bench.recorders.judge import read
from bench.recorders.models import RECORDERS, Recorder
from bench.recorders.record import written
from bench.world import Launch
from fieldkit.analysis import columns
from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.motors import catalogue

TYPED: Mapping[str, object] = {"coast_drag": None, "burn_impulse": None, "sd": {}, "source": {}}
"""Changes that turn a logged flight into one whose readouts were typed in."""
DRAWS = 400
"""Draws of the posterior of Cd."""
WEIGHED_SD = 0.01
"""Standard deviation of the mass of a rocket that was weighed as flown. [1]"""


@dataclass(frozen=True, slots=True)
class Comparison:
    """One flight: error of log Cd and its standard deviation, from its log and from typed readouts [1], and the sensor
    that shows the drag of the coast, empty if none does."""

    sensor: str
    logged: tuple[float, float]
    typed: tuple[float, float]


def compared(name: str, count: int, seed: int, hyperprior: Hyperprior) -> Iterator[Comparison]:
    """Some flights on one recorder; logs without an apogee are left out."""
    recorder, rng = RECORDERS[name], np.random.default_rng([seed, zlib.crc32(name.encode())])
    launches = [_launch(rng, recorder) for _ in range(count)]
    for launch, path in zip(launches, paths(launches, rng), strict=True):
        try:
            fields, _ = columns(read(written(path, recorder, rng)), {})
        except FieldkitError:
            continue
        if "apogee" in fields:
            logged = _flight(launch).with_changes(**fields)
            sensor = logged.source.get("coast_drag", "") if logged.coast_drag else ""
            typed = logged.with_changes(**TYPED)
            yield Comparison(sensor, *(_cd_error(one, launch, hyperprior) for one in (logged, typed)))


def _launch(rng: np.random.Generator, recorder: Recorder) -> Launch:
    """A launch with one Cd, from a rail at the recorder's angle into the wind, if it has one."""
    launch = sport_launch(rng)
    launch = replace(launch, drag=replace(launch.drag, power_off=1.0))
    if not recorder.launch_angle:
        return launch
    return replace(launch, tilt=float(np.radians(recorder.launch_angle)), heading=np.pi)


def _flight(launch: Launch) -> Flight:
    """What a careful flyer records of a launch, without readouts; a rail of a few degrees is not noted."""
    return Flight(
        "1",
        "Bench",
        motor=launch.motor.printed(launch.delay),
        dry_mass=launch.dry_mass,
        diameter=launch.airframe.diameter,
        delay=launch.delay,
        site_elevation=launch.air.elevation,
        temperature=launch.air.temperature,
        wind=launch.air.wind,
        rail_length=launch.rail_length,
        rail_angle=launch.tilt if launch.heading == np.pi else None,
    )


def _cd_error(flown: Flight, launch: Launch, hyperprior: Hyperprior) -> tuple[float, float]:
    """Error of the posterior mean of log Cd, and its standard deviation. [1]"""
    motor = catalogue().find(launch.motor.printed(launch.delay))
    (forecast,) = predict([(flown, motor)], [(_flight(launch), motor)], Assumed(hyperprior=hyperprior), draws=DRAWS)
    log_cd = np.log(forecast.cd)
    return float(log_cd.mean() - np.log(launch.drag.cd)), float(log_cd.std())


def weighed(hyperprior: Hyperprior) -> Hyperprior:
    """The hyperprior for rockets whose recorded mass is the flown one: in the bench nothing is left unweighed."""
    exact = hyperprior.with_sds(mass__fleet=WEIGHED_SD, mass__rocket=WEIGHED_SD)
    return replace(exact, means={**exact.means, "mass": 0.0}, mean_sds={**exact.mean_sds, "mass": 0.0})


def line(name: str, flights: Sequence[Comparison]) -> str:
    """A row of the table: flights with drag, errors in percent, coverage, and the ratio of standard deviations."""
    shown = [one for one in flights if one.sensor]
    if not shown:
        return f"| {name} | {len(flights)} | 0 | | | | | |"
    logged, typed = (np.array(pairs) for pairs in ([one.logged for one in shown], [one.typed for one in shown]))
    errors = (f"{100 * np.median(np.abs(one[:, 0])):.1f}%" for one in (logged, typed))
    within = (f"{100 * np.mean(np.abs(one[:, 0]) <= 2 * one[:, 1]):.0f}%" for one in (logged, typed))
    ratio = np.median(logged[:, 1] / typed[:, 1])
    return f"| {name} | {len(flights)} | {len(shown)} | {' | '.join(errors)} | {' | '.join(within)} | {ratio:.2f} |"


def main(arguments: list[str] | None = None) -> int:
    """Print a table of the recorders, and totals by the sensor that shows the drag."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    asked = parser.parse_args(arguments)
    hyperprior, every = weighed(learned()), list[Comparison]()
    names = ("recorder", "flights", "with drag", "error", "typed", "within 2 sd", "typed", "sd / typed sd")
    sys.stdout.write(f"| {' | '.join(names)} |\n|{'---|' * len(names)}\n")
    for name in (one for one, recorder in RECORDERS.items() if not recorder.sonic and asked.only in one):
        found = list(compared(name, asked.flights, asked.seed, hyperprior))
        every += found
        sys.stdout.write(line(name, found) + "\n")
        sys.stdout.flush()
    for sensor in ("baro", "accel", "gps"):
        sys.stdout.write(line(f"all by {sensor}", [one for one in every if one.sensor == sensor]) + "\n")
    sys.stdout.write(line("all", every) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
