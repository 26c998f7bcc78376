"""The delay to buy or drill, from the distribution of coast time and the delay's own spread.

Source: NFPA 1125 for the tolerance of a delay (`fieldkit.motors.delay_tolerance`).
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.errors import BadValue, ImpossibleFlight
from fieldkit.files import read_toml
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Found
from fieldkit.motors.delay_tolerance import MIN_DELAY_TOLERANCE
from fieldkit.motors.motor import PLUGGED_DELAY, Motor, delays_text
from fieldkit.planning.check import speed
from fieldkit.planning.forecasts import Plan, forecasts
from fieldkit.planning.quantiles import Three, named, three, three_of_all
from fieldkit.planning.toml_values import number, problem_in
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY

DRILLS = Path(__file__).parents[1] / "data" / "drills.toml"
DRAWS = 1000
"""Flights simulated for each delay. [1]"""


@dataclass(frozen=True, slots=True)
class Drill:
    """A maker's delay tool for motors of a diameter: the times it can remove from the longest delay [s], the source,
    whether it was checked against the maker's instructions, and the minimum delay that must remain [s]."""

    maker: str
    takes_off: tuple[float, ...]
    source: str
    checked: bool
    least_left: float = 0.0

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {"takes_off_s": list(self.takes_off), "source": self.source, "checked": self.checked}

    @property
    def caveat(self) -> str:
        """A warning about an unverified tool, with marked amounts; empty for a verified one."""
        if self.checked:
            return ""
        steps = ", ".join(f"{off:g}" for off in self.takes_off)
        why = f"were not checked against its instructions ({self.source})"
        text = f"The cuts of {self.maker}'s tool ({steps} s) {why}; use the marks on your tool: "
        return f"{text}a cut that is 1 s off fires 1 s early or late, about {speed(STANDARD_GRAVITY, 0)} faster."


@dataclass(frozen=True, slots=True)
class Delay:
    """One delay: its time from apogee [s], the speed when it fires [m/s], its probability of being too fast [1].

    `lands_first` is the probability that the rocket hits the ground first, which counts as too fast [1]; if it always
    does, time and speed are None.
    """

    delay: float
    after_apogee: Three | None
    speed: Three | None
    too_fast: float
    lands_first: float
    on_sale: bool

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "delay_s": self.delay,
            "after_apogee_s": named(self.after_apogee),
            "eject_speed_mps": named(self.speed),
            "chance_too_fast": self.too_fast,
            "chance_lands_first": self.lands_first,
            "on_sale": self.on_sale,
        }


@dataclass(frozen=True, slots=True)
class Delays:
    """The coast from burnout to apogee [s], delays from best to worst, and notes in words.

    `coasts` are the draws of the coast [s]; `forecast` is the flight with the best delay, without a charge if there is
    none.
    """

    coast: Three
    delays: tuple[Delay, ...]
    words: tuple[str, ...]
    coasts: Float[Array, "draw"]
    forecast: Prediction


def drill_of(motor: Motor, own: Path | None = None) -> Drill | None:
    """The delay tool of a motor's maker for its diameter, None for most makers; only for reloads and for single-use
    motors that are sold to be drilled.

    Raises BadValue if the user's file is damaged.
    """
    tools = _drills(DRILLS, motor) | (_drills(own, motor) if own is not None and own.exists() else {})
    return tools.get(motor.maker) if motor.kind == "reload" or _is_dms(motor) else None


def _is_dms(motor: Motor) -> bool:
    """Whether a single-use motor is sold to be drilled, according to its designation."""
    return "DMS" in motor.designation.upper() or bool(_DRILLABLE_DELAY.search(motor.designation))


_DRILLABLE_DELAY = re.compile(r"-\d+A$")
"""The longest delay of an adjustable motor, at the end of its designation: `H283ST-15A`."""


def _drills(file: Path, motor: Motor) -> dict[str, Drill]:
    """The tools in a file for a motor's diameter."""
    try:
        tables = read_toml(file)
        found = {maker: _drill(maker, table, f"your own {file.name}", motor) for maker, table in tables.items()}
        return {maker: drill for maker, drill in found.items() if drill is not None}
    except (AttributeError, KeyError, TypeError, ValueError, OSError) as error:
        raise BadValue(f"{file.name}: found {problem_in(error)}, expected [Maker] with takes_off_s = [2, 4]") from error


def _drill(maker: str, table: dict[str, Any], source: str, motor: Motor) -> Drill | None:
    sizes = table.get("sizes") or [{"up_to_mm": np.inf, "takes_off_s": table["takes_off_s"]}]
    fitting = [size for size in sizes if motor.diameter * 1e3 <= _up_to(size) + 0.6]
    if not fitting:
        return None
    takes_off = tuple(number(off, "takes_off_s") for off in fitting[0]["takes_off_s"])
    left = number(table.get("least_left_s", 0.0), "least_left_s")
    left = number(table.get("least_left_dms_s", left), "least_left_dms_s") if _is_dms(motor) else left
    source = printable(str(table.get("source", source)))
    return Drill(printable(maker), takes_off, source, bool(table.get("checked", False)), left)


def _up_to(size: dict[str, Any]) -> float:
    """The largest motor diameter of a tool's size. [mm]"""
    return number(size["up_to_mm"], "up_to_mm", unlimited=True)


