"""Tables without names, of programs that print numbers in their way, and of sensors that start late or are filtered."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from bench.mutations.programs import same
from bench.mutations.tables import WAIT, Kind, Log, Sheet, cells, clock, integers, log_of, plain, renamed
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

FIX_RATE, NO_FIX = 10.0, -2.0
"""Fixes of a tracker [1/s], and until when it has none, from lift-off [s]."""
FILTERS = {"a quick": 0.05, "a slow": 0.1, "a very slow": 0.3}
"""Time constants of the filters of accelerometers. [s]"""
OFFSET = 60.0
"""Difference of two barometers by their calibration. [Pa]"""
EPOCH = 1.75e9
"""When a flight began, from 1970. [s]"""


def unnamed(*columns: list[str], separator: str = ",") -> Sheet:
    """Rows without a line of names."""
    rows = zip(*columns, strict=True)
    return Sheet((), other="".join(separator.join(row) + "\n" for row in rows).encode())


def filtered(log: Log, constant: float) -> Sheet:
    """An accelerometer behind a first-order filter with a time constant. [s]"""
    felt, part = log.felt.copy(), 1 - np.exp(-float(np.median(np.diff(log.time))) / constant)
    for place in range(1, felt.size):
        felt[place] = felt[place - 1] + part * (log.felt[place] - felt[place - 1])
    return plain(replace(log, felt=felt))


def before_its_fix(log: Log) -> Sheet:
    """A tracker that writes zeros until it has a fix."""
    fixes = log_of(log.path, log.rng, FIX_RATE)
    known = fixes.time > NO_FIX
    position = [cells(np.where(known, one, 0.0), 5) for one in (47.1, 8.2)]
    high = np.where(known, fixes.height + fixes.ground, 0.0)
    return Sheet(
        (
            ("millis", integers(1000 * (fixes.time + WAIT), 40)),
            ("Lat", position[0]),
            ("Lon", position[1]),
            ("Alt (m)", cells(high, 1)),
        )
    )


def formed(log: Log, form: str) -> Sheet:
    """Each number as another program prints it."""
    columns = ((name, [form.format(cell) for cell in cells_of]) for name, cells_of in plain(log).columns)
    return Sheet(tuple(columns))


def stamped(log: Log) -> Sheet:
    """Whole seconds and nanoseconds from 1970, as robots write their clocks."""
    whole, rest = np.divmod(log.time + EPOCH, 1.0)
    return replace(
        plain(log),
        columns=(
            ("header.stamp.secs", cells(whole, 0)),
            ("header.stamp.nsecs", cells(1e9 * rest, 0)),
            *plain(log).columns[1:],
        ),
    )


def garbled(log: Log) -> Sheet:
    """German names in UTF-8 that a spreadsheet took for another encoding."""
    names = ("Zeit [s]", "Höhe [m]", "Beschleunigung [g]")
    columns = zip(names, (one for _, one in plain(log).columns), strict=True)
    return Sheet(tuple((name.encode().decode("cp1252"), one) for name, one in columns), separator=";")


def two_barometers(log: Log) -> Sheet:
    """Two pressures without units that differ by their calibration."""
    other = log.pressure + OFFSET + log.rng.normal(0, 3, log.time.size)
    columns = (
        ("time_ms", integers(1000 * (log.time + WAIT), 40)),
        ("ms5611_pressure", cells(log.pressure, 1)),
        ("bmp390_pressure", cells(other, 1)),
    )
    return Sheet(columns)


def downward(log: Log) -> Sheet:
    """A position of one axis that points down, and its speed, without units."""
    return Sheet((("t", cells(log.time + WAIT)), ("posD", cells(-log.height)), ("velD", cells(-log.speed))))


def milliseconds(log: Log) -> list[str]:
    return integers(1000 * (log.time + WAIT), 40)


def starting(log: Log, value: float, count: int) -> Float[Array, "row"]:
    """Heights above the sea whose first ones a sensor did not measure yet. [m]"""
    return np.asarray(np.where(np.arange(log.time.size) < count, value, log.height + log.ground))


KINDS: Mapping[str, Kind] = {
    "two columns without names": lambda log: unnamed(cells(log.time + WAIT), cells(log.height, 2)),
    "two columns without names, ms and ft": lambda log: unnamed(milliseconds(log), cells(log.height / FOOT, 0)),
    "two columns without names, pressures": lambda log: unnamed(
        milliseconds(log), cells(log.pressure, 0), separator=" "
    ),
    "four columns without names": lambda log: unnamed(
        cells(log.time + WAIT), cells(log.height, 2), cells(log.speed, 2), cells(log.felt - GRAVITY, 2)
    ),
    "four columns without names, mapped as offered": lambda log: replace(
        unnamed(milliseconds(log), cells(log.pressure, 0), cells(log.height, 2), same(log, 24.1)),
        maps=("time=#1 [ms]", "altitude=#3 [m]"),
    ),
    "zeros before a fix": before_its_fix,
    "zeros before a reading": lambda log: Sheet(
        (plain(log).columns[0], ("altitude (m)", cells(starting(log, 0.0, 5))))
    ),
    "44 km before a reading": lambda log: Sheet(
        (plain(log).columns[0], ("altitude (m)", cells(starting(log, 44_330.0, 3))))
    ),
    **{f"an accelerometer behind {name} filter": partial(filtered, constant=one) for name, one in FILTERS.items()},
    "numbers as NumPy prints them": lambda log: formed(log, "np.float64({})"),
    "numbers as formulas": lambda log: formed(log, '="{}"'),
    "stamps of a robot": stamped,
    "names in a wrong encoding": garbled,
    "two barometers of other calibration": two_barometers,
    "a position downward alone": downward,
    "the time since the logger was switched on": lambda log: clock(log, "uptime_ms", milliseconds(log)),
    "names in camel case": lambda log: renamed(plain(log), time="flightTimeSec", altitude="altMeters"),
}
"""Kinds of tables by what was done."""
