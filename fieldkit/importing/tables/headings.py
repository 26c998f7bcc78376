"""Interpret the header of a table of samples: the channel of `Series` that a column contains, and its unit.

Every logger and every team has its own column names: `Alt (ft)`, `altitude[m]`, `timestamp_seconds`, `Velocity Feet /
Sec`. A name identifies a channel only if a single meaning remains; predicted, angular or lateral values are excluded. A
unit is never assumed; a header without one has none.
"""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass

from fieldkit.units import Unit, named, plain

QUANTITIES: Mapping[str, str] = {
    "time": "time",
    "altitude": "length",
    "altitude_msl": "length",
    "pressure": "pressure",
    "speed": "speed",
    "acceleration": "acceleration",
    "felt": "acceleration",
    "felt_x": "acceleration",
    "felt_y": "acceleration",
    "felt_z": "acceleration",
    "felt_total": "acceleration",
    "inertial_altitude": "length",
    "inertial_speed": "speed",
    "gps_altitude_msl": "length",
    "gps_speed": "speed",
    "latitude": "degree",
    "longitude": "degree",
    "tilt": "angle",
    "temperature": "temperature",
    "voltage": "voltage",
    "thrust": "force",
    "drag": "force",
    "mass": "mass",
}
"""Channels of `Series`, and the three axes of an accelerometer, with the quantity that determines their units."""

DEGREES = {"deg": Unit(1.0), "°": Unit(1.0), "": Unit(1.0)}
"""Latitude and longitude are in degrees unless another unit is given."""


@dataclass(frozen=True, slots=True)
class Heading:
    """A header as spelled, its words without the unit in brackets, and that unit; "" if there is none."""

    spelled: str
    words: tuple[str, ...]
    unit: str = ""


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


_BRACKETS = re.compile(r"[(\[{]([^()\[\]{}]*)[)\]}]")
_HEIGHT_ZERO = re.compile(r"(.*?)\s{1,4}((?:above )?(?:AGL|A?MSL|ASL|ground|sea)(?: level)?)", re.IGNORECASE)
"""A unit with the zero of a height: `ft AGL`, `m above sea level`."""
_REFERENCES = frozenset({"sea", "qnh", "slp", "reference", "msl"})
"""Words of a pressure that is that of the day, not that of a sample."""
_QUALIFIERS = _set("x y z agl msl asl raw filtered baro gps imu kf est")
"""Texts in brackets that are not units."""
_SENSORS = _set("baro barometric accel inertial gps")
"""Words beside a unit in brackets that name the sensor of a height or speed: `Baro-Ft`, `m, gps`."""


def heading(spelled: str) -> Heading:
    """Split a header: `Alt (ft)` is the word `alt` and the unit `ft`."""
    spelled = "".join(char for char in spelled if unicodedata.category(char) != "Cf").strip()
    name, unit = spelled, ""
    for match in reversed(list(_BRACKETS.finditer(spelled))):
        inside = match[1].strip()
        if inside.lower() not in _QUALIFIERS:
            above = _HEIGHT_ZERO.fullmatch(inside)
            unit, also = (above[1], above[2]) if above else (inside, "")
            unit, sensor = _without_sensor(unit)
            also = f"{also} {sensor}"
            name = f"{spelled[: match.start()]} {also} {spelled[match.end() :]}"
            break
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return Heading(spelled, tuple(re.findall(r"[^\W_]+(?:'s)?|/", name.lower())), unit)


def _without_sensor(text: str) -> tuple[str, str]:
    """The unit in a text, and the sensor that it names beside it; "" if none."""
    for mark in "-,; ":
        before, after = text.partition(mark), text.rpartition(mark)
        for sensor, unit in ((before[0], before[2]), (after[2], after[0])):
            if sensor.strip().lower() in _SENSORS and unit.strip():
                return unit.strip(), sensor.strip()
    return text, ""


def unit_named(quantity: str, text: str) -> Unit | None:
    """The unit of a quantity that a text names in any spelling, or None."""
    if quantity == "degree":
        return DEGREES.get(plain(text))
    return named(quantity, text)


def stated_unit(head: Heading, channel: str) -> str:
    """The unit that a header states for a channel, in its own spelling; "" if it states none.

    It is in brackets or at the end of the name: `time_ms`, `Velocity Feet / Sec`.
    """
    quantity = QUANTITIES[channel]
    if head.unit:
        return head.unit
    if quantity == "degree":
        return "deg"
    if " ".join(head.words) in (*_FEET, *map(" ".join, _SECONDS)):
        return head.words[0]
    for length in (5, 4, 3, 2, 1):
        if len(head.words) > length:
            ending = "".join(head.words[-length:])
            if unit_named(quantity, ending):
                return ending
    return ""


