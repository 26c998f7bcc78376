"""Tables as phones, autopilots, statistics programs and spreadsheets of other countries write them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bench.mutations.tables import (
    WAIT,
    Kind,
    Log,
    Sheet,
    beside,
    cells,
    clock,
    integers,
    plain,
    renamed_height,
    rows,
    swapped_marks,
    texts,
    without,
)
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.units import FOOT

COUNTS = 2048
"""Counts of an accelerometer per g."""
MORNING = 40_000.0
"""Time of day of a lift-off. [s]"""


def same(log: Log, value: float) -> list[str]:
    """A column that is the same in each row."""
    return [f"{value:g}"] * log.time.size


def named(log: Log, time: str, height: str, *, unit: float = 1.0, encoding: str = "utf-8") -> Sheet:
    """Times and heights alone, by their names, the size of a unit in meters, and an encoding."""
    columns = ((time, cells(log.time + WAIT)), (height, cells(log.height / unit, 2)))
    return Sheet(columns, encoding=encoding)


def numbered(log: Log) -> Sheet:
    """A quoted number before each row and none in the heading."""
    sheet = plain(log)
    name, column = sheet.columns[0]
    first = [f'"{place}",{cell}' for place, cell in enumerate(column, 1)]
    return replace(sheet, columns=((name, first), *sheet.columns[1:]))


def signed(log: Log) -> Sheet:
    """The time from launch, as a countdown and then as a mission clock."""
    found = [f"T{'-' if one < 0 else '+'}00:{abs(one) // 60:02.0f}:{abs(one) % 60:06.3f}" for one in log.time.tolist()]
    return clock(log, "MET", found)


def ticks(log: Log) -> Sheet:
    """Whole seconds, in each of which there are many rows."""
    return clock(log, "utc", texts(np.floor(log.time + MORNING), "{h:02}:{m:02}:{s:02.0f}"))


def in_two(log: Log) -> Sheet:
    """Whole seconds, and milliseconds in a column of their own."""
    whole, rest = np.divmod(np.round(1000 * (log.time + WAIT)).astype(int), 1000)
    first, *others = clock(log, "sec", [str(one) for one in whole.tolist()]).columns
    return Sheet((first, ("msec", [str(one) for one in rest.tolist()]), *others))


def in_three(log: Log) -> Sheet:
    """Hours, minutes and seconds in three columns."""
    parts = [one.split(":") for one in texts(log.time + MORNING, "{h}:{m}:{s:.3f}")]
    columns = zip(("hour", "minute", "second"), map(list, zip(*parts, strict=True)), strict=True)
    return Sheet((*columns, *plain(log).columns[1:]))


def counted(log: Log, above: str) -> Sheet:
    """Rows without a clock, and text above them."""
    return replace(without(plain(log), "time (s)"), above=above)


def statistics(log: Log) -> Sheet:
    """Rows of a spreadsheet's functions below the samples."""
    high, mean = float(log.height.max()), float(log.height.mean())
    return replace(plain(log), below=f"Max,{high:.1f},9.1\nAverage,{mean:.1f},1.0\n{WAIT},{mean:.1f},1.0\n")


def titled(log: Log) -> Sheet:
    """A row of sensors above the names, and one of units below."""
    sheet = plain(log)
    columns = zip(("Time", "Altitude", "Accel"), (one for _, one in sheet.columns), strict=True)
    return replace(sheet, columns=tuple(columns), above="Clock,Barometer,IMU\n", units="[s],[m],[g]")


def in_columns(log: Log) -> Sheet:
    """The heights of several flights, a column for each."""
    first, (_, height), _ = plain(log).columns
    others = (("Flight 2 altitude (m)", cells(0.6 * log.height)), ("Flight 3 altitude (m)", cells(0.8 * log.height)))
    return Sheet((first, ("Flight 1 altitude (m)", height), *others))


def multicopter(log: Log) -> Sheet:
    """A flight controller's log as its decoder writes it."""
    across = cells(log.rng.normal(0, 20, log.time.size), 0)
    columns = (
        ("loopIteration", [str(place) for place in range(log.time.size)]),
        ("time (us)", integers(1e6 * (log.time + WAIT), 40)),
        ("gyroADC[0]", across),
        ("accSmooth[0]", across),
        ("accSmooth[1]", across),
        ("accSmooth[2]", cells(log.felt / GRAVITY * COUNTS, 0)),
        ("baroAlt (cm)", cells(100 * log.height, 0)),
        ("vbatLatest (V)", same(log, 7.41)),
    )
    return Sheet(columns, separator=", ")


