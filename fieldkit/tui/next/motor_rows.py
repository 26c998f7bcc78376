"""The table of the Fly page: one row per motor, with as many figures of its forecast as fit."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from fieldkit.flight import BY_NAME
from fieldkit.forecast.prediction import median
from fieldkit.motors import Motor
from fieldkit.planning.motor_guide import MotorChoice
from fieldkit.planning.quick_guide import QuickChoice
from fieldkit.quantities import number, spelled, unit_of
from fieldkit.settings import Settings
from fieldkit.tui.next.intervals import TARGET, IntervalBar, bar
from fieldkit.tui.next.motor_list import MotorList
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.table import Cells, Head
from fieldkit.units import FOOT

NAME, SHORT_NAME = 22, 14
"""Widths of a motor's name, with and without its manufacturer. [cell]"""
LEAST_BAR = 14
"""Minimum width of a drawn interval. [cell]"""
LEAST_WITH_BAR = 56
"""Width from which a table beside a card draws intervals. [cell]"""
OFF_WIDTH = 5
"""Width of a distance from the target, without its mark. [cell]"""
TARGET_BAND = 10 * FOOT
"""A forecast is on target up to this distance; the default band around a target, the same as the command's. [m]"""
PROVISIONAL = "≈"
"""Mark of a figure that may still change: a quick answer, or a fit with few draws."""


@dataclass(frozen=True, slots=True)
class MotorColumn:
    """A figure of a motor's forecast: heading, width, and its text, by default empty for a quick answer."""

    title: str
    width: int
    text: Callable[[MotorChoice], str]
    quick: Callable[[QuickChoice], str] = lambda _: ""

    def of(self, one: MotorChoice | QuickChoice) -> str:
        """The text for a forecast."""
        return self.quick(one) if isinstance(one, QuickChoice) else self.text(one)


def listed(motors: MotorList, settings: Settings, width: int, *, brief: bool) -> tuple[list[Head], Cells]:
    """Headings and cells in a width: a `brief` choice next to a card, or else all that fit."""
    columns = _brief(motors, settings, width) if brief else _narrow(motors, settings)
    if not brief and width >= 76:
        columns = _every(motors, settings, width >= 100)
    left = width - 2 - sum(column.width + 1 for column in columns)
    name = NAME if left - NAME >= 2 * LEAST_BAR else SHORT_NAME
    room = left - name
    drawn = room >= LEAST_BAR
    if drawn:
        columns.append(_bar(motors, settings, room - 1))
    heads = [Head("motor", name if drawn else 0)]
    with_maker = (drawn and name == NAME) or (not drawn and left >= NAME)
    shared = Counter(motor.designation for motor in motors.found)
    heads += [Head(column.title, column.width, right=not (drawn and column is columns[-1])) for column in columns]

    def cells(motor: Motor) -> Sequence[str]:
        one = motors.shown(motor)
        called = f"{motor.maker} {motor.designation}" if with_maker else motor.designation
        called = f"{called} {motor.maker}" if not with_maker and shared[motor.designation] > 1 else called
        called = f"{motors.box[motor]} × {called}" if motors.box else called
        name = f"{_state(motors, motor)}{called}"
        if one is None:
            return [name, "…", *[""] * (len(columns) - 1)]
        return [name, *(column.of(one) for column in columns)]

    return heads, cells


def _state(motors: MotorList, motor: Motor) -> str:
    """The mark of a motor: not possible, to fly with caution, or flown before by this rocket."""
    one = motors.shown(motor)
    if not motors.fits(motor):
        return "✗ "
    if motors.weak(motor):
        return "! "
    return "◆ " if one is not None and one.flown else ""


def _brief(motors: MotorList, settings: Settings, width: int) -> list[MotorColumn]:
    """Apogee, the distance from the target, or without a target the interval, and ejection; with little room for a
    bar, the interval instead of ejection."""
    if settings.target and width < LEAST_WITH_BAR:
        return [_apogee(motors, settings), _range(settings), *_off(settings)]
    return [_apogee(motors, settings), *(_off(settings) or [_range(settings)]), _eject()]


def _narrow(motors: MotorList, settings: Settings) -> list[MotorColumn]:
    return [_apogee(motors, settings), _range(settings), *_off(settings), _eject(), _rail(settings, wide=False)]


