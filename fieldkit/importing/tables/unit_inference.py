"""Infer units that a table does not state from physics, or not at all.

Pressure falls with height in a known way, a coasting rocket decelerates at one g or more, speed is the derivative of
height, an accelerometer at rest feels one g, and no logger samples once per hour or once per nanosecond. A unit is
inferred when exactly one candidate agrees with what is known; common practice is never used as a guess.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from fieldkit.integrals import running_integral
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY, UNITS

CANDIDATES: Mapping[str, tuple[str, ...]] = {
    "time": ("s", "ms", "us", "days", "cs"),
    "altitude": ("m", "ft", "cm", "mm"),
    "speed": ("m/s", "ft/s", "mph", "km/h", "cm/s"),
}
"""Units that a channel without a stated unit may have."""
_SHOWN_BY_COAST = "cs"
"""Unit of a clock that only the end of a coast shows: by the step size alone, a slow logger's milliseconds look like
it, and counts of another clock."""
_CLIMBS = (15.0, 1.2e4)
"""Climbs of model and high-power rockets, between which a clock and heights without a unit are distinguished. [m]"""
_END_OF_CLIMB = (0.85, 1.25)
"""Deceleration at the end of a climb, where drag is small, with the noise of heights. [g]"""
_HEIGHT_UNITS = ("m", "ft", "dm", "cm", "in", "mm")
"""Units of heights among which gravity before apogee may decide."""
_EPOCH = (9.4e8, 2.6e9)
"""Unix time from 1999 to 2052. [s]"""
_PAD_PRESSURE = {
    "0.1 pa": (6e5, 1.09e6),
    "pa": (6e4, 1.09e5),
    "hpa": (816.0, 1090.0),
    "kpa": (60.0, 109.0),
    "atm": (0.6, 1.08),
}
"""Range of the highest pressure of a log at launch sites below 4000 m, by unit; the ranges do not overlap."""


_REST_SAMPLES, _LEAST_REST = 20, 5
"""Largest and smallest number of samples in the pieces searched for a rest: some loggers store few of the pad. [1]"""
_BOOST_PART, _MAX_REST_PART, _REST_SPREAD = 0.4, 0.7, 0.3
"""Smallest fraction of the maximum that is a boost, largest fraction that is a rest, and largest spread of a rest
relative to its level. [1]"""
_LIFTS, _MOST_GRAVITIES = 1.5, 400.0
"""Smallest acceleration felt at lift-off, and the largest in any flight. [g]"""


@dataclass(frozen=True, slots=True)
class InferredUnit:
    """A unit, and the reason in a few words."""

    unit: str
    why: str


def settle_time_heights(raw: Mapping[str, Float[Array, "time"]], units: Mapping[str, str]) -> dict[str, InferredUnit]:
    """Units of `time`, `altitude` and `speed` that `units` does not contain, if they can be inferred.

    `raw` are columns with their original numbers; `pressure` may be in any unit. Missing results remain undetermined.
    """
    settled: dict[str, InferredUnit] = {}
    time = raw["time"]
    if "time" not in units and (epoch := epoch_unit(time)):
        settled["time"] = InferredUnit(epoch, "Unix time")
    known = {**units, **{name: one.unit for name, one in settled.items()}}
    unsettled = [name for name in CANDIDATES if name in raw and name not in known]
    if not unsettled:
        return settled
    ways = [known | dict(zip(unsettled, way, strict=True)) for way in product(*(CANDIDATES[n] for n in unsettled))]
    ways = [way for way in ways if _steps_are_a_loggers(time * UNITS["time"][way["time"]].factor)]
    ways = [way for way in ways if not _is_absurd(_coast(raw, way)) and ("altitude" in units or _is_a_climb(raw, way))]
    reasons = ["its step size"]
    for reason, test in _TESTS:
        agreeing = [way for way in ways if test(raw, way)]
        if agreeing and len(agreeing) < len(ways):
            ways, reasons = agreeing, [*reasons, reason]
    if "time" in unsettled:
        ways = [way for way in ways if way["time"] != _SHOWN_BY_COAST or _ends_in_free_fall(raw, way)]
    if "altitude" in raw and _comes_down(raw["altitude"]):
        coasts = [way for way in ways if not _is_no_coast(raw, way)]
        reasons += ["gravity before apogee"] * (len(coasts) < len(ways))
        ways = coasts
    for name in unsettled:
        left = {way[name] for way in ways}
        if len(left) == 1:
            settled[name] = InferredUnit(left.pop(), "by " + " and ".join(reasons[1:] or reasons))
    return settled


def _is_a_climb(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> bool:
    """Whether heights in a unit rise as far as those of a rocket, if there are any."""
    heights = raw.get("altitude", np.empty(0))
    heights = heights[np.isfinite(heights)] * UNITS["length"][way.get("altitude", "m")].factor
    return not heights.size or _CLIMBS[0] < float(np.ptp(heights)) < _CLIMBS[1]


def _ends_in_free_fall(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> bool:
    """Whether the end of a climb decelerates at one g."""
    return _END_OF_CLIMB[0] < _gravities(raw, way)[0] < _END_OF_CLIMB[1]


def epoch_unit(time: Float[Array, "time"]) -> str:
    """The unit in which a clock counts from 1970, or "" if it does not."""
    first = _median(time[:9])
    return next((u for u in ("s", "ms", "us", "ns") if _EPOCH[0] < first * UNITS["time"][u].factor < _EPOCH[1]), "")


def settle_pressure(pressure: Float[Array, "time"]) -> InferredUnit | None:
    """The unit in which the pressure on the pad is possible on this planet, if there is exactly one."""
    finite = pressure[np.isfinite(pressure)]
    pad = float(np.percentile(finite, 98)) if len(finite) else float("nan")
    fits = [unit for unit, (low, high) in _PAD_PRESSURE.items() if low <= pad <= high]
    return InferredUnit(fits[0], "from the pressure on the pad") if len(fits) == 1 else None


_BLOW_LASTS = 0.2
"""Longest duration of the shock of a charge; the shortest motors burn longer. [s]"""


def rest(acceleration: Float[Array, "time"], time: Float[Array, "time"] | None = None) -> float:
    """The reading of an accelerometer at its quietest before its peak, in the unit of the log.

    After landing it lies on its side, equally quiet but with another component of gravity along its axis, so only
    samples before the peak count. nan if a log begins in flight, because the most constant part may be the thrust.
    `time` [s] distinguishes the shock of a charge from a boost, which is weaker and longer.
    """
    there = np.isfinite(acceleration)
    values = acceleration[there]
    step = float(np.median(np.diff(time[there]))) if time is not None and len(values) > 1 else 0.0
    for length in dict.fromkeys((max(min(len(values) // 40, _REST_SAMPLES), _LEAST_REST), _LEAST_REST)):
        pieces = values[: len(values) // length * length].reshape(-1, length)
        if not len(pieces):
            continue
        means = pieces.mean(axis=1)
        for usual in (float(np.median(values)), float(means[0])):
            away = _lasting(np.abs(means - usual), int(_BLOW_LASTS / (step * length)) if step > 0 else 1)
            before = pieces[: int((away > _BOOST_PART * away.max()).argmax())]
            if len(before) and abs(usual) < _MAX_REST_PART * float(np.abs(means).max()):
                return float(before[before.std(axis=1).argmin()].mean())
        if np.ptp(values) <= _REST_SPREAD * abs(float(np.median(values))):  # a log that contains only a rest
            return float(np.median(values))
    return float("nan")


def _lasting(values: Float[Array, "piece"], width: int) -> Float[Array, "piece"]:
    """Values that last for a number of pieces: a morphological opening, which removes shorter peaks."""
    if not 1 < width < len(values):
        return values
    windows = np.lib.stride_tricks.sliding_window_view
    least = windows(values, width).min(axis=1)
    padded = np.pad(least, width - 1, constant_values=-np.inf)
    return np.asarray(windows(padded, width).max(axis=1))


_COUNTS = {f"1/{2**power} g": float(2**power) for power in range(8, 15)}
"""Units of accelerometers whose counts were not converted, by the counts of one g: the makers' scales are powers of
two, from 256 (ADXL345) to 16384 (MPU-6050 at 2 g)."""


def settle_net(
    acceleration: Float[Array, "time"], time: Float[Array, "time"], height: Float[Array, "time"]
) -> InferredUnit | None:
    """The unit of an acceleration net of gravity, or of its opposite: zero at rest or in a steady descent, and one g of
    deceleration before apogee; the clock and the heights are in SI."""
    coast, resting = last_of_climb(time, height, acceleration), (rest(acceleration, time), _median(acceleration))
    fits = []
    for unit in ("g", "m/s2", "ft/s2"):
        in_g = UNITS["acceleration"][unit].factor / STANDARD_GRAVITY
        is_net = any(abs(one) * in_g < _NO_GRAVITY for one in resting)
        if is_net and _END_OF_CLIMB[0] < abs(coast) * in_g < _END_OF_CLIMB[1]:
            fits.append(unit)
    return InferredUnit(fits[0], "from its value before apogee") if len(fits) == 1 else None


_NO_GRAVITY = 0.1
"""Largest acceleration at rest that is net of gravity. [g]"""


def settle_felt(acceleration: Float[Array, "time"], *, is_total: bool = False) -> InferredUnit | None:
    """The unit in which an accelerometer feels one g at rest and more in a boost; None without a rest.

    A total feels one g also where it lies after the flight, so the quietest part of the end of a log counts too.
    """
    finite = np.abs(acceleration[np.isfinite(acceleration)])
    if len(finite) < _LEAST_REST:
        return None
    at_rest = [abs(rest(acceleration)), *([_quietest(finite[-len(finite) // 5 :])] if is_total else [])]
    least, usual = np.quantile(finite, (0.05, 0.995)).tolist()
    most = float(_lasting(finite, min(_LEAST_REST, len(finite) - 1)).max())
    for unit in ("g", "m/s2", "mg", "ft/s2", *(_COUNTS if is_total else {})):
        gravity = _COUNTS.get(unit) or STANDARD_GRAVITY / UNITS["acceleration"][unit].factor
        never_left = least / gravity > 0.9 and usual / gravity < 1.1
        lifts = _LIFTS < most / gravity < _MOST_GRAVITIES
        if any(0.93 < level / gravity < 1.07 for level in at_rest) and (never_left or lifts):
            return InferredUnit(unit, "from one g at rest")
    return None


def _quietest(values: Float[Array, "time"]) -> float:
    """The mean of the quietest piece of some samples; nan if they are few."""
    length = max(min(len(values) // 8, _REST_SAMPLES), _LEAST_REST)
    if len(values) < length:
        return float("nan")
    pieces = values[: len(values) // length * length].reshape(-1, length)
    return float(pieces[pieces.std(axis=1).argmin()].mean())


def _median(values: Float[Array, "some"]) -> float:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else float("nan")


def clock_units(time: Float[Array, "time"]) -> tuple[str, ...]:
    """The units in which the steps of a clock are those of a logger, the most usual one first."""
    units = UNITS["time"]
    return tuple(u for u in ("s", "ms", "us", "cs", "ns", "days") if _steps_are_a_loggers(time * units[u].factor))


def _steps_are_a_loggers(time: Float[Array, "time"]) -> bool:
    """Whether the median time step is 0.2 ms to 5 s, and the whole log lasts 1.5 s to about a day."""
    steps = np.diff(time[np.isfinite(time)])
    steps = steps[steps > 0]
    return len(steps) > 0 and 2e-4 <= float(np.median(steps)) <= 5.0 and 1.5 <= float(steps.sum()) <= 1e5


def _pressure_agrees(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> bool:
    """Whether height increases as in the standard atmosphere for this ratio of pressures."""
    if "pressure" not in raw or "altitude" not in raw:
        return False
    altitude = raw["altitude"] * UNITS["length"][way["altitude"]].factor
    return _ratio_is_one(height_of_ratio(raw["pressure"]), altitude - _median(altitude[:5]))


def height_unit_by_pressure(raw: Mapping[str, Float[Array, "time"]]) -> str:
    """The unit in which heights match the pressure in the same log, or "" if none or both do."""
    fits = [unit for unit in CANDIDATES["altitude"] if _pressure_agrees(raw, {"altitude": unit})]
    return fits[0] if len(fits) == 1 else ""


def height_of_ratio(pressure: Float[Array, "time"]) -> Float[Array, "time"]:
    """Height above the beginning of a log from pressures in any unit. [m]

    Source: U.S. Standard Atmosphere 1976, with the pad assumed at sea level: the scale is within about 5% of the true
    one.
    """
    pad = _median(pressure[:5])
    ratio = np.where(pressure > 0, pressure, np.nan) / pad if pad > 0 else np.full_like(pressure, np.nan)
    return np.asarray(44330.77 * (1 - ratio**0.190263))


def _ratio_is_one(one: Float[Array, "time"], other: Float[Array, "time"]) -> bool:
    """Whether two heights agree within a quarter, by the median where the first is above 30% of its maximum."""
    with np.errstate(all="ignore"):
        high = np.isfinite(one) & np.isfinite(other) & (np.abs(one) > 0.3 * np.nanmax(np.abs(one), initial=0.0))
        ratios = other[high] / one[high]
    return len(ratios) >= 5 and 0.8 < float(np.median(ratios)) < 1.25


_OFF_PATH = 0.25
"""Largest median difference of heights from the integrated speed, as a fraction of the climb: heights of a sensor that
lost its power jump. [1]"""


def _speed_agrees(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> bool:
    """Whether the speed, integrated up to apogee, gives the height, at the top and on the way."""
    if "speed" not in raw or "altitude" not in raw:
        return False
    raw = _with_heights(raw)
    time, height = _ascent(raw, way)
    if time is None or height is None:
        return False
    speed = raw["speed"][: len(time)] * UNITS["speed"][way["speed"]].factor
    whole = np.isfinite(speed) & np.isfinite(height) & np.isfinite(time)
    if whole.sum() < 8:
        return False
    climbed, path = height[whole] - height[whole][0], running_integral(speed[whole], time[whole])
    rise = climbed[-1]
    return bool(rise > 0 and 0.8 < path[-1] / rise < 1.25 and np.median(np.abs(path - climbed)) < _OFF_PATH * rise)


def _coast_agrees(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> bool:
    """Whether the middle of the coast decelerates at one g or more: drag only adds to it, and so does an early charge,
    which is later."""
    return _LEAST_SLOWING < _coast(raw, way) < _MOST_SLOWING


def _coast(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> float:
    """The deceleration in the middle of a coast; nan if too few samples show it. [g]"""
    if "altitude" not in raw:
        return float("nan")
    time, height = _ascent(_with_heights(raw), way)
    if time is None or height is None:
        return float("nan")
    width = max(1, int(np.searchsorted(time, time[0] + _SPEED_WINDOW)))
    if len(time) <= width:
        return float("nan")
    climbs = (height[width:] - height[:-width]) / np.maximum(time[width:] - time[:-width], 1e-9)
    fastest = float(time[int(np.nanargmax(climbs))] + time[int(np.nanargmax(climbs)) + width]) / 2
    lasts = float(time[-1]) - fastest
    middle = (time > fastest + _MIDDLE[0] * lasts) & (time < fastest + _MIDDLE[1] * lasts) & np.isfinite(height)
    if middle.sum() < 6:
        return float("nan")
    curve = np.linalg.lstsq(np.vander(time[middle] - fastest, 3), height[middle], rcond=None)[0]
    return -2 * float(curve[0]) / STANDARD_GRAVITY


_ABSURD = 0.2
"""Deceleration below which heights do not coast, whatever disturbs them. [g]"""


def _is_absurd(slowing: float) -> bool:
    """Whether the middle of a coast cannot decelerate so, if it is known. [g]"""
    return slowing < _ABSURD or slowing > _MOST_SLOWING


_SPEED_WINDOW, _MIDDLE, _LEAST_SLOWING, _MOST_SLOWING = 0.3, (0.3, 0.75), 0.75, 30.0
"""Time over which a climb rate is taken [s], the middle of a coast as fractions of it, its least deceleration with
errors of heights, and one that no drag causes so late. [1], [g]"""


def _free_fall_agrees(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> bool:
    """Whether the end of the climb decelerates at one g plus a little drag, and the duration of the climb fits."""
    slowing, fall_rate = _gravities(raw, way)
    return 0.75 < slowing < 1.45 and 0.4 < fall_rate < 3.2


def height_units_by_free_fall(raw: Mapping[str, Float[Array, "time"]], stated: str) -> tuple[str, ...]:
    """The units of heights in which a climb slows down like a coast, if in the stated one neither its end or middle nor
    its whole duration can be a coast's; the stated one otherwise. A charge before apogee stops a rocket faster, but
    does not shorten its climb before. A log that ends in the climb does not show how long it lasts. Empty if it is no
    coast in any unit."""
    shows = _comes_down(raw["altitude"]) and not _misses_the_top(raw)
    if stated and not (shows and _is_no_coast(raw, {"altitude": stated, "time": "s"})):
        return (stated,)
    return tuple(unit for unit in _HEIGHT_UNITS if unit != stated and _is_coast(raw, unit))


def _misses_the_top(raw: Mapping[str, Float[Array, "time"]]) -> bool:
    """Whether samples are missing beside the highest one, with times in s: the end of the climb may be among them."""
    raw = _with_heights(raw)
    if not raw["altitude"].size:
        return True
    top = int(np.argmax(raw["altitude"]))
    return float(np.diff(raw["time"][max(top - 1, 0) : top + 2]).max(initial=0.0)) > _LONG_GAP


_LONG_GAP = 1.5
"""Longest time between samples that show the end of a climb. [s]"""


def _comes_down(height: Float[Array, "time"]) -> bool:
    """Whether the heights of a log fall after the highest of them by a tenth of their range."""
    there = height[np.isfinite(height)]
    return there.size > 0 and float(there.max() - there[-_REST_SAMPLES:].min()) > _FALL_PART * float(np.ptp(there))


_FALL_PART = 0.1
"""Fall after the top of a climb that shows where it was, as a fraction of the climb. [1]"""


def _is_no_coast(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> bool:
    """Whether a climb is too fast or too slow for a coast, with times and heights in some units."""
    (slowing, fall_rate), coast = _gravities(raw, way), _coast(raw, way)
    fast = fall_rate > _TOO_FAST[1] and max(slowing, coast) > _TOO_FAST[0]
    return fast or (fall_rate < _TOO_SLOW and coast < _LEAST_SLOWING)


def _is_coast(raw: Mapping[str, Float[Array, "time"]], unit: str) -> bool:
    """Whether a climb can be a coast, with times in s and heights in a unit."""
    way = {"altitude": unit, "time": "s"}
    (_, fall_rate), coast = _gravities(raw, way), _coast(raw, way)
    return fall_rate > _TOO_SLOW and coast > _LEAST_SLOWING and not _is_no_coast(raw, way)


def _gravities(raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]) -> tuple[float, float]:
    """The deceleration at the end of a climb, and that of a free rise of the same height and duration; nan if there is
    no climb. [g]"""
    if "altitude" not in raw:
        return float("nan"), float("nan")
    time, height = _ascent(_with_heights(raw), way)
    if time is None or height is None or len(time) < 12:
        return float("nan"), float("nan")
    top, bottom = height[-1], np.nanmin(height)
    last = np.flatnonzero(height < top - 0.06 * (top - bottom))
    begin = last[-1] + 1 if len(last) else 0
    t, h = time[begin:] - time[-1], height[begin:]
    whole = np.isfinite(t) & np.isfinite(h)
    if whole.sum() < 6 or np.ptp(t[whole]) <= 0:
        return float("nan"), float("nan")
    span = float(np.ptp(t[whole]))
    powers = np.vander(t[whole] / span, 3)
    slowing = -2 * float(np.linalg.lstsq(powers, h[whole], rcond=None)[0][0]) / span**2
    off = np.flatnonzero(height < bottom + 0.03 * (top - bottom))
    climb = time[-1] - time[off[-1] if len(off) else 0]
    fall_rate = 2 * float(top - bottom) / float(climb) ** 2 if climb > 0 else 0.0
    return slowing / STANDARD_GRAVITY, fall_rate / STANDARD_GRAVITY


_TOO_FAST = (2.4, 2.2)
"""Deceleration at the end of a climb, and that of a free rise of its height and duration, that no coast has: with drag
of ten weights at its start the second is 1.5. [g]"""
_TOO_SLOW = 0.8
"""Less than this is no free rise of the height and duration of a climb: a boost and drag only add to it. [g]"""


def _with_heights(raw: Mapping[str, Float[Array, "time"]]) -> dict[str, Array]:
    """The rows that have a height: sensors that are read alternately leave each other's cells empty."""
    there = np.isfinite(raw["altitude"])
    return {name: values[there] for name, values in raw.items()}