def autopilot(log: Log) -> Sheet:
    """The barometer of an autopilot, with the density of its atmosphere."""
    since = integers(1e6 * (log.time + 60), 40)
    columns = (
        ("timestamp", since),
        ("timestamp_sample", since),
        ("baro_device_id", same(log, 4028193)),
        ("baro_alt_meter", cells(log.height + log.ground)),
        ("baro_temp_celcius", same(log, 31.2)),
        ("baro_pressure_pa", cells(log.pressure, 1)),
        ("rho", same(log, 1.17)),
    )
    return Sheet(columns)


def phone(log: Log) -> Sheet:
    """The barometer of a phone: nanoseconds from 1970, and a height from zero."""
    columns = (
        ("time", [str(int((1.75e9 + one) * 1e9)) for one in log.time.tolist()]),
        ("seconds_elapsed", cells(log.time + WAIT, 6)),
        ("relativeAltitude", cells(log.height - log.height[0], 6)),
        ("pressure", cells(log.pressure / 100, 6)),
    )
    return Sheet(columns)


def experiment(log: Log) -> Sheet:
    """The pressure of an app for experiments, with exponents and decimal commas."""
    columns = (
        ('"Zeit (s)"', [f"{one:.9E}" for one in (log.time + WAIT).tolist()]),
        ('"Druck (hPa)"', [f"{one:.9E}" for one in (log.pressure / 100).tolist()]),
    )
    return swapped_marks(Sheet(columns))


KINDS: Mapping[str, Kind] = {
    "row numbers of a statistics program": numbered,
    "no clock, a rate in a comment": lambda log: counted(log, "# Sample rate: 25 Hz\n"),
    "no clock, an interval above": lambda log: counted(log, "Logger 7\nSampling interval: 40 ms\n\n"),
    "no clock, a rate that the user states": lambda log: replace(counted(log, ""), maps=("time=25 Hz",)),
    "Japanese names and units": lambda log: named(log, "時間(秒)", "高度(m)"),
    "Japanese in its old encoding": lambda log: named(log, "時間(s)", "高度(m)", encoding="cp932"),
    "Chinese units": lambda log: named(log, "时间(秒)", "高度(米)"),
    "Chinese in its old encoding": lambda log: named(log, "时间(s)", "高度(m)", encoding="gb18030"),
    "Korean units": lambda log: named(log, "시간(초)", "고도(미터)"),
    "Russian in its old encoding": lambda log: named(log, "Время (с)", "Высота (м)", encoding="cp1251"),
    "Greek names": lambda log: named(log, "Χρόνος (s)", "Ύψος (m)"),
    "Spanish feet": lambda log: named(log, "Tiempo (seg)", "Altura (pies)", unit=FOOT),
    "German feet": lambda log: named(log, "Zeit (Sek.)", "Höhe (Fuß)", unit=FOOT),
    "French feet": lambda log: named(log, "Temps (s)", "Hauteur (pieds)", unit=FOOT),
    "feet above ground in brackets": lambda log: named(log, "Time(s)", "Alt(ft AGL)", unit=FOOT),
    "a clock before and after launch": signed,
    "hundredths of a second without a unit": lambda log: clock(log, "time", integers(100 * (log.time + WAIT), 40)),
    "a clock in tens of milliseconds": lambda log: clock(log, "time (10ms)", integers(100 * (log.time + WAIT), 40)),
    "heights in tenths of a meter": lambda log: renamed_height(log, "Alt [0.1 m]", cells(10 * log.height, 0)),
    "decimeters called meters": lambda log: renamed_height(log, "altitude (m)", cells(10 * log.height, 0)),
    "a clock in tenths of microseconds": lambda log: clock(log, "timestamp", integers(1e7 * (log.time + 1.3e10), 60)),
    "many rows in each whole second": ticks,
    "five rows in each whole second": lambda log: rows(ticks(log), np.arange(0, log.time.size, 5)),
    "seconds and milliseconds in two columns": in_two,
    "hours, minutes and seconds in three columns": in_three,
    "statistics below": statistics,
    "sensors above the names and units below": titled,
    "units in a sentence above": lambda log: replace(
        named(log, "Time", "Alt", unit=FOOT), above="Altitude in feet above ground, time in seconds\n\n"
    ),
    "a simulation beside it": lambda log: beside(log, "simulated altitude (m)", 1.1 * log.height),
    "flights in columns": in_columns,
    "a multicopter's flight controller": multicopter,
    "an autopilot": autopilot,
    "a phone": phone,
    "an app for experiments": experiment,
}
"""Kinds of variants by what was done."""
