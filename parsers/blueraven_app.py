"""Blue Raven, the CSV files of its app: low rate (50 per second, with the barometer) and high rate (500, without).

Several flag columns have the same name; the first one is used. The velocity and the altitude that the logger integrated
drift after landing and are separate from the barometer's. `..._fired` flags keep their own names, because they come
more than a second after the times that the summary states. One file may contain the same flight twice. No public
document names the columns of the high rate: columns named acceleration are used if they read one g before launch or, in
a log without the pad, after landing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np

from fieldkit.flight import Series
from fieldkit.importing import HEAD, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.header import Header, find_header, header_or_damage
from fieldkit.importing.tables.pad_state import along_thrust, marks, scale_at_rest, upright
from fieldkit.importing.tables.text import decode, lines_of
from fieldkit.shapes import Array, Flags, Float
from fieldkit.units import DEGREE, FOOT, STANDARD_GRAVITY, UNITS, Unit

CLOCK = "flight_time_(s)"
CHANNELS: Mapping[str, tuple[str, Unit]] = {
    CLOCK: ("time", Unit(1.0)),
    "temperature_(f)": ("temperature", UNITS["temperature"]["f"]),
    "baro_press_(atm)": ("pressure", UNITS["pressure"]["atm"]),
    "baro_altitude_agl_(feet)": ("altitude", Unit(FOOT)),
    "baro_altitude_asl_(feet)": ("altitude_msl", Unit(FOOT)),
    "batt_volts": ("voltage", Unit(1.0)),
    "velocity_up": ("inertial_speed", Unit(FOOT)),
    "inertial_altitude": ("inertial_altitude", Unit(FOOT)),
    "tilt_angle_(deg)": ("tilt", Unit(DEGREE)),
}
FLAGS = {
    "liftoff": "liftoff",
    "burnout_coast": "burnout",
    "apogee": "apogee",
    "apo_fired": "apo_fired",
    "main_fired": "main_fired",
    "3rd_fired": "3rd_fired",
    "4th_fired": "4th_fired",
}
AXES = ("axis 0", "axis 1", "axis 2")
SCALES = (STANDARD_GRAVITY, 1.0, STANDARD_GRAVITY / 1000)
"""Possible units of acceleration: g, m/s^2 or thousandths of a g. At rest only one of them gives one g."""
REST_TIME, REST_ROWS, REST_SPREAD = 2.0, 20, 0.1
"""End of a log that shows whether the rocket rests after landing [s], its fewest rows [1], and the largest range of an
acceleration at rest, as a fraction of it [1]."""


def _is_low(names: Sequence[str]) -> bool:
    return CLOCK in names and ("baro_altitude_agl_(feet)" in names or "baro_press_(atm)" in names)


def _is_high(names: Sequence[str]) -> bool:
    return CLOCK in names and not _is_low(names) and sum("acc" in name for name in names) >= 3


def _is_either(names: Sequence[str]) -> bool:
    return _is_low(names) or _is_high(names)


def recognises(head: bytes) -> bool:
    return find_header(head, _is_either) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _is_either, f"{CLOCK} with a barometer or three accelerations")
    low = _is_low(head.names)
    channels = head.channels(CHANNELS)
    if low:
        channels += [Channel(f"flag {event}", head.names.index(n)) for n, event in FLAGS.items() if n in head.names]
    else:
        places = [i for i, name in enumerate(head.names) if "acc" in name][:3]
        channels += [Channel(name, place) for name, place in zip(AXES, places, strict=True)]
    parts, found = read_columns(
        log, channels, after=head.row, separator=head.separator, widths={len(head.names)}
    ).flights()
    return [*(_low(part, head, log) if low else _high(part, head, log, found) for part in parts), *found]


def _low(table: LogTable, head: Header, log: bytes) -> Reading:
    time = table.values["time"]
    events = marks(time, {name: table.values.get(f"flag {name}") for name in FLAGS.values()})
    return replace(_reading(table.series(), table, head, log), events=events, part="low")


def _high(table: LogTable, head: Header, log: bytes, notes: list[Parsed]) -> Reading:
    time = table.values["time"]
    axes: Float[Array, "axis row"] = np.array([table.values[name] for name in AXES])
    total: Float[Array, "row"] = np.sqrt((axes**2).sum(axis=0))
    before = time < 0
    rest = before if before.any() else _at_rest_last(time, total)
    scale = scale_at_rest(total[rest], SCALES)
    series = Series(time=time)
    if scale is None:
        notes.append(Note("holds accelerations at rest that are not one g in any unit; left out"))
    else:
        felt = upright(axes * scale, before) if before.any() else along_thrust(time, axes * scale)
        series = Series(time=time, felt=felt, felt_total=total * scale)
    return replace(_reading(series, table, head, log), part="high")


def _at_rest_last(time: Float[Array, "row"], total: Float[Array, "row"]) -> Flags:
    """The last seconds of a log that lacks the pad, if the rocket rests in them; none if it moves."""
    last = time > time[-1] - REST_TIME
    level, spread = float(np.median(total[last])), float(np.ptp(total[last]))
    at_rest: Flags = last & bool(last.sum() >= REST_ROWS and spread < REST_SPREAD * level)
    return at_rest


def _reading(series: Series, table: LogTable, head: Header, log: bytes) -> Reading:
    lift_off = _lift_off(table, head, log)
    return Reading({"date_time": lift_off} if lift_off else {}, series=series, device="Blue Raven")


def _lift_off(table: LogTable, head: Header, log: bytes) -> datetime | None:
    """When the clock of a flight was zero; only the date if a spreadsheet has corrupted the time of day."""
    lines = lines_of(decode(log[:HEAD]))
    row = int(table.rows[0])
    places = [head.place(name) for name in ("year", "month", "day", "time")]
    if row > len(lines) or None in places:
        return None
    cells = lines[row - 1].split(head.separator)
    try:
        year, month, day, clock = (cells[place].strip() for place in places if place is not None)
        date = datetime(int(year), int(month), int(day))
        if clock.count(":") < 2:
            return date
        return datetime.fromisoformat(f"{date:%Y-%m-%d}T{clock}") - timedelta(seconds=float(table.values["time"][0]))
    except (ValueError, OverflowError, IndexError):
        return None


PARSER = Parser(
    "Blue Raven app (low or high rate)",
    recognises,
    read,
    signs=("Flight_Time_(s)", "Sync", "Baro_Press_(atm)|Accel_X", "Baro_Altitude_AGL_(feet)|Gyro_X"),
)
