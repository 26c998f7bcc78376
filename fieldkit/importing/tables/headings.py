"""Interpret the header of a table of samples: the channel of `Series` that a column contains, and its unit.

Every logger and every team has its own column names: `Alt (ft)`, `altitude[m]`, `timestamp_seconds`, `Velocity Feet /
Sec`, `Höhe in m`. The words are in `fieldkit/data/sample_columns.toml`. A name identifies a channel only if a single
meaning remains; predicted, angular or lateral values are excluded. A unit is never assumed; a header without one has
none.
"""

import re
import tomllib
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files

from fieldkit.units import UNITS, Unit, is_unit, named, plain

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

CLOCK_UNITS = (("ms",), ("us",), ("s",))
"""Names of a first column that is a clock if the table has no other: the unit of its times."""
DEGREES = {"deg": Unit(1.0), "°": Unit(1.0), "": Unit(1.0)}
"""Latitude and longitude are in degrees unless another unit is given."""


@dataclass(frozen=True, slots=True)
class Heading:
    """A header as spelled, its words without the unit beside them, and that unit; "" if there is none."""

    spelled: str
    words: tuple[str, ...]
    unit: str = ""


def folded(text: str) -> str:
    """A text in lower case without accents."""
    decomposed = unicodedata.normalize("NFD", text.lower())
    return unicodedata.normalize("NFC", "".join(char for char in decomposed if unicodedata.category(char) != "Mn"))


def _known_words() -> dict[str, dict[str, frozenset[str]]]:
    """The words of headers by section and meaning."""
    known = tomllib.loads(files("fieldkit").joinpath("data/sample_columns.toml").read_text(encoding="utf-8"))
    return {
        section: {meaning: frozenset(folded(words).split()) for meaning, words in meanings.items()}
        for section, meanings in known.items()
    }


KNOWN_WORDS = _known_words()
"""The words of headers, without accents, by section of the data file and meaning."""
_NAMES, _WITH_UNIT, _ROLES = KNOWN_WORDS["quantities"], KNOWN_WORDS["with_unit"], KNOWN_WORDS["roles"]
_NOT_A_SAMPLE = frozenset().union(*KNOWN_WORDS["not_a_sample"].values())
"""Words of columns that are not samples of a channel: limits, other sensors, other directions, counters."""
_ONE_MEANING = {
    name: frozenset(word for word in _NAMES[name] if len(word) > 3) - _NAMES["time"]
    for name in ("temperature", "voltage")
}
"""Words that mean a temperature or a voltage whatever else a name says."""
_TIME, _HEIGHT, _SPEED = _NAMES["time"], _NAMES["height"], _NAMES["speed"]
_ACCEL, _PRESSURE = _NAMES["acceleration"], _NAMES["pressure"]
_MEASURED = _HEIGHT | _SPEED | _ACCEL | _PRESSURE | _NAMES["temperature"]
"""Words of what a sensor measures."""
_NUMBERED = frozenset().union(*_NAMES.values()) - frozenset("abcdefghijklmnopqrstuvwxyz")
"""Words that a logger with several sensors numbers: `alt1`, `pressure2`."""
_QUALIFIERS = frozenset(
    {"x", "y", "z", "raw"}
    | {word for section in KNOWN_WORDS.values() for words in section.values() for word in words if len(word) > 1}
)
"""Texts in brackets that are not units."""
_REFERENCES = frozenset({"qnh", "slp", "reference"}) | _ROLES["sea_level"]
"""Words of a pressure that is that of the day, not that of a sample."""
_SENSORS = frozenset({"baro", "barometric", "accel", "inertial", "gps", "agl", "msl", "asl", "amsl"})
"""Words beside a unit in brackets that name the sensor or the zero of a height: `Baro-Ft`, `m, gps`, `ft AGL`."""
_AFTER_UNITS = _SENSORS | {"x", "y", "z", "up", "raw"}
"""Words that may follow a unit that is not in brackets: `alt_ft_msl`, `accel_g_x`."""
_NEW_WORD = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z]{2})(?=[A-Z][a-z]{2})")
"""Where a word begins in `baroAlt` and in `GPSTime`."""
_BRACKETS = re.compile(r"[(\[{]([^()\[\]{}]*)[)\]}]")
_HEIGHT_ZERO = re.compile(r"(.*?)[,;]?\s{1,4}((?:above )?(?:ground|sea)(?: level)?)", re.IGNORECASE)
"""A unit with the zero of a height: `m above sea level`."""
_G_FORCE = re.compile(r"\bg[ _-]force|(?<![^\W_])(?:high|low)[ _-]?g(?![^\W_])", re.IGNORECASE)
"""An acceleration in two words, or the sensor of one: `HighG_X`."""
_SCALED = re.compile(r"[x×]?\s?(\d{1,6}(?:\.\d{1,6})?)(?:/(\d{1,6}))?\s?([^\W\d].{0,10})")
"""A multiple or a fraction of a unit: `10ms`, `1/100 s`, `0.1 m`."""
_MULTIPLIED = re.compile(r"([^\W\d].{0,10}?)\s?[*x×]\s?(10{1,6})")
"""A unit whose numbers were multiplied to be whole: `Pa*10`."""
_QUOTIENT = re.compile(r"([^/]{1,40}?)\s?/\s?(\([^()]{1,12}\)|[^\s()]{1,12})")
"""A name divided by its unit: `h/m`, `v/(m/s)`."""


