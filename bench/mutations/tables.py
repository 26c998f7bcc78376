"""Variants of one table of samples of a known flight, as loggers, spreadsheets and people make them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from bench.recorders.flights import Path, sampled
from fieldkit.physics.standard_atmosphere import GRAVITY, height_pressure, pressure_height
from fieldkit.shapes import Array, Float, Int, Integers
from fieldkit.units import FOOT

RATE, WAIT, REST = 25.0, 4.0, 8.0
"""Sampling rate [1/s], and time on the pad and after landing [s]."""
HEIGHT_NOISE, FELT_NOISE, SWING = 0.3, 0.3, 5.0
"""Noise of heights [m] and of an accelerometer [m/s^2], and of it under a parachute [m/s^2]."""
UNITS = {"m": 1.0, "ft": FOOT, "cm": 0.01, "km": 1000.0}


@dataclass(frozen=True, slots=True)
class Sheet:
    """A table: its columns as texts by their names, and how it is written."""

    columns: tuple[tuple[str, list[str]], ...]
    separator: str = ","
    above: str = ""
    below: str = ""
    maps: tuple[str, ...] = ()
    """What the user writes after `--map`."""
    units: str = ""
    """A row between the names and the cells."""
    encoding: str = "utf-8"
    path: Path | None = None
    """The flight that it shows, if it is another one."""
    other: bytes = b""
    """The file, if it is no table."""

    def text(self) -> bytes:
        """The bytes of the file."""
        if self.other:
            return self.other
        rows = zip(*(cells for _, cells in self.columns), strict=True)
        names = self.separator.join(name for name, _ in self.columns)
        body = "\n".join([names, *([self.units] if self.units else []), *(self.separator.join(row) for row in rows)])
        return f"{self.above}{body}\n{self.below}".encode(self.encoding)


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """What a clean logger measures of a flight: heights above the pad, and the specific force along the axis. SI."""

    time: Float[Array, "row"]
    height: Float[Array, "row"]
    felt: Float[Array, "row"]
    speed: Float[Array, "row"]
    ground: float
    path: Path = field(repr=False)
    rng: np.random.Generator = field(repr=False)

    @property
    def pressure(self) -> Float[Array, "row"]:
        """Pressure at each row. [Pa]"""
        return height_pressure(self.height + self.ground)


def log_of(path: Path, rng: np.random.Generator, rate: float = RATE, wait: float = WAIT) -> Log:
    """The rows of a flight by a barometer and an accelerometer on one clock, and the time on the pad. [1/s], [s]"""
    time = np.arange(-wait, path.landing + REST, 1 / rate)
    height = sampled(path, time, path.height, 0.0) + rng.normal(0, HEIGHT_NOISE, time.size)
    felt = sampled(path, time, path.push, GRAVITY)
    free = path.ejection if path.ejection is not None else path.apogee_time
    hangs = (time > min(free, path.apogee_time) + 0.2) & (time < path.landing)
    felt = np.where(hangs, 0.5 * GRAVITY + rng.normal(0, SWING, time.size), felt)
    felt = felt + rng.normal(0, FELT_NOISE, time.size)
    speed = np.gradient(sampled(path, time, path.height, 0.0), time)
    return Log(time, height, felt, speed, float(pressure_height(np.array([path.station]))[0]), path, rng)


def cells(values: Float[Array, "row"], decimals: int = 3) -> list[str]:
    """Numbers as text; nan as an empty cell."""
    return ["" if np.isnan(one) else f"{one:.{decimals}f}" for one in values.tolist()]


def plain(log: Log, *more: tuple[str, list[str]]) -> Sheet:
    """Time, height and acceleration in stated units, and further columns."""
    felt = ("acceleration (g)", cells(log.felt / GRAVITY))
    return Sheet((("time (s)", cells(log.time + WAIT)), ("altitude (m)", cells(log.height)), felt, *more))


def without(sheet: Sheet, name: str) -> Sheet:
    """A table without a column."""
    return replace(sheet, columns=tuple(column for column in sheet.columns if column[0] != name))


def renamed(sheet: Sheet, **names: str) -> Sheet:
    """A table with other names for the columns that begin so."""
    new = [(next((to for old, to in names.items() if name.startswith(old)), name), one) for name, one in sheet.columns]
    return replace(sheet, columns=tuple(new))


def integers(values: Float[Array, "row"], bits: int, *, signed: bool = False) -> list[str]:
    """Numbers as a counter of some bits stores them."""
    whole = np.round(values).astype(np.int64) % 2**bits
    return [str(one) for one in np.where(signed & (whole >= 2 ** (bits - 1)), whole - 2**bits, whole).tolist()]


TIMES = (
    "t [s]",
    "Time (sec)",
    "Zeit in s",
    "temps_s",
    "elapsed time (s)",
    "timestamp_seconds",
    "tiempo (s)",
    "Flight_Time_(s)",
)
HEIGHTS = (
    "Alt (ft)",
    "hauteur_ft",
    "Höhe [ft]",
    "Baro_Altitude_AGL_(feet)",
    "ALTITUDE(FT)",
    "h (ft)",
    "Altitude Feet",
    "quota_ft",
)
FORCES = ("accel (g)", "Acceleration_g", "acc [g]", "Beschleunigung (g)", "axial acceleration (G)", "accel_axial_g")


def in_other_words(log: Log) -> Sheet:
    """Names in several languages, and feet."""
    draw = log.rng.choice
    columns = [(str(draw(TIMES)), cells(log.time + WAIT)), (str(draw(HEIGHTS)), cells(log.height / FOOT, 1))]
    columns.append((str(draw(FORCES)), cells(log.felt / GRAVITY)))
    order = log.rng.permutation(3)
    return Sheet(tuple(columns[place] for place in order))


def no_unit_of_height(log: Log, unit: str, *, pressure: bool) -> Sheet:
    """Heights without a unit, beside a pressure or alone."""
    sheet = Sheet((("time (s)", cells(log.time + WAIT)), ("altitude", cells(log.height / UNITS[unit], 2))))
    column = ("pressure (Pa)", cells(log.pressure, 1))
    return replace(sheet, columns=(*sheet.columns, column)) if pressure else sheet


def wrong_unit_of_height(log: Log, *, pressure: bool) -> Sheet:
    """Feet that are called meters."""
    return renamed(no_unit_of_height(log, "ft", pressure=pressure), altitude="altitude (m)")


def no_units_at_all(log: Log, unit: str) -> Sheet:
    """Heights and speeds in one system, neither stated."""
    sheet = no_unit_of_height(log, unit, pressure=False)
    return replace(sheet, columns=(*sheet.columns, ("velocity", cells(log.speed / UNITS[unit], 2))))


def clock(log: Log, name: str, count: list[str]) -> Sheet:
    """Another clock."""
    sheet = plain(log)
    return replace(sheet, columns=((name, count), *sheet.columns[1:]))


def restarted(log: Log) -> Sheet:
    """A clock that starts again, with a second, lower flight."""
    whole = plain(log)
    low = plain(replace(log, height=log.height * 0.999, felt=log.felt))
    return replace(
        whole, columns=tuple((a, [*x, *y]) for (a, x), (_, y) in zip(whole.columns, low.columns, strict=True))
    )


def spoiled(log: Log, part: float, value: float) -> Sheet:
    """Heights of which some are an impossible value."""
    bad = log.rng.random(log.time.size) < part
    return plain(replace(log, height=np.where(bad, value, log.height)))


def beside(log: Log, name: str, values: Float[Array, "row"]) -> Sheet:
    """A further column."""
    return plain(log, (name, cells(values)))


def axes(log: Log, unit: float, names: str) -> Sheet:
    """Three axes in any mounting, without a unit."""
    direction = np.array([0.05, 0.06, 0.997])
    noise = log.rng.normal(0, FELT_NOISE, (3, log.time.size))
    three = [
        (name, cells((part * log.felt + one) / unit))
        for name, part, one in zip(names.split(), direction, noise, strict=True)
    ]
    return replace(without(plain(log), "acceleration (g)"), columns=(*plain(log).columns[:2], *three))


def swapped_marks(sheet: Sheet) -> Sheet:
    """Semicolons and decimal commas, as a spreadsheet writes them in most of Europe."""
    changed = tuple((name, [cell.replace(".", ",") for cell in column]) for name, column in sheet.columns)
    return replace(sheet, columns=changed, separator=";")


def grouped(log: Log, mark: str) -> Sheet:
    """Heights above the sea in feet, with their thousands grouped."""
    feet = [f"{one:,.1f}".replace(",", mark).replace(".", ",") for one in ((log.height + 400) / FOOT).tolist()]
    sheet = swapped_marks(plain(log))
    return replace(sheet, columns=(sheet.columns[0], ("altitude (ft)", feet), sheet.columns[2]))


def grouped_by_commas(log: Log) -> Sheet:
    """Heights above the sea in feet, with commas between their thousands and quotes around them."""
    feet = [f'"{one:,.1f}"' for one in ((log.height + 400) / FOOT).tolist()]
    return renamed_height(log, "altitude (ft)", feet)


def texts(values: Float[Array, "row"], form: str) -> list[str]:
    """Times [s] as hours, minutes and seconds, or as minutes and seconds."""
    return [
        form.format(h=int(one // 3600), m=int(one // 60 % 60), mm=int(one // 60), s=one % 60)
        for one in np.round(values, 3).tolist()
    ]


def twice(log: Log, pause: float) -> Sheet:
    """A second flight of a lower rocket below the first, on one clock. [s]"""
    second = replace(log, height=0.7 * log.height, felt=GRAVITY + 0.7 * (log.felt - GRAVITY))
    later = replace(
        plain(second), columns=(("", cells(log.time + float(np.ptp(log.time)) + pause)), *plain(second).columns[1:])
    )
    return below(plain(log), later)


def below(sheet: Sheet, more: Sheet) -> Sheet:
    """The rows of two tables."""
    pairs = zip(sheet.columns, more.columns, strict=True)
    return replace(sheet, columns=tuple((name, [*one, *other]) for (name, one), (_, other) in pairs))


def tumbling(path: Path) -> Path:
    """A flight whose parachute stayed in: after its top it falls at 14 m/s, in v = u tanh(g t / u)."""
    fall, top = 14.0, float(path.height.max())
    since = np.maximum(path.time - path.apogee_time, 0.0)
    fell = np.maximum(top - fall**2 / GRAVITY * np.log(np.cosh(GRAVITY * since / fall)), 0.0)
    after = path.time > path.apogee_time
    landing = float(path.time[after & (fell <= 0)][0])
    return replace(path, height=np.where(after, fell, path.height), ejection=None, landing=landing)


def fallen(log: Log, *, felt: bool) -> Sheet:
    """A flight without a parachute, by a barometer and perhaps an accelerometer."""
    path = tumbling(log.path)
    sheet = replace(plain(log_of(path, log.rng)), path=path)
    return sheet if felt else without(sheet, "acceleration (g)")


def heading_again(log: Log) -> Sheet:
    """The heading once more in the middle, as a logger that restarts its file writes it."""
    sheet, middle = plain(log), log.time.size * 3 // 4
    return replace(sheet, columns=tuple((name, [*one[:middle], name, *one[middle:]]) for name, one in sheet.columns))


def rows(sheet: Sheet, order: Int[Integers, "row"]) -> Sheet:
    """Some of the rows, in an order."""
    places = order.tolist()
    return replace(sheet, columns=tuple((name, [column[i] for i in places]) for name, column in sheet.columns))


def shuffled(log: Log) -> Sheet:
    """Rows that a radio delivered out of order."""
    order = np.arange(log.time.size)
    for place in log.rng.choice(log.time.size - 3, 20, replace=False):
        order[place : place + 2] = order[place : place + 2][::-1]
    return rows(plain(log), order)


def repeated(log: Log) -> Sheet:
    """Rows written twice."""
    twice = log.rng.random(log.time.size) < 0.1
    return rows(plain(log), np.repeat(np.arange(log.time.size), 1 + twice))


def satellites(log: Log, name: str) -> Sheet:
    """A position with a height of its own after it."""
    north, east = 47 + log.rng.normal(0, 1e-5, log.time.size), 8 + log.rng.normal(0, 1e-5, log.time.size)
    high = log.height + log.ground + 25 + log.rng.normal(0, 4, log.time.size)
    return plain(log, ("latitude", cells(north, 6)), ("longitude", cells(east, 6)), (name, cells(high, 1)))


Kind = Callable[[Log], Sheet]
TOTALS = {"Apogee (m)": "height", "max altitude (m)": "height", "top_speed": "speed", "Max Velocity (m/s)": "speed"}
KINDS: Mapping[str, Kind] = {
    "other words and languages": in_other_words,
    "semicolons and decimal commas": lambda log: swapped_marks(in_other_words(log)),
    "heights without a unit beside pressure, m": lambda log: no_unit_of_height(log, "m", pressure=True),
    "heights without a unit beside pressure, ft": lambda log: no_unit_of_height(log, "ft", pressure=True),
    "heights without a unit, m": lambda log: no_unit_of_height(log, "m", pressure=False),
    "heights without a unit, ft": lambda log: no_unit_of_height(log, "ft", pressure=False),
    "no units at all, m": lambda log: no_units_at_all(log, "m"),
    "no units at all, ft": lambda log: no_units_at_all(log, "ft"),
    "feet called meters beside pressure": lambda log: wrong_unit_of_height(log, pressure=True),
    "feet called meters": lambda log: wrong_unit_of_height(log, pressure=False),
    "milliseconds without a unit": lambda log: clock(log, "time", integers(1000 * (log.time + WAIT), 40)),
    "microseconds without a unit": lambda log: clock(log, "time", integers(1e6 * (log.time + WAIT), 50)),
    "deciseconds": lambda log: clock(log, "ts[deciseconds]", cells(10 * (log.time + WAIT), 1)),
    "a clock in an unknown unit": lambda log: clock(log, "time (ticks)", integers(64 * (log.time + WAIT), 40)),
    "Unix time": lambda log: clock(log, "timestamp", cells(1.75e9 + log.time)),
    "a 16-bit clock": lambda log: clock(log, "time (ms)", integers(1000 * (log.time + 40), 16)),
    "a 32-bit clock": lambda log: clock(log, "time (us)", integers(1e6 * (log.time + WAIT) + 2**32 - 5e6, 32)),
    "a clock over midnight": lambda log: clock(log, "time", [clock_text(one) for one in (log.time + 86_399).tolist()]),
    "a clock that restarts": restarted,
    "heights of 16 bits in cm": lambda log: renamed_height(
        log, "altitude (cm)", integers(100 * log.height, 16, signed=True)
    ),
    "pressures in hPa": lambda log: by_pressure(log, "pressure (hPa)", 100.0, 2),
    "pressures in kPa": lambda log: by_pressure(log, "Pressure [kPa]", 1000.0, 3),
    "pressures in atm": lambda log: by_pressure(log, "Baro_Press_(atm)", 101_325.0, 6),
    "pressures without a unit": lambda log: by_pressure(log, "pressure", 100.0, 2),
    "pressures in a wrong unit": lambda log: by_pressure(log, "pressure (Pa)", 100.0, 2),
    "pressures in a unit that is too small": lambda log: by_pressure(log, "pressure (atm)", 29_800.0, 6),
    "heights above the sea": lambda log: plain(replace(log, height=log.height + 612)),
    "a height above the sea beside it": lambda log: beside(log, "altitude asl (m)", log.height + 612),
    "a second height": lambda log: beside(log, "altitude 2 (m)", log.height + log.rng.normal(0, 1, log.time.size)),
    "a second height that is stuck": lambda log: beside(log, "altitude 2 (m)", 0 * log.time + 3),
    "a pressure that is stuck": lambda log: beside(log, "pressure (Pa)", 0 * log.time + 98_000),
    "a temperature with a misleading name": lambda log: beside(log, "baro_temperature", 21 + 0.01 * log.time),
    "a temperature of the altimeter": lambda log: beside(log, "temperature_alt_celsius", 21 + 0.01 * log.time),
    "a temperature called T": lambda log: replace(
        beside(log, "T", 21 + 0.01 * log.time),
        columns=(("t", cells(log.time + WAIT)), *beside(log, "T", 21 + 0.01 * log.time).columns[1:]),
    ),
    "a density altitude": lambda log: beside(log, "density altitude (m)", 1.07 * log.height + 700),
    "running totals": lambda log: plain(
        log, *((name, cells(np.maximum.accumulate(getattr(log, of)))) for name, of in TOTALS.items())
    ),
    "a running duration": lambda log: beside(log, "duration_s", log.time + WAIT),
    "satellites, altitude": lambda log: satellites(log, "altitude (m)"),
    "satellites, gps altitude": lambda log: satellites(log, "gps altitude (m)"),
    "satellites, alt msl": lambda log: satellites(log, "alt msl (m)"),
    "thousands with spaces": lambda log: grouped(log, "\u202f"),
    "thousands with apostrophes": lambda log: grouped(log, "'"),
    "rows twice": repeated,
    "rows out of order": shuffled,
    "the last row first": lambda log: rows(plain(log), np.arange(log.time.size)[::-1]),
    "every third row": lambda log: rows(plain(log), np.arange(0, log.time.size, 3)),
    "cut off in the descent": lambda log: rows(plain(log), np.arange(int(0.6 * log.time.size))),
    "heights that are zero at times": lambda log: spoiled(log, 0.01, 0.0),
    "heights that are 65535 at times": lambda log: spoiled(log, 0.01, 65_535.0),
    "heights that are missing at times": lambda log: spoiled(log, 0.1, np.nan),
    "a preamble": lambda log: replace(plain(log), above="Logger 7\nserial: 12, rate: 25\n\n"),
    "a summary below": lambda log: replace(plain(log), below="max altitude: 312 m\nend of log\n"),
    "three axes in m/s2 without a unit": lambda log: axes(log, 1.0, "ax ay az"),
    "three axes in g without a unit": lambda log: axes(log, GRAVITY, "accel_x accel_y accel_z"),
    "three axes in mg without a unit": lambda log: axes(log, GRAVITY / 1000, "AccX AccY AccZ"),
    "an acceleration with the nose down": lambda log: plain(replace(log, felt=-log.felt)),
    "an acceleration across the axis": lambda log: plain(replace(log, felt=log.rng.normal(0, 3, log.time.size))),
    "an acceleration of half the size": lambda log: plain(replace(log, felt=GRAVITY + (log.felt - GRAVITY) / 2)),
    "an acceleration in a wrong unit": lambda log: renamed(plain(log), acceleration="acceleration (m/s2)"),
    "an acceleration that saturates": lambda log: plain(replace(log, felt=np.minimum(log.felt, 4 * GRAVITY))),
    "an acceleration without a unit": lambda log: renamed(plain(log), acceleration="acceleration"),
    "an acceleration that is late": lambda log: plain(replace(log, felt=np.interp(log.time - 1.2, log.time, log.felt))),
    "a column that the user excludes": lambda log: replace(
        beside(log, "alt b (m)", log.height + 40 * np.sin(log.time)), maps=("exclude=alt b (m)",)
    ),
    "hours, minutes and seconds": lambda log: clock(log, "time", texts(log.time + WAIT, "{h:02}:{m:02}:{s:06.3f}")),
    "minutes and seconds": lambda log: clock(log, "time", texts(log.time + 1_700, "{mm:02}:{s:04.1f}")),
    "a time of day and a date": lambda log: clock(
        log, "timestamp", [f"2025-06-14T{one}Z" for one in texts(log.time + 40_000, "{h:02}:{m:02}:{s:06.3f}")]
    ),
    "tabs and decimal commas": lambda log: replace(swapped_marks(plain(log)), separator="\t"),
    "spaces between columns": lambda log: replace(
        renamed(plain(log), time="time_s", altitude="altitude_m", acceleration="accel_g"), separator="  "
    ),
    "thousands with commas in quotes": grouped_by_commas,
    "UTF-16": lambda log: replace(plain(log), encoding="utf-16"),
    "a heading after fifty comments": lambda log: replace(
        plain(log), above="".join(f"# setting {one}: {one * 3 % 7}\n" for one in range(50))
    ),
    "units in a row below the names": lambda log: replace(
        renamed(plain(log), time="time", altitude="altitude", acceleration="acceleration"), units="s,m,g"
    ),
    "feet in a row below the names": lambda log: replace(
        renamed(renamed_height(log, "altitude", cells(log.height / FOOT, 1)), time="time", acceleration="acceleration"),
        units="(s),(ft),(g)",
    ),
    "the heading again among the rows": heading_again,
    "empty columns": lambda log: plain(log, ("temperature (C)", [""] * log.time.size), ("", [""] * log.time.size)),
    "a column of words": lambda log: plain(
        log, ("state", ["BOOST" if 0 < one < log.path.burnout else "IDLE" for one in log.time.tolist()])
    ),
    "two flights on one clock": lambda log: twice(log, 60.0),
    "two flights with hardly a pause": lambda log: twice(log, 5.0),
    "once a second": lambda log: plain(log_of(log.path, log.rng, 1.0)),
    "a thousand times a second": lambda log: plain(log_of(log.path, log.rng, 1000.0)),
    "an hour on the pad": lambda log: plain(log_of(log.path, log.rng, 10.0, 3600.0)),
    "a barometer alone, an hour on the pad": lambda log: without(
        plain(log_of(log.path, log.rng, 10.0, 3600.0)), "acceleration (g)"
    ),
    "no time on the pad": lambda log: rows(plain(log), np.flatnonzero(log.time >= 0)),
    "a descent without a parachute": lambda log: fallen(log, felt=True),
    "a barometer alone, no parachute": lambda log: fallen(log, felt=False),
    "heights below the sea": lambda log: plain(replace(log, height=log.height - 420)),
    "heights below the pad's zero": lambda log: plain(replace(log, height=log.height - 35)),
    "a pad at 3,000 m, pressures": lambda log: by_pressure(replace(log, ground=3000.0), "pressure (hPa)", 100.0, 2),
    "a pad at 3,000 m, heights above the sea in feet": lambda log: renamed_height(
        log, "altitude msl (ft)", cells((log.height + 3000) / FOOT, 1)
    ),
    "heights in inches": lambda log: renamed_height(log, "altitude (in)", cells(log.height / FOOT * 12, 0)),
    "satellites that start from zero": lambda log: without(
        renamed_height(log, "gps altitude (m)", cells(log.height + log.rng.normal(0, 1.5, log.time.size), 1)),
        "acceleration (g)",
    ),
    "a filtered height beside the raw one": lambda log: beside(
        log, "filtered altitude (m)", np.convolve(log.height, np.ones(9) / 9, "same")
    ),
}
"""Kinds of variants by what was done."""


def renamed_height(log: Log, name: str, column: list[str]) -> Sheet:
    """Another column of heights."""
    sheet = plain(log)
    return replace(sheet, columns=(sheet.columns[0], (name, column), sheet.columns[2]))


def by_pressure(log: Log, name: str, unit: float, decimals: int) -> Sheet:
    """Pressures instead of heights."""
    return renamed_height(log, name, cells(log.pressure / unit, decimals))


def clock_text(seconds: float) -> str:
    """A time of day. [s]"""
    whole = seconds % 86_400
    return f"{int(whole // 3600):02}:{int(whole % 3600 // 60):02}:{whole % 60:06.3f}"
