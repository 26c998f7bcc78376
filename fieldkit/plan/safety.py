"""Safety lines of a planned flight: always all of them, each with what was found and what would be right.

They advise and never forbid: the range safety officer decides.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fieldkit.flight import Flight
from fieldkit.motors.motor import Motor
from fieldkit.plan.limits import Limits
from fieldkit.shapes import Array, Float
from fieldkit.units import DEGREE, FOOT, MILE, STANDARD_GRAVITY

DECIDES = "These lines advise; the range safety officer decides."
HALF_SECOND = 0.5
"""Over which thrust is first averaged. [s]"""
MPH = MILE / 3600

Verdict = Literal["ok", "caution", "unsafe", "unknown"]


@dataclass(frozen=True, slots=True)
class Line:
    """One check: its name, how it ended, what was found and what would be right, and where the limit is from."""

    name: str
    verdict: Verdict
    text: str
    source: str

    def json(self) -> dict[str, str]:
        """Ready for JSON."""
        return {"check": self.name, "verdict": self.verdict, "text": self.text, "source": self.source}


def first_thrust(motor: Motor) -> float:
    """Mean thrust of the first half second from ignition, of the whole burn where that is shorter. [N]"""
    end = min(HALF_SECOND, motor.thrust_end)
    time = np.union1d(motor.time[motor.time < end], [0.0, end])
    thrust = np.interp(time, motor.time, motor.thrust)
    return float(np.sum(np.diff(time) * (thrust[1:] + thrust[:-1])) / 2 / end)


def thrust_to_weight(motor: Motor, dry_mass: float) -> tuple[float, float]:
    """Of the first half second, and of the average thrust, over the weight on the pad. [1]"""
    weight = (dry_mass + motor.loaded_mass) * STANDARD_GRAVITY
    return first_thrust(motor) / weight, motor.average_thrust / weight


def safety_lines(
    plan: Flight,
    motor: Motor,
    rail_speed: Float[Array, "draw"],
    eject_speed: Float[Array, "draw"],
    true_apogee: Float[Array, "draw"],
    limits: Limits,
    waiver: float | None = None,
) -> list[Line]:
    """Every safety line of a plan, from its draws in SI; `waiver` is the ceiling above the pad. [m]"""
    return [
        _rail(rail_speed, plan.wind, limits),
        _thrust(motor, plan.dry_mass or math.nan, limits),
        _wind(plan.wind, limits),
        _angle(plan.rail_angle, limits),
        _ceiling(true_apogee, waiver),
        _ejection(eject_speed, limits),
    ]


def _rail(speeds: Array, wind: float | None, limits: Limits) -> Line:
    fixed, times = limits["rail_speed"], limits["rail_speed_per_wind"]
    speed = float(np.median(np.nan_to_num(speeds)))
    needed = max(fixed.value, times.value * (wind or 0.0))
    why = "" if needed == fixed.value else f", {times.value:g} times the wind"
    chance = float(np.mean(np.nan_to_num(speeds) < needed))
    verdict: Verdict = "ok" if chance < 0.05 else "caution" if speed >= needed else "unsafe"
    text = f"{speed:.1f} m/s, wanted at least {needed:.1f} m/s{why}; chance of less {chance:.0%}"
    return Line("rail exit speed", verdict, text, times.source if why else fixed.source)


def _thrust(motor: Motor, dry_mass: float, limits: Limits) -> Line:
    good, unsafe = limits["thrust_to_weight"], limits["thrust_to_weight_unsafe"]
    first, average = thrust_to_weight(motor, dry_mass)
    verdict: Verdict = "ok" if first >= good.value else "caution" if first >= unsafe.value else "unsafe"
    text = (
        f"{first:.1f} in the first half second, {average:.1f} on average; "
        f"good from {good.value:g}, unsafe below {unsafe.value:g}"
    )
    return Line("thrust to weight", verdict, text, good.source if verdict != "unsafe" else unsafe.source)


def _wind(wind: float | None, limits: Limits) -> Line:
    limit = limits["wind"]
    most = f"no launch above {limit.value:.1f} m/s ({limit.value / MPH:.0f} mph)"
    if wind is None:
        return Line("ground wind", "unknown", f"not given; {most}", limit.source)
    text = f"{wind:.1f} m/s ({wind / MPH:.0f} mph); {most}"
    return Line("ground wind", "ok" if wind <= limit.value else "unsafe", text, limit.source)


def _angle(angle: float | None, limits: Limits) -> Line:
    limit = limits["angle"]
    if angle is None:
        return Line("launch angle", "unknown", f"not given; at most {limit.value / DEGREE:.0f}°", limit.source)
    text = f"{angle / DEGREE:.0f}° from vertical, at most {limit.value / DEGREE:.0f}°"
    return Line("launch angle", "ok" if abs(angle) <= limit.value else "unsafe", text, limit.source)


def _ceiling(heights: Array, waiver: float | None) -> Line:
    high = float(np.quantile(np.nan_to_num(heights), 0.95))
    text = f"19 flights of 20 stay below {high:.0f} m ({high / FOOT:.0f} ft)"
    if waiver is None:
        return Line("ceiling", "unknown", f"{text}; no ceiling given, see --waiver", "the waiver of the field")
    verdict: Verdict = "ok" if high <= waiver else "unsafe"
    return Line(
        "ceiling", verdict, f"{text}; ceiling {waiver:.0f} m ({waiver / FOOT:.0f} ft)", "the waiver of the field"
    )


def _ejection(speeds: Array, limits: Limits) -> Line:
    limit = limits["eject_speed"]
    known = speeds[np.isfinite(speeds)]
    if not known.size:
        return Line(
            "ejection speed", "unknown", "no ejection charge fires before landing, or no delay known", limit.source
        )
    chance = float(np.mean(known > limit.value))
    verdict: Verdict = "ok" if chance < 0.1 else "caution" if chance < 0.5 else "unsafe"
    text = f"{np.median(known):.0f} m/s; chance of more than {limit.value:.0f} m/s {chance:.0%}"
    return Line("ejection speed", verdict, text, limit.source)
