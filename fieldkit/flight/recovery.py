"""Recovery settings and rail direction of a flight: extra columns of a flight table, in addition to `COLUMNS`.

They are stored as text, like all columns that only some flights have, with the unit in the column's name.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight.columns import BY_NAME, Column
from fieldkit.flight.flight import Flight
from fieldkit.messages import marked, message
from fieldkit.spelled_units import rounded, with_unit

Device = Literal["parachute", "streamer"]
DEVICES: tuple[Device, ...] = ("parachute", "streamer")
RECOVERY_COLUMNS = {
    "drogue_speed": (
        "speed",
        "mps",
        "Descent speed under the drogue, near the ground: 20m/s, 45mph; implies drogue and main.",
    ),
    "main_altitude": ("length", "m", "Height above the pad at which the main opens: 150m, 500ft."),
    "main_speed": (
        "speed",
        "mps",
        "Descent speed under the parachute, the main if there are two, near the ground: 5m/s, 12mph.",
    ),
    "parachute_diameter": (
        "length",
        "mm",
        "Diameter of the parachute laid flat, the main if there are two: 450mm, 18in.",
    ),
    "opening_time": ("time", "s", "Time from the charge to an open parachute; default: half a second."),
    "wind_aloft": (
        "speed",
        "mps",
        "Wind speed aloft, the same as --wind for one that does not grow with height: 10m/s, 20mph.",
    ),
    "wind_aloft_height": ("length", "m", "Height of the wind aloft above the pad: 300m, 1000ft."),
    "wind_aloft_turn": ("angle", "deg", "Degrees clockwise from the wind at the pad to the wind aloft."),
}
"""Recovery columns that are numbers: quantity, external unit, and meaning."""
LIMITS = {
    "drogue_speed": (0.1, 1000.0),
    "main_altitude": (1.0, 200_000.0),
    "main_speed": (0.1, 1000.0),
    "parachute_diameter": (0.01, 100.0),
    "opening_time": (0.0, 600.0),
    "wind_aloft": (0.0, 150.0),
    "wind_aloft_height": (1.0, 50_000.0),
    "wind_aloft_turn": (-2 * math.pi, 2 * math.pi),
}
"""Lowest and highest possible number of each recovery column, in SI."""
IN_EVERY_FIT = ("opening_time", "wind_aloft", "wind_aloft_height", "wind_aloft_turn")
"""Recovery columns that change the simulated apogee of a past flight."""
UNCERTAIN_WEATHER = {"temperature": 15.0, "pressure": 3000.0, "wind": 5.0}
"""Conditions whose recorded standard deviation is used, with the largest: about that of the weather of a year. [K, Pa,
m/s]"""
MAX_STABILITY = 100.0
"""Upper limit on a static margin: many times the length of the longest rocket. [body diameters]"""
STABILITY = "stability_cal"
"""The column for a rocket's static margin, as a design program states it. [body diameters]"""
STABILITY_SOURCE = "stability_by"
"""The column of a plan whose margin is that of its design: the design's file."""
RECOVERY_TEXTS = {
    "recovery": "parachute or streamer.",
    "rail_direction": "Direction of the rail relative to the wind: into, away, across, or degrees from upwind.",
    STABILITY: "Static margin on the pad in body diameters: 2.5; the larger, the sooner it weathercocks.",
}
"""Recovery columns that are text, with their meaning."""
RECOVERY_NAMES = (*RECOVERY_COLUMNS, *RECOVERY_TEXTS)
DIRECTIONS = {"into": 0.0, "away": 180.0, "across": 90.0}
"""Directions of a rail by name. [deg]"""
DESCENT_SPEED = 5.0
"""Default descent speed under a parachute. [m/s]"""
OPENING_TIME = 0.5
"""Default time from the charge to an open parachute, an assumption. [s]"""


def recovery_header(name: str) -> str:
    """External name of an extra number or text column: `main_altitude_m`."""
    return f"{name}_{RECOVERY_COLUMNS[name][1]}" if name in RECOVERY_COLUMNS else name


def measured_sd(flight: Flight, column: Column) -> float | None:
    """Standard deviation in SI of one of `TWO_DEVICES` that was measured from the log of a flight; None if it was not,
    or if the text is not a number."""
    text = flight.extra.get(column.sd_header, "")
    try:
        return units.unit(column.quantity, column.unit).difference_to_si(float(text)) if text else None
    except ValueError:
        return None


