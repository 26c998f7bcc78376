"""Descents on one device and on two, `python -m bench.recorders.descents`: how often a log shows the right number.

Each flight of `bench.recorders.flights` falls from its apogee on a parachute, a streamer, or on a drogue or streamer
and then a main, in gusts and thermals, and is recorded by the same recorders. Printed is how many seem to be on two
devices, and how often the measured speeds and heights are within two standard deviations of the truth.
"""

import argparse
import sys
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from bench.air import GRAVITY
from bench.recorders.flights import GUST, GUST_TIME, STEP, Path, draw
from bench.recorders.judge import read
from bench.recorders.models import RECORDERS, Recorder
from bench.recorders.record import written
from fieldkit.errors import FieldkitError
from fieldkit.shapes import Array, Float

THERMAL, THERMAL_TIME = 1.0, 40.0
"""Standard deviation of the vertical wind in thermals [m/s], and the time that a descent spends in one [s]."""
SCALE_HEIGHT = 10400.0
"""Scale height of the density of the air near the ground: the temperature falls with height too. [m]"""
SHORTEST, OPEN = 4.0, 2.0
"""Shortest descent at the drogue's own speed [s], and the time after which a main has slowed the rocket [s]."""
RECORDER_NAMES = ("1 Hz", "5 Hz feet", "20 Hz", "20 Hz noisy", "pressure 10 Hz", "satellites 5 Hz", "accel 100 Hz")
"""Recorders on which descents are tried."""


@dataclass(frozen=True, slots=True)
class Kind:
    """Devices: lowest and highest speed of the first and of a main near the ground [m/s], heights at which the main is
    released [m], times that devices take to open [s], of a charge after apogee [s], and from the log's end to landing,
    negative if it ends after it [s]."""

    first: tuple[float, float]
    main: tuple[float, float] | None = None
    released: tuple[float, float] = (90.0, 250.0)
    opening: tuple[float, float] = (0.3, 0.8)
    late: tuple[float, float] = (0.0, 2.0)
    cut: float = 0.0


KINDS: Mapping[str, Kind] = {
    "parachute": Kind((3.0, 9.0)),
    "parachute, 3 to 6 s late": Kind((3.0, 9.0), late=(3.0, 6.0)),
    "streamer": Kind((7.0, 15.0)),
    "drogue alone": Kind((15.0, 35.0)),
    "parachute, cut off 10 s early": Kind((3.0, 9.0), cut=10.0),
    "parachute, 1.5 s of rest": Kind((3.0, 9.0), cut=-1.5),
    "drogue alone, 1.5 s of rest": Kind((15.0, 35.0), cut=-1.5),
    "drogue and main": Kind((14.0, 35.0), (4.0, 9.0)),
    "drogue and main, cut off 5 s early": Kind((14.0, 35.0), (4.0, 9.0), cut=5.0),
    "streamer and parachute": Kind((9.0, 15.0), (3.0, 6.0), released=(60.0, 150.0)),
}
"""Kinds of descents by name."""


@dataclass(frozen=True, slots=True)
class Descent:
    """A flight with another descent, its true speeds, as if near the ground [m/s], and the release of the main [m]."""

    path: Path
    first: float
    main: float | None
    released: float


def descended(path: Path, kind: Kind, rng: np.random.Generator, *, barometric: bool = True) -> Descent | None:
    """A flight with a descent of a kind; None if it is too low to reach the speed of the first device
    before the main is released. The true values are those of heights from pressure, or from satellites."""
    first, main = rng.uniform(*kind.first), rng.uniform(*kind.main) if kind.main else None
    released, opening = float(rng.uniform(*kind.released)), float(rng.uniform(*kind.opening))
    top = int(np.argmax(path.above))
    if main is not None and path.above[top] < released + first * SHORTEST:
        return None
    charge = float(rng.uniform(*kind.late))
    height = _fall(float(path.above[top]), (first, main), released, (charge, opening), rng)
    above = np.concatenate([path.above[:top], height])
    time = np.asarray(np.arange(above.size) * STEP, np.float64)
    shrunk = float(path.height[top] / path.above[top])
    fired = float(time[top]) + charge
    push = np.append(path.push[:top], np.full(height.size, GRAVITY))
    flown = replace(
        path,
        time=time,
        above=above,
        height=np.concatenate([path.height[:top], shrunk * height]),
        speed=np.gradient(above, STEP),
        push=push,
        ejection=fired,
        landing=float(time[-1]),
    )
    scale = shrunk if barometric else 1.0
    if main is None:
        return Descent(flown, _mean_speed(flown, scale, fired, flown.landing), None, released)
    opens = float(time[top + int(np.argmax(height < released))])
    settled = fired + 2 * first / GRAVITY
    if opens - settled < SHORTEST:
        return None
    first_speed, main_speed = (
        _mean_speed(flown, scale, *span) for span in ((settled, opens), (opens + OPEN, flown.landing))
    )
    return Descent(flown, first_speed, main_speed, scale * released)