def _every(motors: MotorList, settings: Settings, wide: bool) -> list[MotorColumn]:
    """All figures; if there is room, with units in the headings and a few more columns."""
    return [
        _of_any("mm", 3, lambda one: f"{one.motor.diameter * 1e3:.0f}"),
        _of_any("N s", 6, lambda one: f"{one.motor.total_impulse:.1f}"),
        _apogee(motors, settings),
        _range(settings),
        *_off(settings),
        MotorColumn("delay", 5, lambda one: "" if one.delay is None else f"{one.delay:g} s"),
        _eject(),
        _rail(settings, wide=wide),
        _of_any("T:W", 4, lambda one: f"{one.average_thrust:.1f}"),
    ]


def _of_any(title: str, width: int, text: Callable[[MotorChoice | QuickChoice], str]) -> MotorColumn:
    """A figure that a quick answer has too."""
    return MotorColumn(title, width, text, text)


def _apogee(motors: MotorList, settings: Settings) -> MotorColumn:
    def text(one: MotorChoice) -> str:
        return middle(one, settings.units, exact=one.motor in motors.exact)

    return MotorColumn("apogee", 6, text, lambda one: middle(one, settings.units, exact=False))


def middle(one: MotorChoice | QuickChoice, system: str, *, exact: bool) -> str:
    """The median of a forecast; whole and marked unless it is exactly what would be saved: `≈251`."""
    return number(cards.APOGEE, one.apogee, system) if exact else f"{PROVISIONAL}{whole(one.apogee, system)}"


def _range(settings: Settings) -> MotorColumn:
    def text(one: MotorChoice | QuickChoice) -> str:
        low, _, high = (whole(x, settings.units) for x in one.interval)
        return f"{low}-{high}"

    return _of_any("90%", 9, text)


def _off(settings: Settings) -> list[MotorColumn]:
    """The distance from the target, if there is one."""
    return [_of_any("off", OFF_WIDTH + 1, partial(off, settings=settings))] if settings.target else []


def _eject() -> MotorColumn:
    title = "eject s"
    return MotorColumn(title, len(title), lambda one: signed(one.prediction.median_eject))


def _rail(settings: Settings, *, wide: bool) -> MotorColumn:
    column = BY_NAME["top_speed"]
    title = f"rail {spelled(unit_of(column, settings.units))}" if wide else "rail"

    def text(one: MotorChoice) -> str:
        speed = median(one.prediction.rail_speed)
        return "" if speed is None else number(column, speed, settings.units)

    return MotorColumn(title, max(5, len(title)), text)


def _bar(motors: MotorList, settings: Settings, width: int) -> MotorColumn:
    """The 90% interval as a line, for all motors on one scale, with the target."""
    system, target = settings.units, settings.target
    top = max((one.apogee for motor, one in motors.every_shown.items() if motors.fits(motor)), default=1.0) * 1.2
    top = min(top, 2 * target) if target else top
    end = f"{whole(top, system)} {spelled(unit_of(cards.APOGEE, system))}"
    mark = " ◎ target" if target else ""

    def text(one: MotorChoice | QuickChoice) -> str:
        return bar(IntervalBar("", *one.interval), 0.0, top, width, (target,) if target else ())

    return _of_any(f"0{mark}{end:>{width - 1 - len(mark)}}", width, text)


def off(choice: MotorChoice | QuickChoice, settings: Settings) -> str:
    """Forecast minus target, from 100 on without a decimal; empty without a target."""
    target = settings.target
    if not target:
        return ""
    text = number(cards.APOGEE, abs(choice.apogee - target), settings.units)
    text = f"{float(text):.0f}" if len(text) > 4 else text
    text = text if float(text) == 0 else f"{'+' if choice.apogee > target else '-'}{text}"
    return f"{TARGET}{text}" if abs(choice.apogee - target) <= TARGET_BAND and len(text) < OFF_WIDTH else text


def whole(height: float, system: str) -> str:
    """A height [m] in whole units."""
    return f"{float(number(cards.APOGEE, height, system)):.0f}"


def signed(seconds: float | None) -> str:
    """Seconds after apogee, with their sign; empty if none are known."""
    return "" if seconds is None else f"{round(seconds, 1) + 0.0:+.1f}"  # zero is never negative