def recovery_figure(flight: Flight, name: str) -> float | None:
    """An extra number of a flight in SI, None if it was not recorded. Raises BadValue that names it."""
    quantity, unit, _ = RECOVERY_COLUMNS[name]
    header = recovery_column(flight, name)
    if header is None:
        return None
    try:
        return units.parse(flight.extra[header], quantity, header[len(name) :].removeprefix("_") or unit)
    except BadValue as error:
        raise BadValue(message(f"{_label(name)}: {marked(error)}")) from error


def recovery_column(flight: Flight, name: str) -> str | None:
    """The extra column of a flight, with or without a unit, that has a text for one of `RECOVERY_NAMES`; None if there
    is none."""
    known = units.UNITS[RECOVERY_COLUMNS[name][0]] if name in RECOVERY_COLUMNS else ()
    for header, text in flight.extra.items():
        ours = header == name or (header.startswith(name) and header[len(name) :].removeprefix("_") in known)
        if ours and text.strip():
            return header
    return None


def recovery_texts(flight: Flight, names: Iterable[str]) -> dict[str, str]:
    """The columns of a flight that have a text for one of these `RECOVERY_NAMES`, as recorded."""
    headers = (recovery_column(flight, name) for name in names)
    return {header: flight.extra[header] for header in headers if header}


def check_recovery(flight: Flight, names: Iterable[str] = tuple(LIMITS)) -> None:
    """Raise BadValue for one of these recovery columns that is not a number or is beyond `LIMITS`."""
    for name in names:
        (low, high), value = LIMITS[name], recovery_figure(flight, name)
        if value is not None and not low <= value <= high:
            text, unit = _typed(flight, name)
            scale = units.unit(RECOVERY_COLUMNS[name][0], unit)
            least, most = (rounded(scale.from_si(one)) for one in (low, high))
            raise BadValue(f"{_label(name)}: found {text}, expected {least} to {with_unit(most, unit)}")


def _typed(flight: Flight, name: str) -> tuple[str, str]:
    """The text of an extra number that a flight has, with its unit, and that unit."""
    _, unit, _ = RECOVERY_COLUMNS[name]
    header = recovery_column(flight, name) or name
    text = flight.extra.get(header, "").strip()
    own = units.typed_unit(text, header[len(name) :].removeprefix("_") or unit)
    return text if text.endswith(own) else with_unit(text, own), own


def _label(name: str) -> str:
    """A recovery column in a message."""
    return name.replace("_", " ")


@dataclass(frozen=True, slots=True)
class Recovery:
    """What opens when; None if not recorded.

    `drogue_speed` is the descent speed under a drogue near the ground [m/s], `main_altitude` the height above the pad
    at which the main opens [m]; without it, the only device opens at the charge. `opening_time` is the time from the
    charge to an open device [s]. `main_speed` is the descent speed near the ground under the main or only device [m/s],
    `parachute_diameter` its diameter laid flat [m].
    """

    device: Device = "parachute"
    drogue_speed: float | None = None
    main_altitude: float | None = None
    opening_time: float = OPENING_TIME
    main_speed: float | None = None
    parachute_diameter: float | None = None

    @property
    def dual(self) -> bool:
        """Whether a drogue opens first and a main lower down."""
        return self.main_altitude is not None


def recovery_of(flight: Flight) -> Recovery:
    """Recovery settings of a flight; a negative opening time counts as 0.

    Raises BadValue for an unknown device, a text that is not a number, a speed, height or diameter that is not above
    zero, or a drogue without a main.
    """
    found = device_of(flight)
    drogue, main = recovery_figure(flight, "drogue_speed"), recovery_figure(flight, "main_altitude")
    if drogue is not None and main is None:
        raise BadValue("found a drogue speed and no height at which the main opens, expected both, such as 500ft")
    speed, diameter = recovery_figure(flight, "main_speed"), recovery_figure(flight, "parachute_diameter")
    positive = {"drogue_speed": drogue, "main_altitude": main, "main_speed": speed, "parachute_diameter": diameter}
    for name, value in positive.items():
        if value is not None and value <= 0:
            raise BadValue(f"{_label(name)}: found {_typed(flight, name)[0]}, expected more than zero")
    opening = recovery_figure(flight, "opening_time")
    opens = OPENING_TIME if opening is None else max(opening, 0.0)
    return Recovery(found, drogue, main, opens, speed, diameter)


def can_be_read(flight: Flight) -> bool:
    """Whether the recovery of a past flight can be read: each text is valid and within `LIMITS`, or was not
    recorded."""
    try:
        recovery_of(flight)
        check_recovery(flight)
    except BadValue:
        return False
    return True