def offered(motor: Motor, takes_off: Sequence[float] = (), least_left: float = 0.0) -> dict[float, bool]:
    """The delays available for a motor [s], and whether each is for sale; `takes_off` are the times that can be drilled
    from the longest, with at least `least_left` remaining. [s]

    A delay of zero belongs to a booster, which lights the next stage and has no charge for a parachute.
    """
    sold = sold_delays(motor)
    drilled = [round(max(sold) - off, 3) for off in takes_off] if sold else []
    possible = [delay for delay in drilled if delay > 0 and delay >= least_left and delay not in sold]
    return dict.fromkeys(sold, True) | dict.fromkeys(possible, False)


def obtainable(motor: Motor, own: Path | None = None) -> dict[float, bool]:
    """The delays of a motor for sale and those that its maker's tool drills [s], and whether each is for sale. Raises
    BadValue if the user's file of tools is damaged."""
    tool = drill_of(motor, own)
    return offered(motor, tool.takes_off, tool.least_left) if tool else offered(motor)


def sold_delays(motor: Motor) -> list[float]:
    """The delays for sale that fire a charge, shortest first. [s]"""
    return [delay for delay in sorted(motor.delays) if 0 < delay < PLUGGED_DELAY]


def delays(
    plan: Plan, limit: float, takes_off: Sequence[float] = (), least_left: float = 0.0, draws: int = DRAWS
) -> Delays:
    """Rank the delays for sale, and those drilled from the longest with a tool that `takes_off` certain times, with at
    least `least_left` remaining. [s]

    `limit` is the highest safe speed at ejection [m/s]. Each delay is simulated, so fall and drag, wind and early
    deployment are included in its speed. The best has the lowest probability of being too fast, then the lowest mean
    square speed. Raises ImpossibleFlight if the motor does not lift the rocket.
    """
    motor = plan.found.motor
    ways = list(offered(motor, takes_off, least_left).items())
    planned = [
        (plan.flight.with_changes(delay=delay), Found(motor, delay)) for delay in [None, *(delay for delay, _ in ways)]
    ]
    predictions = forecasts(plan.rocket, planned, draws=draws)
    lifted = predictions[0].apogee > 0
    if lifted.mean() < 0.5:
        raise ImpossibleFlight(
            f"{motor.designation}: found too little thrust to lift the rocket, expected a stronger motor"
        )
    coast = predictions[0].coast_time[lifted]
    rated = [_rated(one, delay, limit, on_sale) for one, (delay, on_sale) in zip(predictions[1:], ways, strict=True)]
    order = sorted(range(len(rated)), key=lambda i: (round(rated[i][1].too_fast, 2), rated[i][0]))
    ranked = tuple(rated[i][1] for i in order)
    words = tuple(_words(coast, motor, ranked))
    coasts = three_of_all(coast[np.isfinite(coast)])
    return Delays(coasts, ranked, words, coast, predictions[order[0] + 1] if order else predictions[0])


def _rated(prediction: Prediction, delay: float, limit: float, on_sale: bool) -> tuple[float, Delay]:
    """A delay, and its ranking criterion: the mean square of the speed at the charge. [m^2/s^2]"""
    lifted = prediction.apogee > 0
    after = prediction.after_apogee[lifted]
    speed = prediction.eject_speed[lifted]
    first = np.isnan(speed)
    mean = float(np.mean(speed[~first] ** 2)) if not first.all() else np.inf
    lands = float(first.mean())
    return mean, Delay(delay, three(after), three(speed), float((speed > limit).mean()) + lands, lands, on_sale)


def _words(coast: Float[Array, "draw"], motor: Motor, ranked: Sequence[Delay]) -> list[str]:
    """Notes about delays that are not possible or not suitable."""
    name, middle = motor.designation, float(np.median(coast))
    if middle < 0:
        text = f"{name}: the rocket passes apogee {-middle:.1f} s before burnout, so a delay would have to"
        return [
            f"{text} be negative and none fits: the rocket is too heavy for this motor, or the motor burns too long."
        ]
    if not motor.delays:
        return [f"{name}: no delays are listed; the best would be {middle:.1f} s."]
    if not ranked:
        return [f"{name} is sold only plugged: it has no ejection charge, so the altimeter must deploy."]
    return [*_old_list(motor, ranked), *_out_of_range(name, middle, ranked)]


def _old_list(motor: Motor, ranked: Sequence[Delay]) -> list[str]:
    """A note about a delay list on which documents disagree, unless the user gave the longest delay."""
    listed = delays_text(motor.delays).replace(" ", "")
    if not any(one.field == "delays" and not one.applied and one.was == listed for one in motor.corrections):
        return []
    longest = max(one.delay for one in ranked)
    text = f"{motor.designation}: this delay list is outdated, and the package may list more than {longest:g} s"
    return [f"{text}: enter the motor with the longest delay printed on yours, as in {motor.designation}-14A."]


def _out_of_range(name: str, middle: float, ranked: Sequence[Delay]) -> list[str]:
    """A note if every delay fires too early or too late for a coast with this median time [s]."""
    short, long = min(one.delay for one in ranked), max(one.delay for one in ranked)
    if middle < short - MIN_DELAY_TOLERANCE:
        text = f"{name}: coasts {middle:.1f} s, the shortest available delay is {short:g} s: every charge fires"
        return [f"{text} late, on the way down. A lighter rocket or a faster motor coasts longer."]
    if middle > long + MIN_DELAY_TOLERANCE:
        text = f"{name}: coasts {middle:.1f} s, the longest available delay is {long:g} s: every charge fires"
        return [f"{text} early, on the way up. A heavier rocket coasts less, or let the altimeter deploy."]
    return []