def heading(spelled: str) -> Heading:
    """Split a header: `Alt (ft)` is the word `alt` and the unit `ft`."""
    spelled = _decoded("".join(char for char in spelled if unicodedata.category(char) != "Cf").strip())
    name, unit = _divided(spelled) or _bracketed(spelled) or (spelled, _unknown_unit(spelled))
    name = _G_FORCE.sub("gforce", _NEW_WORD.sub(" ", name))
    words = re.findall(r"[^\W_]+(?:'s)?|/", folded(name))
    return Heading(
        spelled, tuple(word[:-1] if word[:-1] in _NUMBERED and word[-1].isdecimal() else word for word in words), unit
    )


def _decoded(text: str) -> str:
    """A name whose UTF-8 a spreadsheet took for Windows-1252 and saved: `Höhe` instead of `HÃ¶he`."""
    if "Ã" not in text and "Â" not in text:
        return text
    try:
        return text.encode("cp1252").decode()
    except UnicodeError:
        return text


def _divided(spelled: str) -> tuple[str, str] | None:
    """A name and the unit that it is divided by: `h/m`, but not `ft/s` or `Feet / Sec`."""
    match = _QUOTIENT.fullmatch(spelled)
    if match is None or not is_unit(match[2].strip("()")):
        return None
    quotient_of_units = not match[2].startswith("(") and is_unit(re.split(r"[\s_]+", match[1])[-1])
    return None if quotient_of_units else (match[1], match[2].strip("()"))


def _bracketed(spelled: str) -> tuple[str, str] | None:
    """A name without the unit in its brackets, and that unit."""
    for match in reversed(list(_BRACKETS.finditer(spelled))):
        inside = match[1].strip()
        zero = _HEIGHT_ZERO.fullmatch(inside)
        unit, also = (zero[1], zero[2]) if zero else _without_sensor(inside)
        if is_unit(unit) and inside.lower() not in _QUALIFIERS - {"min"}:
            return f"{spelled[: match.start()]} {also} {spelled[match.end() :]}", unit
    return None


def _without_sensor(text: str) -> tuple[str, str]:
    """The unit in a text, and the sensor or zero that it names beside it; "" if none."""
    for mark in "-,; ":
        before, after = text.partition(mark), text.rpartition(mark)
        for sensor, unit in ((before[0], before[2]), (after[2], after[0])):
            if sensor.strip().lower() in _SENSORS and unit.strip():
                return unit.strip(), sensor.strip()
    return text, ""


def _unknown_unit(spelled: str) -> str:
    """What the brackets of a name contain, if it may be a unit of another program; the unit in front of them if there
    is one, as in `Pressure, psi (S/N 12)`."""
    inside = [text for match in _BRACKETS.finditer(spelled) if (text := match[1].strip())]
    unknown = [text for text in inside if not set(re.findall(r"[^\W_]+", folded(text))) <= _QUALIFIERS]
    before = re.split(r"[\s_,]+", spelled.partition("(")[0].strip())
    if unknown and len(before) > 1 and before[-1].lower() != "in" and is_unit(before[-1]):
        return before[-1]
    return unknown[-1] if unknown else ""


def unit_named(quantity: str, text: str) -> Unit | None:
    """The unit of a quantity that a text names in any spelling, or None."""
    if quantity == "degree":
        return DEGREES.get(plain(text))
    if quantity == "time" and text.strip() == "h":  # beside no other quantity, where it is a height
        return UNITS["time"]["hr"]
    scaled = _SCALED.fullmatch(text.strip())
    unit = named(quantity, scaled[3]) if scaled else None
    if scaled and unit and not unit.offset and float(scaled[1]) > 0 and float(scaled[2] or 1) > 0:
        times = float(scaled[1]) / float(scaled[2] or 1)
        is_range = quantity == "acceleration" and times > 1  # `accel (16 g)` is that of the sensor
        return unit if is_range else Unit(unit.factor * times)
    if (multiplied := _MULTIPLIED.fullmatch(text.strip())) and (unit := named(quantity, multiplied[1])):
        return None if unit.offset else Unit(unit.factor / float(multiplied[2]))
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
    if only := _only_a_unit(head):
        return "".join(head.words) if only == "pressure" else head.words[0]
    return "".join(head.words[place] for place in _unit_words(head, quantity))