def device_of(flight: Flight) -> Device:
    """The device of a flight, by default a parachute. Raises BadValue for an unknown one."""
    device = flight.extra.get("recovery", "").strip().lower() or "parachute"
    found = next((one for one in DEVICES if one == device), None)
    if found is None:
        raise BadValue(f"recovery: found {device!r}, expected one of {', '.join(DEVICES)}")
    return found


def stability(flight: Flight) -> float | None:
    """Static margin of a flight in body diameters, None if it was not recorded. [1]

    Raises BadValue if it is not a number from 1 / `MAX_STABILITY` to `MAX_STABILITY`.
    """
    text = flight.extra.get(STABILITY, "").strip()
    if not text:
        return None
    try:
        margin = float(text.replace(",", "."))
    except ValueError:
        margin = math.nan
    if not 1 / MAX_STABILITY <= margin <= MAX_STABILITY:
        raise BadValue(f"{_label(STABILITY)}: found {text[:40]!r}, expected body diameters above zero, such as 2.5")
    return margin


def has_own_stability(plan: Flight) -> bool:
    """Whether a plan has a static margin that is not that of its design."""
    return recovery_column(plan, STABILITY) is not None and STABILITY_SOURCE not in plan.extra


def with_stability(plan: Flight, margin: float, source: str) -> Flight:
    """A plan with the static margin [body diameters] of a design from the file `source`."""
    return plan.with_columns(**{STABILITY: f"{margin:.2f}", STABILITY_SOURCE: source})


@dataclass(frozen=True, slots=True)
class LaunchConditions:
    """What the further columns of a flight say about its climb, None if not recorded.

    `rail_direction` is as in the function of this name [rad]; `wind_aloft` [m/s] at `wind_aloft_height` [m] is turned
    to the right of the wind at the pad by `wind_aloft_turn` [rad]. `opening_time` is the time from the charge to an
    open parachute [s], `stability` the static margin [body diameters], and `dual` whether a main opens after a drogue.
    `weather_sd` has the standard deviation of each of `UNCERTAIN_WEATHER`, 0 if not recorded. [K, Pa, m/s]
    """

    rail_direction: float = 0.0
    wind_aloft: float | None = None
    wind_aloft_height: float | None = None
    wind_aloft_turn: float = 0.0
    opening_time: float = OPENING_TIME
    stability: float | None = None
    dual: bool = False
    weather_sd: tuple[float, ...] = (0.0, 0.0, 0.0)


AS_USUAL = LaunchConditions()
"""The conditions of a flight without further columns."""


def launch_conditions(flight: Flight) -> LaunchConditions:
    """The further columns of a flight, typed; as usual if they cannot be read, which `read_conditions` and
    `fieldkit.flight.plausibility.implausible` find before a flight or a plan is simulated."""
    try:
        return read_conditions(flight)
    except BadValue:
        return AS_USUAL


def read_conditions(flight: Flight) -> LaunchConditions:
    """The further columns of a flight, read. The direction of a vertical rail and a static margin that is no number do
    not matter; raises BadValue for a wind aloft, an opening time or the direction of a tilted rail that cannot be
    read."""
    if not flight.extra:
        return AS_USUAL
    try:
        margin = stability(flight)
    except BadValue:
        margin = None
    opening = recovery_figure(flight, "opening_time")
    return LaunchConditions(
        rail_direction(flight) if flight.rail_angle else 0.0,
        recovery_figure(flight, "wind_aloft"),
        recovery_figure(flight, "wind_aloft_height"),
        recovery_figure(flight, "wind_aloft_turn") or 0.0,
        OPENING_TIME if opening is None else max(opening, 0.0),
        margin,
        recovery_column(flight, "main_altitude") is not None,
        tuple([_weather_sd(flight, name, most) for name, most in UNCERTAIN_WEATHER.items()]),
    )


def _weather_sd(flight: Flight, name: str, most: float) -> float:
    """The recorded standard deviation of a recorded condition, at most that of ignorance; 0 without one."""
    sd = measured_sd(flight, BY_NAME[name]) if flight.number(name) is not None else None
    return min(sd, most) if sd is not None and sd > 0 else 0.0


def rail_direction(flight: Flight) -> float:
    """Direction of the rail: 0 into the wind, pi away from it, pi/2 across it to the right. Raises BadValue. [rad]

    The default is into the wind, the usual practice.
    """
    text = flight.extra.get("rail_direction", "").strip().lower()
    if not text:
        return 0.0
    try:
        return math.radians(
            DIRECTIONS[text] if text in DIRECTIONS else units.parse(text, "angle", "deg") / units.DEGREE
        )
    except BadValue as error:
        raise BadValue(f"rail_direction: found {text!r}, expected into, away, across or degrees") from error