def _mean_speed(path: Path, gain: float, begin: float, end: float) -> float:
    """Mean speed of a descent between two times [s], as if all of it were near the ground, by a sensor that shows
    heights times a gain. [m/s]"""
    high, low = gain * np.interp([begin, end], path.time, path.above)
    scale = 2 * SCALE_HEIGHT
    return float(scale * (np.exp(-low / scale) - np.exp(-high / scale)) / (end - begin))


def _fall(
    top: float,
    speeds: tuple[float, float | None],
    released: float,
    times: tuple[float, float],
    rng: np.random.Generator,
) -> Float[Array, "step"]:
    """Heights above the pad of a fall from `top` down to the ground [m]; `times` are those of the charge after apogee
    and of opening [s]."""
    charge, opening = times
    count = int(120 + 3 * top / min(one for one in speeds if one)) * round(1 / STEP)
    wind = _wind(rng, count)
    height, fall, open_main, heights = top, 0.0, np.inf, [top]
    for step in range(count):
        now = step * STEP
        if height < released and np.isinf(open_main):
            open_main = now
        density = np.exp(-height / SCALE_HEIGHT)
        drag = density * max(now - charge, 0.0) ** 2 / (opening**2 * speeds[0] ** 2)
        drag = min(drag, density / speeds[0] ** 2)
        if speeds[1]:
            drag += density / speeds[1] ** 2 * min(max(now - open_main, 0.0) / opening, 1.0) ** 2
        air = fall + wind[step]  # the wind carries it up
        fall += STEP * GRAVITY * (1 - drag * air * abs(air))
        height -= STEP * fall
        heights.append(height)
        if height <= 0:
            break
    return np.array(heights)


def _wind(rng: np.random.Generator, count: int) -> Float[Array, "step"]:
    """Vertical wind at each step: gusts and thermals, each an Ornstein-Uhlenbeck process. [m/s]"""
    from scipy.signal import lfilter

    parts = [
        lfilter([1.0], [1.0, STEP / lasts - 1], rng.normal(0, sd * np.sqrt(2 * STEP / lasts), count))
        for sd, lasts in ((GUST, GUST_TIME), (THERMAL, THERMAL_TIME))
    ]
    return np.asarray(parts[0] + parts[1])


def judged(kind: Kind, recorder: str, count: int, seed: int) -> Iterator[tuple[bool, dict[str, float]]]:
    """For each flight whether two speeds were measured, and the errors of its figures in standard deviations."""
    rng = np.random.default_rng([seed, zlib.crc32(recorder.encode())])
    for path in draw(rng, count):
        flown = descended(path, kind, rng, barometric=RECORDERS[recorder].baro > 0)
        if flown is None:
            continue
        try:
            recorded = read(written(flown.path, _cut(RECORDERS[recorder], kind.cut), rng))
        except FieldkitError:
            continue
        right = {
            "drogue_speed": flown.first,
            "main_altitude": flown.released,
            "descent_speed": flown.main or flown.first,
        }
        found = {name: one for name, one in recorded.figures.items() if name in right}
        two = "drogue_speed" in found
        yield two, {name: (one.value - right[name]) / one.sd for name, one in found.items()} if two else {}


def main(arguments: list[str] | None = None) -> int:
    """Print a table of the kinds of descents."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    asked = parser.parse_args(arguments)
    sys.stdout.write("| descent | flights | two speeds | drogue, main, release within 2 sd |\n|---|---|---|---|\n")
    for name, kind in KINDS.items():
        if asked.only not in name:
            continue
        rows = [one for recorder in RECORDER_NAMES for one in judged(kind, recorder, asked.flights, asked.seed)]
        two = [errors for found, errors in rows if found]
        names = ("drogue_speed", "descent_speed", "main_altitude")
        within = [np.mean([abs(one[what]) <= 2 for one in two if what in one]) if two else np.nan for what in names]
        cells = ", ".join(f"{100 * one:.0f}%" for one in within) if two and kind.main else ""
        sys.stdout.write(f"| {name} | {len(rows)} | {len(two)} | {cells} |\n")
        sys.stdout.flush()
    return 0


def _cut(recorder: Recorder, cut: float) -> Recorder:
    return replace(recorder, rest=-cut) if cut else recorder


if __name__ == "__main__":
    sys.exit(main())
