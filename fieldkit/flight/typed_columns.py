"""The further columns of a flight that have a meaning, typed once: where a flight is made from its texts."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight.columns import BY_NAME, MOTOR_TEMPERATURE, TWO_DEVICES
from fieldkit.flight.limits import check
from fieldkit.flight.recovery import (
    DEVICES,
    DIRECTIONS,
    LIMITS,
    MAX_STABILITY,
    OPENING_TIME,
    RECOVERY_COLUMNS,
    RECOVERY_NAMES,
    RECOVERY_TEXTS,
    STABILITY,
    UNCERTAIN_WEATHER,
    Device,
    Recovery,
)
from fieldkit.messages import marked, message
from fieldkit.spelled_units import rounded, with_unit

STATE_COLUMN, STATES = "drag_step", {"yes": True, "open": True, "no": False, "shut": False}
"""Column in which a flyer records whether the drag of a flight switched, and its values."""
POSITIVE = ("drogue_speed", "main_altitude", "main_speed", "parachute_diameter")
"""Recovery columns that are above zero."""
WITH_SD = (*(BY_NAME[name] for name in UNCERTAIN_WEATHER), *TWO_DEVICES)
"""Columns whose standard deviation is in a further column."""
NAME_AND_UNIT: Mapping[str, tuple[str, str]] = {
    f"{name}_{unit}" if unit else name: (name, unit or own)
    for name, (quantity, own, _) in RECOVERY_COLUMNS.items()
    for unit in ("", *units.UNITS[quantity])
}
"""Each header of a recovery column that is a number, with or without a unit: its name and its unit."""
_NAMES = {header: name for header, (name, _) in NAME_AND_UNIT.items()} | {
    name: name for name in (*RECOVERY_TEXTS, MOTOR_TEMPERATURE)
}
_WITH_MEANING = {*_NAMES, STATE_COLUMN, *(column.sd_header for column in WITH_SD)}


@dataclass(frozen=True, slots=True)
class TypedColumns:
    """What the further columns of a flight say, read from `texts`.

    `recovery` is as usual if it was not recorded or cannot be read. `numbers` has by column the numbers of
    `RECOVERY_COLUMNS`, `rail_direction` (0 into the wind, pi away from it, pi/2 across it to the right), the static
    margin under `STABILITY` [body diameters] and the temperature of the motor under `MOTOR_TEMPERATURE`, in SI.
    `drag_switched` is whether the drag switches, None if not recorded. `sd` has the recorded standard deviations by
    column, in SI, `headers` the header of each column that has a text, and `problems` says why a column cannot be read
    or is impossible.
    """

    texts: Mapping[str, str] = field(default_factory=dict)
    recovery: Recovery = Recovery()
    numbers: Mapping[str, float] = field(default_factory=dict)
    drag_switched: bool | None = None
    sd: Mapping[str, float] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    problems: Mapping[str, str] = field(default_factory=dict)

    @property
    def rail_direction(self) -> float:
        """Direction of the rail, by default into the wind, the usual practice. [rad]"""
        return self.numbers.get("rail_direction", 0.0)

    @property
    def stability(self) -> float | None:
        """Static margin in body diameters, None if it was not recorded. [1]"""
        return None if STABILITY in self.problems else self.numbers.get(STABILITY)

    @property
    def motor_temperature(self) -> float | None:
        """The declared temperature of the motor, None if it was not recorded. [K]"""
        return self.numbers.get(MOTOR_TEMPERATURE)

    def check(self, *names: str) -> None:
        """Raise BadValue for the first of these columns, by default of all, that cannot be read or is impossible."""
        for name, problem in self.problems.items():
            if not names or name in names:
                raise BadValue(problem)

    def as_recorded(self, names: Iterable[str]) -> dict[str, str]:
        """The texts of these columns by header, as recorded."""
        return {self.headers[name]: self.texts[self.headers[name]] for name in names if name in self.headers}

    def readable(self, *names: str) -> bool:
        """Whether these columns can be read and are possible, or were not recorded."""
        return self.problems.keys().isdisjoint(names)


NO_COLUMNS = TypedColumns()
"""What a flight without further columns says."""


def typed_columns(texts: Mapping[str, str]) -> TypedColumns:
    """The further columns with a meaning among texts by header, typed."""
    if _WITH_MEANING.isdisjoint(texts):
        return TypedColumns(texts) if texts else NO_COLUMNS
    headers = _stated(texts)
    device: Device = "parachute"
    numbers: dict[str, float] = {}
    problems: dict[str, str] = {}
    for name, header in headers.items():
        text = texts[header].strip()
        try:
            if name == "recovery":
                device = _device(text)
                continue
            numbers[name] = _number(name, header, text)
            _check_possible(name, header, text, numbers[name])
        except BadValue as error:
            problems[name] = error.args[0]
    if "drogue_speed" in numbers and "main_altitude" not in headers:
        wanted = "found a drogue speed and no height at which the main opens, expected both, such as 500ft"
        problems["drogue_speed"] = wanted
    recovery = Recovery()
    if problems.keys().isdisjoint(("recovery", *POSITIVE, "opening_time")):
        drogue, main, speed, diameter = (numbers.get(name) for name in POSITIVE)
        recovery = Recovery(device, drogue, main, numbers.get("opening_time", OPENING_TIME), speed, diameter)
    switched = STATES.get(texts.get(STATE_COLUMN, "").strip().lower())
    return TypedColumns(texts, recovery, numbers, switched, dict(_sds(texts)), headers, problems)


def _stated(texts: Mapping[str, str]) -> dict[str, str]:
    """The header of each of `RECOVERY_NAMES` and of `MOTOR_TEMPERATURE` that has a text, by name, in the order in which
    they are checked; the first one of those that differ in the unit."""
    found: dict[str, str] = {}
    for header, text in texts.items():
        if header in _NAMES and text.strip():
            found.setdefault(_NAMES[header], header)
    order = (MOTOR_TEMPERATURE, "recovery", *RECOVERY_NAMES)
    return {name: found[name] for name in dict.fromkeys(order) if name in found}


def _number(name: str, header: str, text: str) -> float:
    """A column as a number in SI. Raises BadValue that names it."""
    if name == MOTOR_TEMPERATURE:
        return _motor_temperature(text)
    if name == "rail_direction":
        return _rail_direction(text.lower())
    if name == STABILITY:
        return _stability(text)
    try:
        return units.parse(text, RECOVERY_COLUMNS[name][0], NAME_AND_UNIT[header][1])
    except BadValue as error:
        raise BadValue(message(f"{_label(name)}: {marked(error)}")) from error


def _check_possible(name: str, header: str, text: str, value: float) -> None:
    """Raise BadValue for a recovery column that is not above zero, or beyond `LIMITS`."""
    if name not in LIMITS:
        return
    (low, high), own = LIMITS[name], units.typed_unit(text, NAME_AND_UNIT[header][1])
    if low <= value <= high:
        return
    scale = units.unit(RECOVERY_COLUMNS[name][0], own)
    expected = f"{rounded(scale.from_si(low))} to {with_unit(rounded(scale.from_si(high)), own)}"
    found = text if text.endswith(own) else with_unit(text, own)
    wanted = "more than zero" if name in POSITIVE and value <= 0 else expected
    raise BadValue(f"{_label(name)}: found {found}, expected {wanted}")


def _device(text: str) -> Device:
    found = next((one for one in DEVICES if one == text.lower()), None)
    if found is None:
        raise BadValue(f"recovery: found {text.lower()!r}, expected one of {', '.join(DEVICES)}")
    return found


def _rail_direction(text: str) -> float:
    try:
        degrees = DIRECTIONS[text] if text in DIRECTIONS else units.parse(text, "angle", "deg") / units.DEGREE
    except BadValue as error:
        raise BadValue(f"rail_direction: found {text!r}, expected into, away, across or degrees") from error
    return math.radians(degrees)


def _stability(text: str) -> float:
    try:
        margin = float(text.replace(",", "."))
    except ValueError:
        margin = math.nan
    if not 1 / MAX_STABILITY <= margin <= MAX_STABILITY:
        raise BadValue(f"{_label(STABILITY)}: found {text[:40]!r}, expected body diameters above zero, such as 2.5")
    return margin


def _motor_temperature(text: str) -> float:
    try:
        return check(BY_NAME["temperature"], units.parse(text, "temperature", "c"), units.typed_unit(text, "c"))
    except BadValue as error:
        raise BadValue(message(f"motor temperature: {marked(error)}")) from error


def _sds(texts: Mapping[str, str]) -> Iterator[tuple[str, float]]:
    """The standard deviations in further columns, in SI, without those that are no finite number."""
    for column in WITH_SD:
        try:
            sd = float(texts.get(column.sd_header, ""))
        except ValueError:
            continue
        if math.isfinite(sd):
            yield column.name, units.unit(column.quantity, column.unit).difference_to_si(sd)


def _label(name: str) -> str:
    """A column in a message."""
    return name.replace("_", " ")
