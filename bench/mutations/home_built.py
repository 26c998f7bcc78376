"""Files of flight computers that teams build: positions, steps of time, lines of logging libraries, JSON, trackers."""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta

from bench.mutations.programs import same
from bench.mutations.tables import (
    WAIT,
    Kind,
    Log,
    Sheet,
    cells,
    clock,
    integers,
    log_of,
    plain,
    renamed_height,
    without,
)
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

START = datetime(2026, 5, 3, 13, 4, 5, tzinfo=UTC)
FIX_RATE, GEOID = 5.0, 18.0
"""Fixes of a tracker [1/s], and its heights above those of a barometer [m]."""
STRAY = 0.1
"""Noise of a position across the flight, and of its speed. [m], [m/s]"""


def stray(log: Log) -> list[str]:
    """A sideways position or speed."""
    return cells(log.rng.normal(0, STRAY, log.time.size))


def position(log: Log, names: str, up: int, *, unit: float = 1e6) -> Sheet:
    """A clock without a unit, a position and its speed by their names, without units; the third axis points up (1) or
    down (-1)."""
    time, *axes = names.split()
    values = [up * log.height, up * log.speed]
    columns = [(time, integers(unit * (log.time + WAIT), 50))]
    for three, value in zip((axes[:3], axes[3:]), values, strict=True):
        columns += [(three[0], stray(log)), (three[1], stray(log)), (three[2], cells(value))]
    return Sheet(tuple(columns))


def steps(log: Log, name: str, unit: float) -> Sheet:
    """The time since the row before instead of a clock. [1/s]"""
    times = [int(one) for one in integers(unit * (log.time + WAIT), 50)]
    return clock(log, name, [str(now - before) for before, now in zip([times[0], *times], times, strict=False)])


def lines(log: Log, line: Callable[[float, float, float, float], str], above: str = "") -> Sheet:
    """A text with a line for each sample: of its time [s], height [m], speed [m/s] and pressure [Pa]."""
    samples = (values.tolist() for values in (log.time + WAIT, log.height, log.speed, log.pressure))
    return Sheet((), other="\n".join([above, *(line(*sample) for sample in zip(*samples, strict=True)), ""]).encode())


def numbers(values: Float[Array, "row"]) -> list[float]:
    return [round(one, 3) for one in values.tolist()]


def document(log: Log, form: str) -> Sheet:
    """A JSON document of columns, or of their names and rows."""
    columns = {
        "time_s": numbers(log.time + WAIT),
        "altitude_m": numbers(log.height),
        "acc_g": numbers(log.felt / GRAVITY),
    }
    rows = [list(row) for row in zip(*columns.values(), strict=True)]
    forms = {
        "columns": {"rocket": "a", "log": columns},
        "numbered": {name: {str(i): one for i, one in enumerate(column)} for name, column in columns.items()},
        "rows": {"columns": list(columns), "data": rows},
        "objects": [dict(zip(columns, row, strict=True)) for row in rows],
    }
    return Sheet((), other=json.dumps(forms[form]).encode())


def tracker(log: Log, name: str, unit: float = 1.0) -> Sheet:
    """Fixes of a tracker: a position, and a height above the sea without a unit."""
    fixes = log_of(log.path, log.rng, FIX_RATE)
    high = (fixes.height + fixes.ground + GEOID) / unit
    columns = (("time (s)", fixes.time + WAIT), ("lat", 47 + 0 * fixes.time), ("lon", 8 + 0 * fixes.time), (name, high))
    return Sheet(tuple((title, cells(values)) for title, values in columns))


def training(log: Log) -> Sheet:
    """A track of a watch, as TCX."""
    points = []
    for time, height in zip(log.time[::5].tolist(), (log.height + log.ground)[::5].tolist(), strict=True):
        when = (START + timedelta(seconds=time)).isoformat(timespec="milliseconds")
        points.append(
            f"<Trackpoint><Time>{when}</Time><Position><LatitudeDegrees>47.1</LatitudeDegrees><LongitudeDegrees>8.2"
            f"</LongitudeDegrees></Position><AltitudeMeters>{height:.2f}</AltitudeMeters></Trackpoint>"
        )
    return Sheet(
        (), other=f"<TrainingCenterDatabase><Track>{''.join(points)}</Track></TrainingCenterDatabase>".encode()
    )