def _unit_words(head: Heading, quantity: str) -> range:
    """The places of the words that spell a unit of a quantity: at the end of a name or before words that say where its
    zero is or which axis it has, as in `alt_ft_msl`; empty if there are none. A length is one word: `pos_d_m` are no
    decimeters."""
    end = len(head.words)
    while True:
        for start in range(max(1, end - (1 if quantity == "length" else 5)), end):
            if unit_named(quantity, "".join(head.words[start:end])):
                return range(start, end)
        if end < 2 or head.words[end - 1] not in _AFTER_UNITS:
            return range(0)
        end -= 1


def _only_a_unit(head: Heading) -> str:
    """The channel of a name that is only a unit, `Seconds`, `Feet AGL` or `mBar`; "" if it is not."""
    first, rest = next(iter(head.words), ""), head.words[1:]
    if len(whole := "".join(head.words)) > 2 and unit_named("pressure", whole):
        return "pressure"
    if not rest and len(first) > 2 and first not in ("min", "hour") and unit_named("time", first):  # `hour` of a day
        return "time"
    is_height = plain(first) in ("m", "ft") and len(first) > 1
    return "altitude" if is_height and rest in ((), ("agl",)) else ""


def channel(head: Heading) -> str:
    """The channel that a header names unambiguously, or "".

    `acceleration` without a word about gravity may be felt or net: the result is `felt?`. `Altitude rate (m/s)` has the
    unit of another quantity and is no altitude.
    """
    name = _named_channel(head)
    other = name and is_unit(head.unit) and not unit_named(QUANTITIES[name.rstrip("?")], head.unit)
    return "" if other else name


def _named_channel(head: Heading) -> str:
    """The channel that the words of a header name, or ""."""
    words = set(head.words)
    if short := _only_a_unit(head) or _beside_unit(head):
        return short
    if not words & (_NOT_A_SAMPLE - {"dynamic", "mag", "total_pressure"}):  # a sensor beside it: `baro_temperature`
        for name in ("temperature", "voltage"):
            if words & _ONE_MEANING[name] and _of_quantity(head, name):
                return name
    if words & _TIME and head.words[-1] == "min":  # minutes, not a minimum
        words -= {"min"}
    if words & _HEIGHT and words & _ROLES["above"]:
        words -= _ROLES["ground"] | {"pad", "home"}
    if words & _HEIGHT and not words & {"du", "del", "do"}:  # `hauteur sol` is above it, `altitude du sol` its own
        words -= {"sol", "suelo", "suolo"}
    if _is_clock(words) or is_time_step(head) or is_sensor_clock(head):
        return "time"
    if unit_named("acceleration", head.unit) and words and words <= {*"xyz", "axis", *_ROLES["total"]}:
        return next((f"felt_{axis}" for axis in "xyz" if axis in words), "felt_total")
    accelerations = words & _ACCEL
    if words & (_HEIGHT | _SPEED | _PRESSURE | _NAMES["temperature"]):
        accelerations -= {"a"}  # also a word of sentences
    if accelerations and words & (_HEIGHT | _SPEED) and not words & _NOT_A_SAMPLE:  # integrated, not felt
        return "inertial_altitude" if words & _HEIGHT else "inertial_speed"
    if accelerations and not words & (_NOT_A_SAMPLE - {"mag", "max"}):
        return _acceleration(words)
    if words & (_NOT_A_SAMPLE | _ROLES["ground"]):
        return ""
    if words & _HEIGHT or words & {"agl"}:
        return _height(words)
    if words & _ROLES["worked_out"]:
        return ""
    if words & _PRESSURE and not words & _SPEED:
        return "time" if words & _TIME and not is_pressure(head) else _pressure(head)  # `baro_time` is a clock
    if words & _SPEED:
        if words & {"x", "y", "velx", "vely"} or unit_named("pressure", head.unit):  # sideways, or a dynamic pressure
            return ""
        return "gps_speed" if words & _ROLES["gps"] else "speed"
    if words & _TIME and not words & {*_ROLES["gps"], "update", "utc", "to", "since", "last", "loop", "latency", "age"}:
        return "time"
    return next((name for name in ("latitude", "longitude", "temperature", "voltage") if words & _NAMES[name]), "")


def _beside_unit(head: Heading) -> str:
    """The channel of a name that means one only beside its unit: `h_m`, `z (ft)`, `climb rate (m/s)`."""
    for name, meanings in _WITH_UNIT.items():
        quantity = QUANTITIES[name]
        tail = range(0) if head.unit else _unit_words(head, quantity)
        words = {word for place, word in enumerate(head.words) if place not in tail}
        words -= {"rate", "of", "axis"}
        if not is_unit(head.unit):  # `ticks (10 ms)`, whose name still has its brackets
            words -= set(re.findall(r"[^\W_]+", folded(head.unit)))
        if words and words <= meanings and (tail or unit_named(quantity, head.unit)):
            return name
    return ""