def _ascent(
    raw: Mapping[str, Float[Array, "time"]], way: Mapping[str, str]
) -> tuple[Float[Array, "time"] | None, Float[Array, "time"] | None]:
    """Time and height up to apogee, without spikes of one or two samples; None if there is no climb."""
    height = raw["altitude"] * UNITS["length"][way["altitude"]].factor
    time = raw["time"] * UNITS["time"][way["time"]].factor
    if np.isfinite(height).sum() < 12:
        return None, None
    padded = np.pad(height, 2, mode="edge")
    calm = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    if not np.isfinite(calm).any():
        return None, None
    top = int(np.nanargmax(calm))
    return (time[: top + 1], calm[: top + 1]) if top >= 4 else (None, None)


_COAST_END = (1.0, 0.2)
"""Start and end of the last second of a climb, before apogee: slow enough for little drag, before any charge. [s]"""


def last_of_climb(time: Float[Array, "time"], height: Float[Array, "time"], values: Float[Array, "time"]) -> float:
    """The median of some values in the last second of a climb, in their own unit; nan if there are none."""
    climb, _ = _ascent(_with_heights({"time": time, "altitude": height}), {"time": "s", "altitude": "m"})
    if climb is None:
        return float("nan")
    before = climb[-1] - time
    return _median(values[(before > _COAST_END[1]) & (before < _COAST_END[0])])


_TESTS = (
    ("the pressure", _pressure_agrees),
    ("speed and height", _speed_agrees),
    ("the coast", _coast_agrees),
    ("free fall", _free_fall_agrees),
)
"""Tests of units, in the order in which they are applied, each with the reason that is reported."""