def satellite_contest(log: Log) -> Sheet:
    """The telemetry of a contest of can-sized satellites: once a second, in whole seconds."""
    slow = log_of(log.path, log.rng, 1.0)
    when = [f"{START + timedelta(seconds=round(one)):%H:%M:%S}" for one in slow.time.tolist()]
    columns = (
        ("TEAM_ID", same(slow, 3174)),
        ("MISSION_TIME", when),
        ("PACKET_COUNT", [str(place) for place in range(slow.time.size)]),
        ("STATE", ["ASCENT"] * slow.time.size),
        ("ALTITUDE", cells(slow.height, 1)),
        ("TEMPERATURE", same(slow, 21.4)),
        ("PRESSURE", cells(slow.pressure / 1000, 1)),
        ("GPS_ALTITUDE", cells(slow.height + slow.ground, 1)),
    )
    return Sheet(columns)


def forces(log: Log, name: str, values: Float[Array, "row"]) -> Sheet:
    """Another acceleration."""
    return replace(plain(log), columns=(*plain(log).columns[:2], (name, cells(values))))


KINDS: Mapping[str, Kind] = {
    "a position without units that points down": lambda log: position(log, "timestamp x y z vx vy vz", -1),
    "north, east and down without units": lambda log: position(log, "TimeUS PN PE PD VN VE VD", -1),
    "a position in words that points down": lambda log: position(log, "time_ms north east down vn ve vd", -1, unit=1e3),
    "a position without units that points up": lambda log: position(
        log, "time pos_x pos_y pos_z vx vy vz", 1, unit=1e3
    ),
    "a speed that points down": lambda log: plain(log, ("vel_d (m/s)", cells(-log.speed))),
    "milliseconds since the row before": lambda log: steps(log, "dt_ms", 1e3),
    "microseconds since the row before, without a unit": lambda log: steps(log, "deltaT", 1e6),
    "steps beside a clock": lambda log: plain(log, ("dt (ms)", same(log, 40))),
    "lines of the ESP32's library": lambda log: lines(
        log, lambda t, h, v, p: f"I ({1000 * t:.0f}) flight: alt={h:.2f} vel={v:.2f}"
    ),
    "lines of the ESP32's library in color, with units": lambda log: lines(
        log,
        lambda t, h, v, p: f"\x1b[0;32mI ({1000 * t:.0f}) FC: Alt: {h:.2f} m, Press: {p / 100:.2f} hPa\x1b[0m",
    ),
    "rows of the ESP32's library": lambda log: lines(
        log, lambda t, h, v, p: f"I ({1000 * t:.0f}) FC: {h:.2f},{p:.1f}", "I (390) FC: alt_m,press_pa"
    ),
    "lines of Arduino for the ESP32": lambda log: lines(
        log, lambda t, h, v, p: f"[{1000 * t:6.0f}][I][main.cpp:42] loop(): alt={h:.2f}, p={p:.1f}"
    ),
    "seconds in brackets before each line": lambda log: lines(
        log, lambda t, h, v, p: f"[{t:9.3f}] ALT: {h:.2f} m VEL: {v:.2f} m/s"
    ),
    "JSON lines with a date": lambda log: lines(
        log, lambda t, h, v, p: json.dumps({"timestamp": (START + timedelta(seconds=t)).isoformat(), "altitude": h})
    ),
    "JSON of columns": lambda log: document(log, "columns"),
    "JSON of numbered columns": lambda log: document(log, "numbered"),
    "JSON of names and rows": lambda log: document(log, "rows"),
    "JSON of objects": lambda log: document(log, "objects"),
    "a tracker without a unit": lambda log: tracker(log, "gps_alt"),
    "a tracker in feet without a unit": lambda log: tracker(log, "gps_alt", FOOT),
    "a tracker's elevation": lambda log: tracker(log, "elevation"),
    "a track of a watch": training,
    "telemetry of a contest": satellite_contest,
    "a magnitude of the acceleration": lambda log: forces(log, "acceleration (g)", abs(log.felt) / GRAVITY),
    "a magnitude without gravity": lambda log: forces(log, "acceleration (m/s2)", abs(log.felt - GRAVITY)),
    "a magnitude without a unit": lambda log: forces(log, "acceleration", abs(log.felt) / GRAVITY * 1000),
    "the time of the loop beside a clock": lambda log: replace(
        plain(log),
        columns=(("loop_time_us", cells(900 + abs(log.rng.normal(0, 50, log.time.size)), 0)), *plain(log).columns),
    ),
    "pressures in psia": lambda log: without(
        renamed_height(log, "Static Pressure (psia)", cells(log.pressure / 6894.757, 4)), "acceleration (g)"
    ),
}
"""Kinds of variants by what was done."""