def is_receiver_clock(head: Heading) -> bool:
    """Whether a name is the clock of a satellite receiver, which is another one beside a logger's own: `UTC`,
    `GPSTime`."""
    words = {*head.words}
    receiver = words & {"utc", *_ROLES["gps"]}
    return head.words == ("utc",) or (bool(receiver) and bool(words & _TIME) and words - receiver <= _TIME)


def _of_quantity(head: Heading, channel: str) -> bool:
    """Whether the unit beside a name, if there is one, is of the quantity of a channel."""
    return not is_unit(head.unit) or unit_named(QUANTITIES[channel], head.unit) is not None


def _is_clock(words: set[str]) -> bool:
    """Whether a name is a time since something: `time from launch`, `seconds_since_boot`."""
    units = {word for word in words if len(word) > 2 and unit_named("time", word)}
    since = words & {"since", "from", "seit", "depuis", "desde"}
    return bool(since and words & _TIME | units) and words <= _TIME | units | _ROLES["clock_origin"]


def is_sensor_clock(head: Heading) -> bool:
    """Whether a header names the clock of one sensor: `Altitude Time (sec)`, `accel_time_ms`."""
    words = {word for word in head.words if len(word) > 2 or word in _TIME}
    words -= {word for word in words - _TIME if unit_named("time", word)}
    clock = bool(words & _TIME) and unit_named("time", stated_unit(head, "time")) is not None
    return clock and bool(words - _TIME) and words <= _TIME | _MEASURED


def is_time_step(head: Heading) -> bool:
    """Whether a header names the time since the row before: `dt (s)`, `delta_time_ms`, `time since last sample`."""
    words = {word for word in head.words if len(word) < 2 or not unit_named("time", word)}
    steps = words & {"dt", "deltat", "timestep"} or (words & {"t", "time"} and words & _STEP_MARKS)
    return bool(steps) and words <= _STEP_WORDS


_STEP_MARKS = frozenset({"delta", "step", "interval", "last"})
"""Words beside `time` of a time since the row before."""
_STEP_WORDS = _STEP_MARKS | {"dt", "deltat", "timestep", "t", "time", "since", "sample", "loop", "row"}
"""All words of such a name."""


def _acceleration(words: set[str]) -> str:
    if words & (_ROLES["worked_out"] | _ROLES["linear"]):
        return ""
    if axis := next((axis for axis in "xyz" if words & {axis, f"a{axis}", f"acc{axis}", f"accel{axis}"}), ""):
        return f"felt_{axis}"
    if words & _ROLES["total"]:
        return "felt_total"
    return "acceleration" if words & _ROLES["net"] else "felt?"


def _height(words: set[str]) -> str:
    if words & _ROLES["receiver"]:
        return ""
    if words & _ROLES["worked_out"]:
        return "inertial_altitude" if words & {"inertial", "integrated"} and not words & _ROLES["gps"] else ""
    if words & _ROLES["gps"]:
        return "gps_altitude_msl"
    return "altitude_msl" if words & _ROLES["sea_level"] else "altitude"


def _pressure(head: Heading) -> str:
    unit = stated_unit(head, "altitude") if set(head.words) & _BAROMETER else head.unit
    if plain(unit) in _HEIGHT_UNITS:
        return "altitude"
    return "" if _REFERENCES & set(head.words) else "pressure"


_BAROMETER = frozenset({"baro", "barometer"})
"""Names of the sensor, whose `_m` is a unit; that of `pressure_m` may be a word."""
_HEIGHT_UNITS = ("m", "cm", "km", "ft", "feet")
"""Units in which `baro` is a height: inches and millimeters are those of mercury."""


def barometric(head: Heading) -> bool:
    """Whether a header names a height that a filter derived from a barometer, which is used if there is no other."""
    words = set(head.words)
    return bool(words & _HEIGHT and words & _PRESSURE) and not words & _NOT_A_SAMPLE


def estimated(head: Heading) -> bool:
    """Whether a header names a height that a filter estimated from all sensors, which is used if there is no other."""
    words = set(head.words)
    return bool(words & _HEIGHT and words & _ROLES["worked_out"]) and not words & (_NOT_A_SAMPLE | _ROLES["gps"])


def is_pressure(head: Heading) -> bool:
    """Whether a header states a unit of the pressure of the air and nothing that excludes it: `static_kPa`."""
    unit = stated_unit(head, "pressure")
    excluded = set(head.words) & (_NOT_A_SAMPLE | _REFERENCES)
    return not excluded and plain(unit) not in ("in", "") and unit_named("pressure", unit) is not None
