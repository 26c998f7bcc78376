"""Tables as spreadsheets of other countries, video overlays, reboots and several devices leave them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bench.mutations.programs import MORNING, same
from bench.mutations.tables import (
    WAIT,
    Kind,
    Log,
    Sheet,
    beside,
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
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

HIGH = 900.0
"""Elevation of a pad, so that heights above the sea pass a thousand. [m]"""
FRAMES = 25
"""Frames of a video per second."""


def above_the_sea(log: Log) -> Float[Array, "row"]:
    """Heights above the sea. [m]"""
    return log.height + HIGH


def by_thousands(values: Float[Array, "row"], mark: str, decimals: int = 0) -> list[str]:
    """Numbers with a mark between thousands, and a decimal comma if there are decimals."""
    return [f"{one:,.{decimals}f}".replace(".", "_").replace(",", mark).replace("_", ",") for one in values.tolist()]


def day(log: Log) -> list[str]:
    """Times of day."""
    return texts(log.time + MORNING, "{h:02}:{m:02}:{s:06.3f}")


def in_german(log: Log, name: str, column: list[str]) -> Sheet:
    """A clock of texts beside numbers with decimal commas."""
    sheet = swapped_marks(plain(log))
    return replace(sheet, columns=((name, column), *sheet.columns[1:]))


def high(log: Log, column: list[str]) -> Sheet:
    """Heights of texts beside numbers with decimal commas."""
    sheet = swapped_marks(plain(log))
    return replace(sheet, columns=(sheet.columns[0], ("Höhe (m)", column), sheet.columns[2]))


def french(log: Log) -> Sheet:
    """French names, units and decimal commas."""
    columns = (
        ("Temps (ms)", integers(1000 * (log.time + WAIT), 40)),
        ("Altitude sol (m)", cells(log.height, 2)),
        ("Vitesse (km/h)", cells(3.6 * log.speed, 1)),
        ("Accélération (m/s²)", cells(log.felt, 2)),
        ("Température (°C)", same(log, 21.5)),
    )
    return swapped_marks(Sheet(columns))


def german_names(log: Log) -> Sheet:
    """German names, units and decimal commas."""
    columns = (
        ("Zeit (s)", cells(log.time + WAIT)),
        ("Luftdruck (hPa)", cells(log.pressure / 100, 2)),
        ("Höhe über Grund (m)", cells(log.height, 2)),
        ("Geschwindigkeit (km/h)", cells(3.6 * log.speed, 1)),
        ("Beschleunigung (g)", cells(log.felt / GRAVITY, 3)),
    )
    return swapped_marks(Sheet(columns))


def rebooted(log: Log) -> Sheet:
    """A logger that restarts on the way down, with its clock at zero again."""
    fell = log.time > log.path.apogee_time + 4
    since = np.where(fell, log.time - log.path.apogee_time - 4, log.time + WAIT)
    return clock(log, "time (s)", cells(since))


def other_columns_below(log: Log) -> Sheet:
    """The table of a second device below the first, in another order and in feet."""
    other = log_of(log.path, log.rng, 10.0)
    more = Sheet((("Altitude (ft)", cells(other.height / FOOT, 1)), ("Time (s)", cells(other.time + WAIT))))
    return replace(plain(log), below="\n" + more.text().decode())


def second_flight_in_feet(log: Log) -> Sheet:
    """A second, lower flight below the first after the unit was changed, each with a heading."""
    second = renamed_height(replace(log, height=0.7 * log.height), "altitude (ft)", cells(0.7 * log.height / FOOT, 1))
    return replace(plain(log), below=second.text().decode())


def zeroed_at_liftoff(log: Log) -> Sheet:
    """Heights above the sea until the flight is noticed, and above the pad from then on."""
    return plain(replace(log, height=np.where(log.time < 0.3, log.height + 412, log.height)))


def handled(log: Log) -> Sheet:
    """A logger that was shaken and carried before it stood on the pad."""
    long = log_of(log.path, log.rng, wait=60.0)
    shaken = (long.time > -50) & (long.time < -40)
    return plain(replace(long, felt=np.where(shaken, long.rng.normal(GRAVITY, 15, long.time.size), long.felt)))


def dropped(log: Log) -> Sheet:
    """A number of each row without a clock, from which a radio lost some rows."""
    numbered = clock(log, "packet", [str(place) for place in range(log.time.size)])
    kept = np.flatnonzero(log.rng.random(log.time.size) > 0.15)
    return replace(rows(numbered, kept), above="rate: 25 Hz\n")


def errors_of_a_spreadsheet(log: Log) -> Sheet:
    """Cells too narrow for their numbers, and errors of formulas."""
    bad = log.rng.random((2, log.time.size)) < 0.02
    heights = [
        "####" if narrow else "#VALUE!" if wrong else cell
        for cell, narrow, wrong in zip(cells(log.height), *bad.tolist(), strict=True)
    ]
    return renamed_height(log, "altitude (m)", heights)


KINDS: Mapping[str, Kind] = {
    "a German date and time": lambda log: in_german(
        log, "Zeitstempel", [f"14.06.2025 {one.replace('.', ',')}" for one in day(log)]
    ),
    "an American date and time": lambda log: clock(log, "Timestamp", [f"6/14/2025 {one}" for one in day(log)]),
    "an American afternoon to the second": lambda log: clock(
        log, "Time", [f"6/14/2025 {one} PM" for one in texts(np.floor(log.time) + 3600 * 2, "{h}:{m:02}:{s:02.0f}")]
    ),
    "minutes and tenths of a spreadsheet": lambda log: clock(log, "Time", texts(log.time + 1_700, "{m:02}:{s:04.1f}")),
    "a time with a zone": lambda log: clock(log, "timestamp", [f"2025-06-14 {one}+02:00" for one in day(log)]),
    "hours, minutes, seconds and frames": lambda log: clock(
        log,
        "timecode",
        [f"{one[:-4]}:{round(float('0' + one[-4:]) * FRAMES) % FRAMES:02}" for one in day(log)],
    ),
    "milliseconds with commas in quotes": lambda log: clock(
        log, "time (ms)", [f'"{one:,.0f}"' for one in (1000 * (log.time + WAIT)).tolist()]
    ),
    "milliseconds with points": lambda log: in_german(log, "Zeit (ms)", by_thousands(1000 * (log.time + WAIT), ".")),
    "whole meters with points between thousands": lambda log: high(log, by_thousands(above_the_sea(log), ".")),
    "heights alone with points between thousands": lambda log: Sheet(
        (("Zeit (ms)", integers(1000 * (log.time + WAIT), 40)), ("Höhe (m)", by_thousands(above_the_sea(log), "."))),
        separator=";",
    ),
    "whole feet with commas, between tabs": lambda log: replace(
        renamed_height(log, "Altitude (ft)", [f"{one:,.0f}" for one in (above_the_sea(log) / FOOT).tolist()]),
        separator="\t",
    ),
    "French names and units": french,
    "German names and units": german_names,
    "a reboot on the way down": rebooted,
    "a second device's table below": other_columns_below,
    "a second flight in another unit": second_flight_in_feet,
    "heights zeroed when the flight is noticed": zeroed_at_liftoff,
    "shaken before the flight": handled,
    "numbered packets, some lost": dropped,
    "errors of a spreadsheet": errors_of_a_spreadsheet,
    "two columns of one name": lambda log: plain(log, ("altitude (m)", cells(log.height + log.ground + 25, 1))),
    "a speed in feet per second beside meters": lambda log: beside(log, "speed (ft/s)", log.speed / FOOT),
    "an acceleration in feet per second squared": lambda log: replace(
        plain(log), columns=(*plain(log).columns[:2], ("accel (ft/s^2)", cells(log.felt / FOOT, 2)))
    ),
    "pressures above that of the pad": lambda log: renamed_height(
        log, "pressure change (Pa)", cells(log.pressure - log.pressure[0], 1)
    ),
    "a comma at each end": lambda log: plain(log, ("", [""] * log.time.size)),
    "comments of other programs": lambda log: replace(
        plain(log), above="% exported by a script\n// units: metric\n! 25 Hz\n"
    ),
    "a pressure altitude of a high pad, started in flight": lambda log: rows(
        without(plain(replace(log, height=above_the_sea(log))), "acceleration (g)"), np.flatnonzero(log.time > 0.5)
    ),
    "days with a fraction": lambda log: clock(log, "time (days)", cells((log.time + WAIT) / 86_400, 9)),
    "hours with a fraction": lambda log: clock(log, "time (h)", cells((log.time + WAIT) / 3_600, 7)),
    "a clock that counts down": lambda log: clock(log, "remaining (s)", cells(log.time[-1] - log.time)),
    "a height by the hypsometric equation of a hot day": lambda log: beside(
        log, "true altitude (m)", 1.06 * log.height
    ),
    "an upper stage's heights beside the booster's": lambda log: replace(
        plain(log),
        columns=(
            plain(log).columns[0],
            ("sustainer altitude (m)", cells(log.height)),
            ("booster altitude (m)", cells(0.4 * log.height)),
        ),
    ),
    "meters called feet": lambda log: renamed_height(log, "altitude (ft)", cells(log.height, 2)),
    "a barometer alone, meters called feet": lambda log: without(
        renamed_height(log, "altitude (ft)", cells(log.height, 2)), "acceleration (g)"
    ),
    "a tracker in feet by the name of meters": lambda log: rows(
        Sheet(
            (
                ("time (s)", cells(log.time + WAIT)),
                ("gps altitude (m)", cells((log.height + HIGH + log.rng.normal(0, 1, log.time.size)) / FOOT, 1)),
            )
        ),
        np.arange(0, log.time.size, 5),
    ),
    "a clock that starts at lift-off again": lambda log: clock(
        log, "time (s)", cells(np.where(log.time < 0, log.time + WAIT, log.time))
    ),
    "no clock on the pad": lambda log: clock(log, "time (s)", cells(np.maximum(log.time, 0.0))),
    "tens of feet": lambda log: renamed_height(log, "altitude (ft)", cells(np.round(log.height / FOOT, -1), 0)),
    "an acceleration of zero at rest": lambda log: replace(
        plain(log), columns=(*plain(log).columns[:2], ("accel (g)", cells(log.felt / GRAVITY - 1)))
    ),
    "centimeters without a unit": lambda log: renamed_height(log, "altitude", cells(100 * log.height, 0)),
    "feet and meters without units": lambda log: Sheet(
        (
            ("time", cells(log.time + WAIT)),
            ("alt", cells(log.height / FOOT, 1)),
            ("alt2", cells(log.height, 2)),
        )
    ),
    "pressures that are zero at times": lambda log: renamed_height(
        log, "pressure (Pa)", cells(np.where(log.rng.random(log.time.size) < 0.02, 0.0, log.pressure), 1)
    ),
    "pressures of 16 bits": lambda log: renamed_height(log, "pressure (Pa)", integers(log.pressure, 16)),
    "the highest row once more at the end": lambda log: replace(
        plain(log), below=f"0.000,{float(log.height.max()):.3f},1.000\n"
    ),
    "a semicolon between decimal points": lambda log: replace(plain(log), separator=";"),
    "not a number in words": lambda log: renamed_height(
        log, "altitude (m)", ["inf" if not place % 9 else one for place, one in enumerate(cells(log.height))]
    ),
    "a knot beside meters": lambda log: beside(log, "speed (kn)", log.speed / 0.514444),
    "a speed without a unit in miles per hour": lambda log: beside(log, "speed", log.speed / 0.44704),
    "a heading in capitals without units": lambda log: Sheet(
        (("TIME", cells(log.time + WAIT)), ("BARO ALT", cells(log.height / FOOT, 1)), ("ACCEL", cells(log.felt)))
    ),
    "every height twice": lambda log: plain(replace(log, height=log.height[np.arange(log.time.size) // 2 * 2])),
    "a log of two sticks, one second apart": lambda log: beside(
        log, "altitude 2 (m)", np.interp(log.time - 1.0, log.time, log.height)
    ),
}
"""Kinds of variants by what was done."""