_NOT_A_SAMPLE = _set(
    "predicted prediction predictor target max maximum min apogee gyro angular rate rotation mag magnetic "
    "maximale maxima massima "
    "magnetometer quaternion quat error sd std variance covariance var bias offset wind horizontal "
    "lateral ground sats hdop vdop dop horz north east motor chamber dynamic differential pitot "
    "velocity_pressure total_pressure derivative jerk pad home distance range stage flag flags count id "
    "deployment threshold setting index limit station receiver groundstation"
)
"""Words of columns that are not samples of a channel: limits, other sensors, other directions, counters."""
_WORKED_OUT = _set("est estimated estimate kalman kf ekf filtered filter fused inertial integrated smoothed world")
"""Words of values that a filter or an integration computed."""
_TIME = _set(
    "time t ts timestamp millis micros elapsed met timems times clock epoch unix unixtime "
    "zeit temps tiempo tempo tijd tid čas czas время час idő aika 时间 時間 시간"
)
_HEIGHT = _set(
    "alt altitude height altura hoehe höhe altitud hauteur altezza quota hoogte höjd højde høyde wysokość výška "
    "altitudine высота висота yükseklik magasság korkeus 高度 고도"
)
_SPEED = _set("velocity vel speed veloc vz velz vely velx")
_ACCEL = _set("accel acceleration acc a accelerometer ax ay az accx accy accz accelx accely accelz")
_PRESSURE = _set(
    "pressure press pres baro barometer druck luftdruck pression presión pressione luchtdruk lufttryck tlak"
)
_GPS = _set("gps gnss")
_TOTAL = _set("total magnitude norm resultant mag abs sum")
_CLOCK_ORIGIN_WORDS = _set("since from launch liftoff lift off ignition start startup boot power on begin beginning")
"""Words of a clock that name its origin."""
_SECONDS = (("sec",), ("secs",), ("seconds",))
"""Names of a clock that are its unit."""
_FEET = ("feet", "ft", "feet agl", "ft agl", "meters", "meters agl", "metres")
"""Names of a height that are its unit."""
_LETTERS = {"h": ("altitude", "length"), "p": ("pressure", "pressure")}
"""Letters that are names if a unit of their quantity is next to them."""


def channel(head: Heading) -> str:
    """The channel that a header names unambiguously, or "".

    `acceleration` without a word about gravity may be felt or net: the result is `felt?`.
    """
    words = set(head.words)
    if short := _unit_or_letter(head):
        return short
    if words & _HEIGHT and {"above", "ground"} <= words:
        words -= {"ground"}
    if words & _TIME and words & {"since", "from"} and words <= _TIME | _CLOCK_ORIGIN_WORDS:
        return "time"
    if unit_named("acceleration", head.unit) and words and words <= {*"xyz", "axis", *_TOTAL}:
        return next((f"felt_{axis}" for axis in "xyz" if axis in words), "felt_total")
    if words & _ACCEL and words & (_HEIGHT | _SPEED) and not words & _NOT_A_SAMPLE:  # integrated, not felt
        return "inertial_altitude" if words & _HEIGHT else "inertial_speed"
    if words & _ACCEL and not words & (_NOT_A_SAMPLE - {"mag", "max"}):
        return _acceleration(words)
    if words & _NOT_A_SAMPLE:
        return ""
    if words & _HEIGHT or words & {"agl"}:
        return _height(words)
    if words & _WORKED_OUT:
        return ""
    if words & _PRESSURE and not words & _SPEED:
        return _pressure(head)
    if words & _SPEED:
        if words & {"x", "y", "velx", "vely"} or unit_named("pressure", head.unit):  # sideways, or a dynamic pressure
            return ""
        return "gps_speed" if words & _GPS else "speed"
    if words & _TIME and not words & {*_GPS, "update", "utc", "to", "since", "last"}:
        return "time"
    return _others(words)


def _unit_or_letter(head: Heading) -> str:
    """The channel of a header that is only a unit, or a letter beside a unit of its quantity."""
    name = " ".join(head.words)
    if name in _FEET:
        return "altitude"
    if head.words in _SECONDS:
        return "time"
    first = next(iter(head.words), "")
    letter, quantity = _LETTERS.get(first, ("", ""))
    unit = head.unit if name == first and head.unit else "".join(head.words[1:])
    return letter if letter and unit_named(quantity, unit) else ""


def _acceleration(words: set[str]) -> str:
    if words & {*_WORKED_OUT, "linear", "lin"}:
        return ""
    if axis := next((axis for axis in "xyz" if words & {axis, f"a{axis}", f"acc{axis}", f"accel{axis}"}), ""):
        return f"felt_{axis}"
    if words & _TOTAL:
        return "felt_total"
    return "acceleration" if words & {"vertical", "net"} else "felt?"


def _height(words: set[str]) -> str:
    if words & _WORKED_OUT:
        return "inertial_altitude" if words & {"inertial", "integrated"} and not words & _GPS else ""
    if words & _GPS:
        return "gps_altitude_msl"
    return "altitude_msl" if words & {"msl", "asl", "sea"} else "altitude"


def _pressure(head: Heading) -> str:
    if unit_named("length", head.unit):
        return "altitude"
    return "" if _REFERENCES & set(head.words) else "pressure"


def barometric(head: Heading) -> bool:
    """Whether a header names a height that a filter derived from a barometer, which is used if there is no other."""
    words = set(head.words)
    return bool(words & _HEIGHT and words & _PRESSURE) and not words & _NOT_A_SAMPLE


_TEMPERATURE_WORDS = _set("temperature temp temperatur température temperatura temperatuur")


def _others(words: set[str]) -> str:
    if words & {"lat", "latitude"}:
        return "latitude"
    if words & {"lon", "lng", "long", "longitude"}:
        return "longitude"
    if words & _TEMPERATURE_WORDS:
        return "temperature"
    if words & {"voltage", "volts", "battery", "batt", "vbat"}:
        return "voltage"
    return ""
