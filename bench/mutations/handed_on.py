"""Tables as flyers hand them on: saved by a spreadsheet, copied from a console, cut, joined, started in flight."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from bench.mutations.tables import (
    WAIT,
    Kind,
    Log,
    Sheet,
    below,
    beside,
    by_pressure,
    cells,
    clock,
    integers,
    log_of,
    plain,
    renamed_height,
    rows,
    swapped_marks,
    texts,
    without,
)
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float, Int, Integers
from fieldkit.units import FOOT

DAY = 86_400.0
MILE_PER_HOUR = 0.44704
SLOW = 2.0
"""Rate at which a logger samples the descent. [1/s]"""
COUNTS = 2048
"""Counts of an accelerometer per g."""
LATE = 1.0
"""How long after lift-off a log begins. [s]"""
FILTER = 1.0
"""Time constant of a slow filter. [s]"""


def figures(values: Float[Array, "row"], digits: int) -> list[str]:
    """Numbers as a narrow spreadsheet column shows them, with an exponent and few digits."""
    return [f"{one:.{digits - 1}E}" for one in values.tolist()]


def changed(sheet: Sheet, change: Callable[[str], str]) -> Sheet:
    """A table with other texts in its cells."""
    return replace(sheet, columns=tuple((name, [change(cell) for cell in column]) for name, column in sheet.columns))


def whole_seconds(log: Log) -> Sheet:
    """A time of day of which a spreadsheet kept the seconds only."""
    return clock(log, "time", texts(np.floor(log.time + 40_000), "{h:02}:{m:02}:{s:02.0f}"))


def unpadded(log: Log) -> Sheet:
    """Seconds and milliseconds joined by a point without zeros, so that 1.005 s is written 1.5."""
    whole, thousandths = np.divmod(np.round(1000 * (log.time + WAIT)).astype(int), 1000)
    return clock(log, "time (s)", [f"{a}.{b}" for a, b in zip(whole.tolist(), thousandths.tolist(), strict=True)])


def slower_descent(log: Log) -> Sheet:
    """A logger that saves memory once the rocket falls."""
    falls = log.time > log.path.apogee_time + 3
    kept = ~falls | (np.arange(log.time.size) % round(25 / SLOW) == 0)
    return rows(plain(log), np.flatnonzero(kept))


def started_in_flight(log: Log) -> Sheet:
    """A logger that starts too late."""
    return rows(plain(log), np.flatnonzero(log.time > LATE))


def ends_at(log: Log, time: float) -> Sheet:
    """A log that is cut off. [s]"""
    return rows(plain(log), np.flatnonzero(log.time < time))


def headings_and_restart(log: Log) -> Sheet:
    """A second, lower flight below the first, with a heading and a clock of its own."""
    first, second = plain(log), plain(replace(log, height=0.7 * log.height, felt=GRAVITY + 0.7 * (log.felt - GRAVITY)))
    headed = replace(second, columns=tuple((name, [name, *column]) for name, column in second.columns))
    return below(first, headed)


def side_by_side(log: Log) -> Sheet:
    """Two loggers of one flight, each with its clock."""
    other = log_of(log.path, log.rng)
    more = [("time 2 (s)", cells(other.time + WAIT + 0.013)), ("altitude 2 (m)", cells(other.height))]
    return plain(log, *more)


def north_east_down(log: Log) -> Sheet:
    """A position of an autopilot, whose third axis points down."""
    drift = 2.0 * np.maximum(log.time, 0)
    axes = (("pos_n (m)", cells(drift)), ("pos_e (m)", cells(0.5 * drift)), ("pos_d (m)", cells(-log.height)))
    return replace(plain(log), columns=(plain(log).columns[0], *axes))


def console(log: Log, mark: str, *, clock: bool = True) -> Sheet:
    """Lines of a serial monitor, which puts the time of day before each; perhaps the logger prints no time."""
    whole = plain(log) if clock else without(plain(log), "time (s)")
    stamps = texts(log.time + 40_000, "{h:02}:{m:02}:{s:06.3f}")
    stamps = [f"[{stamp}" for stamp in stamps] if mark.startswith("]") else stamps
    first = [f"{stamp}{mark}{cell}" for stamp, cell in zip(stamps, whole.columns[0][1], strict=True)]
    name, *others = whole.columns
    return replace(whole, columns=((f"{stamps[0]}{mark}{name[0]}", first), *others))


def labelled(log: Log) -> Sheet:
    """Each number with its name, as sketches print them."""
    names = ("t", "alt", "acc")
    sheet = plain(log)
    return replace(
        sheet,
        columns=tuple(
            (f"{name}:{column[0]}", [f"{name}:{cell}" for cell in column])
            for name, (_, column) in zip(names, sheet.columns, strict=True)
        ),
    )


def satellites_alone(log: Log) -> Sheet:
    """A tracker once a second: position, height above the sea, number of satellites."""
    every = rows(plain(log), np.arange(0, log.time.size, 25))
    moment = log.time[::25]
    high = log.height[::25] + log.ground + log.rng.normal(0, 1.5, moment.size)
    north, east = 47 + log.rng.normal(0, 1e-5, moment.size), 8 + log.rng.normal(0, 1e-5, moment.size)
    columns = (
        ("lat", cells(north, 6)),
        ("lon", cells(east, 6)),
        ("alt_m", cells(high, 1)),
        ("sats", ["9"] * high.size),
    )
    return replace(every, columns=(every.columns[0], *columns))


def lagged(values: Float[Array, "row"], step: float) -> Float[Array, "row"]:
    """Values behind a slow first-order filter at a time step [s]."""
    found, part = values.copy(), 1 - np.exp(-step / FILTER)
    for place in range(1, values.size):
        found[place] = found[place - 1] + part * (values[place] - found[place - 1])
    return found


def with_zeros(log: Log, *names: str) -> Sheet:
    """Columns of sensors that are not there."""
    return plain(log, *((name, ["0"] * log.time.size) for name in names))


def twelve_hours(values: Float[Array, "row"]) -> list[str]:
    """Times of day [s] with AM and PM."""
    found = texts(values, "{h} {m:02}:{s:06.3f}")
    pairs = [one.split(" ") for one in found]
    return [f"{(int(hour) + 11) % 12 + 1}:{rest} {'AM' if int(hour) % 24 < 12 else 'PM'}" for hour, rest in pairs]


def headless(log: Log) -> Sheet:
    """A row number in each row and none in the heading, as statistics programs write it."""
    sheet = plain(log)
    name, column = sheet.columns[0]
    return replace(
        sheet, columns=((name, [f"{place},{cell}" for place, cell in enumerate(column, 1)]), *sheet.columns[1:])
    )


def dated(cell: str) -> str:
    """What a spreadsheet makes of a number that looks like a day and a month."""
    whole, _, part = cell.partition(".")
    month = part.strip("0")
    return f"{int(whole):02}. Mai" if month == "5" and whole.isdigit() and 1 <= int(whole) <= 31 else cell


def held(log: Log, count: int) -> Sheet:
    """Heights of a barometer that is read less often than the rest."""
    return plain(replace(log, height=log.height[np.arange(log.time.size) // count * count]))


def predicted(log: Log) -> Float[Array, "row"]:
    """What a flight computer expects of the apogee, without drag. [m]"""
    rises = (log.time > 0) & (log.time < log.path.apogee_time)
    return np.where(rises, log.height + np.maximum(log.speed, 0) ** 2 / (2 * GRAVITY), 0.0)


def carried(log: Log, height: float) -> Sheet:
    """A slow rise and fall of the pressure before the flight. [m]"""
    long = log_of(log.path, log.rng, wait=200.0)
    slow = height * np.clip(np.minimum(long.time + 180, -60 - long.time) / 30, 0, 1)
    return replace(plain(replace(long, height=long.height + slow)))


def waits(time: Float[Array, "row"]) -> Int[Integers, "_"]:
    """The rows of a logger that samples once a second until it detects a flight."""
    return np.flatnonzero((time > -0.2) | (np.arange(time.size) % 100 == 0))


def two_devices(log: Log) -> Sheet:
    """The rows of two devices of one rocket, one after the other in time, with their names."""
    first = plain(log, ("device", ["A"] * log.time.size))
    other = log_of(log.path, log.rng)
    second = plain(replace(other, time=other.time + 0.013), ("device", ["B"] * other.time.size))
    both = below(first, second)
    return rows(both, np.argsort(np.concatenate([log.time, other.time + 0.013]), kind="stable"))


def whole_meters(log: Log) -> Sheet:
    """Heights of a small display, once a second."""
    slow = log_of(log.path, log.rng, 1.0)
    return Sheet((("time (s)", cells(slow.time + WAIT, 0)), ("altitude (m)", cells(slow.height, 0))))


KINDS: Mapping[str, Kind] = {
    "a date and a time in two columns": lambda log: replace(
        clock(log, "time", texts(log.time + 40_000, "{h:02}:{m:02}:{s:06.3f}")),
        columns=(
            ("date", ["2025-06-14"] * log.time.size),
            *clock(log, "time", texts(log.time + 40_000, "{h:02}:{m:02}:{s:06.3f}")).columns,
        ),
    ),
    "days of a spreadsheet": lambda log: clock(log, "time", cells(45_822 + (log.time + 40_000) / DAY, 8)),
    "seconds of a spreadsheet alone": whole_seconds,
    "milliseconds without zeros": unpadded,
    "minutes": lambda log: clock(log, "time (min)", cells((log.time + WAIT) / 60, 5)),
    "numbers with an exponent and five digits": lambda log: Sheet(
        (
            ("time (s)", figures(log.time + WAIT, 5)),
            ("altitude (m)", figures(log.height, 5)),
            ("acceleration (g)", figures(log.felt / GRAVITY, 5)),
        )
    ),
    "pressures with three digits": lambda log: (
        by_pressure(log, "pressure (Pa)", 1.0, 0) and renamed_height(log, "pressure (Pa)", figures(log.pressure, 3))
    ),
    "heights with an exponent and three digits": lambda log: renamed_height(
        log, "altitude (m)", figures(log.height, 3)
    ),
    "no clock, a number of each row": lambda log: replace(
        clock(log, "sample", [str(place) for place in range(log.time.size)]), above="sample rate: 25 Hz\n"
    ),
    "no clock at all": lambda log: without(plain(log), "time (s)"),
    "a slower descent": slower_descent,
    "started in flight": started_in_flight,
    "cut off at burnout": lambda log: ends_at(log, log.path.burnout),
    "cut off in the boost": lambda log: ends_at(log, 0.7 * log.path.burnout),
    "cut off in the boost, a barometer alone": lambda log: without(
        ends_at(log, 0.9 * log.path.burnout), "acceleration (g)"
    ),
    "cut off in the coast, a barometer alone": lambda log: without(
        ends_at(log, (log.path.burnout + log.path.apogee_time) / 2), "acceleration (g)"
    ),
    "cut off before the top, a barometer alone": lambda log: without(
        ends_at(log, log.path.apogee_time - 0.7), "acceleration (g)"
    ),
    "cut off in the coast": lambda log: ends_at(log, (log.path.burnout + log.path.apogee_time) / 2),
    "cut off at the top": lambda log: ends_at(log, log.path.apogee_time + 0.5),
    "a second flight with a heading and a clock of its own": headings_and_restart,
    "the whole file twice": lambda log: below(plain(log), plain(log)),
    "two loggers side by side": side_by_side,
    "a position that points down": north_east_down,
    "lines of a serial monitor": lambda log: console(log, " -> "),
    "lines of a serial monitor, the only clock": lambda log: console(log, " -> ", clock=False),
    "lines of a terminal": lambda log: console(log, "] "),
    "each number with its name": labelled,
    "satellites alone, once a second": satellites_alone,
    "quotes around every cell": lambda log: changed(plain(log), lambda cell: f'"{cell}"'),
    "apostrophes before every cell": lambda log: changed(plain(log), lambda cell: f"'{cell}"),
    "units in every cell": lambda log: replace(
        plain(log),
        columns=tuple(
            (name.split(" ")[0], [f"{cell} {unit}" for cell in column])
            for (name, column), unit in zip(plain(log).columns, ("s", "m", "g"), strict=True)
        ),
    ),
    "missing values in words": lambda log: replace(
        plain(log),
        columns=(
            *plain(log).columns[:1],
            ("altitude (m)", [one if place % 7 else "N/A" for place, one in enumerate(plain(log).columns[1][1])]),
            *plain(log).columns[2:],
        ),
    ),
    "missing values of -9999": lambda log: renamed_height(
        log, "altitude (m)", [one if place % 11 else "-9999" for place, one in enumerate(cells(log.height))]
    ),
    "pressures in inches of mercury": lambda log: by_pressure(log, "pressure (inHg)", 3386.389, 4),
    "pressures in mmHg": lambda log: by_pressure(log, "pressure (mmHg)", 133.3224, 3),
    "pressures in psi": lambda log: by_pressure(log, "pressure (psi)", 6894.757, 5),
    "speeds in miles per hour": lambda log: beside(log, "speed (mph)", log.speed / MILE_PER_HOUR),
    "feet beside meters": lambda log: beside(log, "altitude (ft)", log.height / FOOT),
    "feet above the sea beside meters above the pad": lambda log: beside(
        log, "altitude msl (ft)", (log.height + log.ground) / FOOT
    ),
    "a fall called height": lambda log: plain(replace(log, height=-log.height)),
    "counts of an accelerometer": lambda log: replace(
        plain(log), columns=(*plain(log).columns[:2], ("az", cells(log.felt / GRAVITY * COUNTS, 0)))
    ),
    "an acceleration without gravity": lambda log: replace(
        plain(log), columns=(*plain(log).columns[:2], ("linear acceleration (m/s2)", cells(log.felt - GRAVITY)))
    ),
    "an accelerometer of zeros": lambda log: replace(
        with_zeros(log, "accel (g)"), columns=(*plain(log).columns[:2], ("accel (g)", ["0"] * log.time.size))
    ),
    "satellites of zeros": lambda log: with_zeros(log, "latitude", "longitude", "gps altitude (m)"),
    "a speed of zeros": lambda log: with_zeros(log, "velocity (m/s)"),
    "heights behind a slow filter": lambda log: plain(replace(log, height=lagged(log.height, 1 / 25))),
    "a filtered height alone": lambda log: without(
        plain(replace(log, height=lagged(log.height, 1 / 25))), "acceleration (g)"
    ),
    "decimal commas and names in cp1252": lambda log: replace(
        swapped_marks(renamed_height(log, "Höhe (m)", cells(log.height))), encoding="cp1252"
    ),
    "heights in miles": lambda log: renamed_height(log, "altitude (mi)", cells(log.height / FOOT / 5280, 6)),
    "milliseconds called seconds": lambda log: clock(log, "time (s)", integers(1000 * (log.time + WAIT), 40)),
    "seconds called milliseconds": lambda log: clock(log, "time (ms)", cells(log.time + WAIT)),
    "centimeters called meters": lambda log: renamed_height(log, "altitude (m)", cells(100 * log.height, 0)),
    "a barometer alone, centimeters called meters": lambda log: without(
        renamed_height(log, "altitude (m)", cells(100 * log.height, 0)), "acceleration (g)"
    ),
    "milliseconds with three digits": lambda log: clock(log, "time (ms)", figures(1000 * (log.time + WAIT), 3)),
    "a clock of tenths of a second": lambda log: clock(log, "time (s)", cells(log.time + WAIT, 1)),
    "minutes and seconds over an hour": lambda log: clock(
        log, "time", texts((log.time + 3598) % 3600, "{mm:02}:{s:04.1f}")
    ),
    "hours, minutes and seconds in one number": lambda log: clock(
        log, "time", [one.replace(":", "") for one in texts(np.round(log.time + 43_150, 2), "{h:02}:{m:02}:{s:05.2f}")]
    ),
    "the minus of a spreadsheet": lambda log: changed(plain(log), lambda cell: cell.replace("-", "\N{MINUS SIGN}")),
    "morning and afternoon": lambda log: clock(log, "time", twelve_hours(log.time + 12 * 3600 + 3598)),
    "quoted decimal commas between commas": lambda log: changed(plain(log), lambda cell: f'"{cell.replace(".", ",")}"'),
    "a column of row numbers without a name": lambda log: replace(
        plain(log), columns=(("", [str(place) for place in range(log.time.size)]), *plain(log).columns)
    ),
    "row numbers that the heading lacks": lambda log: headless(log),
    "twelve empty columns": lambda log: plain(log, *((("", [""] * log.time.size),) * 12)),
    "numbers that a spreadsheet took for dates": lambda log: changed(plain(log), dated),
    "heights held for ten rows": lambda log: held(log, 10),
    "one barometer of two fails in the climb": lambda log: beside(
        log, "altitude 2 (m)", np.where(log.time < 2.0, log.height, np.interp(2.0, log.time, log.height))
    ),
    "the first barometer of two fails in the climb": lambda log: beside(
        replace(log, height=np.where(log.time < 2.0, log.height, np.interp(2.0, log.time, log.height))),
        "altitude 2 (m)",
        log.height,
    ),
    "a predicted apogee": lambda log: plain(
        log, ("predicted apogee (m)", cells(predicted(log))), ("airbrake extension (%)", cells(0 * log.time + 30))
    ),
    "an estimate beside raw heights": lambda log: plain(
        log,
        ("kf_alt (m)", cells(log.height)),
        ("kf_vel (m/s)", cells(log.speed)),
        ("kf_acc (m/s2)", cells(log.felt - GRAVITY)),
    ),
    "turn rates called gx": lambda log: plain(
        log, *((name, cells(log.rng.normal(0, 20, log.time.size))) for name in ("gx", "gy", "gz"))
    ),
    "letters for names": lambda log: Sheet(
        (
            ("t", integers(1000 * (log.time + WAIT), 40)),
            ("P", cells(log.pressure, 1)),
            ("T", cells(21 + 0 * log.time, 1)),
            ("V", cells(7.4 + 0 * log.time, 2)),
        )
    ),
    "a ground speed": lambda log: beside(log, "speed (m/s)", np.where(log.time > 0, 8.0, 0.0)),
    "a barometer that fails in the climb": lambda log: plain(
        replace(log, height=np.where(log.time < 2.0, log.height, np.interp(2.0, log.time, log.height)))
    ),
    "a barometer alone that fails in the climb": lambda log: without(
        plain(replace(log, height=np.where(log.time < 2.0, log.height, np.interp(2.0, log.time, log.height)))),
        "acceleration (g)",
    ),
    "a barometer that fails at the top": lambda log: plain(
        replace(log, height=np.where(log.time < log.path.apogee_time - 0.5, log.height, log.path.height.max() - 1.2))
    ),
    "a barometer that fails in the descent": lambda log: plain(
        replace(
            log,
            height=np.where(
                log.time < log.path.apogee_time + 5,
                log.height,
                log.height[np.searchsorted(log.time, log.path.apogee_time + 5)],
            ),
        )
    ),
    "an elevator before the flight": lambda log: carried(log, 40.0),
    "a vacuum chamber before the flight": lambda log: carried(log, 800.0),
    "a fast logger, slow on the pad": lambda log: rows(
        plain(log_of(log.path, log.rng, 100.0)), waits(log_of(log.path, log.rng, 100.0).time)
    ),
    "rows of two devices": two_devices,
    "unsigned heights of 32 bits in cm": lambda log: renamed_height(
        log, "altitude (cm)", integers(100 * log.height, 32)
    ),
    "times of arrival in bursts": lambda log: clock(log, "time (s)", cells(np.ceil((log.time + WAIT) * 5) / 5, 2)),
    "whole meters once a second": lambda log: whole_meters(log),
    "remarks among the rows": lambda log: replace(
        plain(log),
        columns=tuple(
            (name, [*column[:300], "# apogee detected" if not place else "", *column[300:]])
            for place, (name, column) in enumerate(plain(log).columns)
        ),
    ),
}
"""Kinds of variants by what was done."""
