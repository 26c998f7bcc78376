"""Safety lines of a planned flight: always all of them, each with what was found and what would be right.

They advise and never forbid: the range safety officer decides. The commands and the app show them, and none of them
decides anything of its own.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, MOTOR_TEMPERATURE, Flight
from fieldkit.flight.plausibility import check
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors.motor import Motor
from fieldkit.planning.air import air_of
from fieldkit.planning.descent import Fall, landing, landing_mass
from fieldkit.planning.limits import Limits
from fieldkit.planning.quantiles import three
from fieldkit.shapes import Array, Float
from fieldkit.units import DEGREE, FOOT, MILE, STANDARD_GRAVITY, ZERO_CELSIUS

ADVICE_NOTE = "These lines advise; the range safety officer decides."
HALF_SECOND = 0.5
"""Over which thrust is first averaged. [s]"""
MPH = MILE / 3600
SAFE_RISK, UNSAFE_RISK = 0.05, 0.5
"""Probability of missing a limit up to which a check passes, and from which on it fails. [1]"""

Verdict = Literal["ok", "caution", "unsafe", "unknown"]
MARKS: dict[Verdict, str] = {"ok": "✓", "caution": "!", "unsafe": "✗", "unknown": "?"}
"""A sign for each verdict, beside its word."""


@dataclass(frozen=True, slots=True)
class SafetyCheck:
    """One check: its name, how it ended, what was found and what would be right, and where the limit is from."""

    name: str
    verdict: Verdict
    text: str
    source: str

    @property
    def failed(self) -> bool:
        """Whether it is not well, and known."""
        return self.verdict in ("caution", "unsafe")

    def words(self) -> str:
        """The check in a line: `✗ ground wind: unsafe: 10.0 m/s ...`, with its source where it is not well."""
        source = f" [{self.source}]" if self.failed else ""
        return f"{MARKS[self.verdict]} {self.name}: {self.verdict}: {self.text}{source}"

    def json(self) -> dict[str, str]:
        """Ready for JSON."""
        return {"check": self.name, "verdict": self.verdict, "text": self.text, "source": self.source}


@lru_cache(maxsize=2048)
def thrusts(motor: Motor) -> tuple[float, float]:
    """Of the first half second as in `first_thrust`, and of the whole burn. [N]"""
    return first_thrust(motor), motor.average_thrust


def first_thrust(motor: Motor) -> float:
    """Mean thrust of the first half second from ignition, of the whole burn where that is shorter. [N]"""
    end = min(HALF_SECOND, motor.thrust_end)
    time = np.concatenate([[0.0], motor.time[(motor.time > 0) & (motor.time < end)], [end]])
    thrust = np.interp(time, motor.time, motor.thrust)
    return float(np.sum(np.diff(time) * (thrust[1:] + thrust[:-1])) / 2 / end)


def thrust_to_weight(motor: Motor, dry_mass: float) -> tuple[float, float]:
    """Of the first half second, and of the average thrust, over the weight on the pad. [1]"""
    weight = (dry_mass + motor.loaded_mass) * STANDARD_GRAVITY
    first, average = thrusts(motor)
    return first / weight, average / weight


def motor_temperature(plan: Flight) -> float | None:
    """As declared with the plan, or None. [K] Raises BadValue for no number, and for one that no field has."""
    text = plan.extra.get(MOTOR_TEMPERATURE, "")
    try:
        return check(BY_NAME["temperature"], units.parse(text, "temperature", "c")) if text else None
    except BadValue as error:
        raise BadValue(f"{MOTOR_TEMPERATURE}: {error}") from error


def safety_lines(said: Prediction, site: Site, fall: Fall, limits: Limits) -> list[SafetyCheck]:
    """All checks as lines of text, and who decides."""
    plan, motor = said.plan, said.found.motor
    return [
        _rail(said.rail_speed, plan.wind, limits),
        _thrust(motor, plan.dry_mass or math.nan, limits),
        _wind(plan.wind, limits),
        _angle(plan.rail_angle, limits),
        _ceiling(said.true_apogee, site),
        _field(said, site, fall, limits),
        _ejection(said, limits),
        _temperature(plan, limits),
        _class(motor, plan.dry_mass or math.nan, limits),
    ]


def by_chance(chance: float) -> Verdict:
    """How a check ends that is missed with this chance."""
    return "ok" if chance < SAFE_RISK else "caution" if chance < UNSAFE_RISK else "unsafe"


def safety_text(lines: Sequence[SafetyCheck]) -> Iterator[str]:
    """All lines as text, and who decides."""
    yield from (line.words() for line in lines)
    yield ADVICE_NOTE


def _rail(speeds: Float[Array, "draw"], wind: float | None, limits: Limits) -> SafetyCheck:
    fixed, times = limits["rail_speed"], limits["rail_speed_per_wind"]
    speeds = np.nan_to_num(speeds)
    needed = max(fixed.value, times.value * (wind or 0.0))
    why = "" if needed == fixed.value else f", {times.value:g} times the wind"
    chance = float(np.mean(speeds < needed))
    text = f"{speed(three(speeds)[1])}, wanted at least {speed(needed)}{why}; chance of less {chance:.0%}"
    return SafetyCheck("rail exit speed", by_chance(chance), text, times.source if why else fixed.source)


def _thrust(motor: Motor, dry_mass: float, limits: Limits) -> SafetyCheck:
    good, unsafe = limits["thrust_to_weight"], limits["thrust_to_weight_unsafe"]
    first, average = thrust_to_weight(motor, dry_mass)
    least = min(first, average)
    verdict: Verdict = "ok" if least >= good.value else "caution" if least >= unsafe.value else "unsafe"
    text = (
        f"{first:.1f} in the first half second, {average:.1f} on average; "
        f"good from {good.value:g}, unsafe below {unsafe.value:g}"
    )
    return SafetyCheck("thrust to weight", verdict, text, good.source if verdict != "unsafe" else unsafe.source)


def _wind(wind: float | None, limits: Limits) -> SafetyCheck:
    limit = limits["wind"]
    most = f"no launch above {limit.value:.1f} m/s ({limit.value / MPH:.0f} mph)"
    if wind is None:
        return SafetyCheck("ground wind", "unknown", f"not given; {most}", limit.source)
    text = f"{wind:.1f} m/s ({wind / MPH:.0f} mph); {most}"
    return SafetyCheck("ground wind", "ok" if wind <= limit.value else "unsafe", text, limit.source)


def _angle(angle: float | None, limits: Limits) -> SafetyCheck:
    limit = limits["angle"]
    if angle is None:
        return SafetyCheck("launch angle", "unknown", f"not given; at most {limit.value / DEGREE:.0f}°", limit.source)
    text = f"{angle / DEGREE:.0f}° from vertical, at most {limit.value / DEGREE:.0f}°"
    return SafetyCheck("launch angle", "ok" if abs(angle) <= limit.value else "unsafe", text, limit.source)


def _ceiling(heights: Float[Array, "draw"], site: Site) -> SafetyCheck:
    source = f"ceiling of {site.name}" if site.name else "ceiling as given"
    high = three(heights)[2]
    text = f"95 % stay below {length(high)} above the pad"
    if site.ceiling is None:
        return SafetyCheck("ceiling", "unknown", f"{text}; no waiver or ceiling given", source)
    verdict: Verdict = "ok" if high <= site.ceiling else "unsafe"
    return SafetyCheck("ceiling", verdict, f"{text}; ceiling {length(site.ceiling)}", source)


def _field(said: Prediction, site: Site, fall: Fall, limits: Limits) -> SafetyCheck:
    """The pad is taken to stand in the middle of the field, and the charge to fire at apogee."""
    share = limits["field_share_of_apogee"]
    far = "wind not given, so no drift"
    reach = 0.0
    if said.plan.wind is not None:
        away = np.abs(landing(said, _speeds(said, fall)))
        _, usual, reach = three(away)
        far = f"lands {length(usual)} from the pad, 95 % within {length(reach)}"
    needed = max(2 * reach, share.value * three(said.true_apogee)[2])
    text = f"{far}; a field {length(needed)} across is wanted"
    if site.size is None:
        return SafetyCheck("field size", "unknown", f"{text}, its size is not given", share.source)
    verdict: Verdict = "ok" if site.size >= needed else "caution"
    if verdict == "ok" and said.plan.wind is None:
        verdict = "unknown"
    return SafetyCheck("field size", verdict, f"{text}, this one is {length(site.size)}", share.source)


def _speeds(said: Prediction, fall: Fall) -> Float[Array, "draw"]:
    unit = _unit_speeds(fall, len(said.apogee))
    return np.asarray(unit * math.sqrt(landing_mass(said.plan, said.found) / air_of(said.plan).density))


@lru_cache(maxsize=8)
def _unit_speeds(fall: Fall, draws: int) -> Float[Array, "draw"]:
    """Descent speeds of a kilogram in air of a kilogram a cubic metre: motors of a guide fall by the same luck."""
    return fall.speeds(np.random.default_rng(5), (draws, 1), 1.0, 1.0)[:, 0]


def _ejection(said: Prediction, limits: Limits) -> SafetyCheck:
    limit = limits["eject_speed"]
    delay = said.plan.delay if said.plan.delay is not None else said.found.delay
    if delay is None or not math.isfinite(delay):
        return SafetyCheck(
            "ejection speed", "unknown", "no delay known, so no charge fires in this forecast", limit.source
        )
    fired = np.isfinite(said.eject_speed)
    crashed = float(np.mean(~fired & (said.true_apogee > 0)))
    chance = float(np.mean(np.nan_to_num(said.eject_speed) > limit.value)) + crashed
    text = f"{speed(three(said.eject_speed)[1], 0)}; " if fired.any() else ""
    text += f"chance of more than {speed(limit.value, 0)} {chance:.0%}"
    text += f", {crashed:.0%} reach the ground first" if crashed >= 0.01 else ""
    return SafetyCheck("ejection speed", by_chance(chance), text, limit.source)


def _temperature(plan: Flight, limits: Limits) -> SafetyCheck:
    cold, hot = limits["motor_cold"], limits["motor_hot"]
    value = motor_temperature(plan)
    between = f"certified near 21 °C (70 °F), flown from {_celsius(cold.value)} to {_celsius(hot.value)}"
    if value is None:
        return SafetyCheck("motor temperature", "unknown", f"not given; {between}", hot.source)
    verdict: Verdict = "ok" if cold.value <= value <= hot.value else "caution"
    return SafetyCheck("motor temperature", verdict, f"{_celsius(value)}; {between}", hot.source)


def _celsius(value: float) -> str:
    celsius = value - ZERO_CELSIUS
    return f"{celsius:.0f} °C ({celsius * 1.8 + 32:.0f} °F)"


def length(metres: float) -> str:
    """In both units, as every line has it: `284 m (932 ft)`."""
    return f"{metres:.0f} m ({metres / FOOT:.0f} ft)"


def speed(value: float, digits: int = 1) -> str:
    """Of a rocket, in both units: `13.4 m/s (44 ft/s)`."""
    return f"{value:.{digits}f} m/s ({value / FOOT:.0f} ft/s)"


def _class(motor: Motor, dry_mass: float, limits: Limits) -> SafetyCheck:
    """Regulatory class of the rocket by propellant and mass, and what motor and rocket ask of the flyer."""
    propellant, mass = motor.propellant_mass, dry_mass + motor.loaded_mass
    text = f"{propellant * 1e3:.0f} g of propellant, {mass * 1e3:.0f} g on the pad, {motor.total_impulse:.0f} N s"
    most, heaviest = limits["class1_propellant"], limits["class1_mass"]
    class1 = propellant <= most.value and mass <= heaviest.value
    why = why_high_power(motor, limits)
    if motor.total_impulse > limits["class2_impulse"].value:
        return SafetyCheck("class", "unsafe", f"{text}: class 3, beyond high power", limits["class2_impulse"].source)
    if class1 and not why:
        return SafetyCheck("class", "ok", f"{text}: class 1, a model rocket", most.source)
    said = "class 1 by mass" if class1 else "class 2, which needs a waiver"
    if why:
        said += f"; a high-power motor by {why}, which asks for certification level {_level(motor, limits)}"
    source = limits["high_power_impulse"].source if class1 else limits["class2_impulse"].source
    return SafetyCheck("class", "caution", f"{text}: {said}", source)


def why_high_power(motor: Motor, limits: Limits) -> str:
    """What makes a motor a high-power one, an empty text where nothing does.

    Its certified average thrust counts, not that of the curve, and never the number in its name.
    """
    impulse, thrust, propellant = (
        limits[name].value for name in ("high_power_impulse", "high_power_thrust", "class1_propellant")
    )
    if motor.total_impulse > impulse:
        return f"more than {impulse:.0f} N s"
    if motor.rated_thrust > thrust:
        if motor.certified_average is None:
            return f"the average thrust of its curve, {motor.rated_thrust:.1f} N"
        return f"its certified average thrust of {motor.rated_thrust:.1f} N"
    if motor.propellant_mass > propellant:
        return f"more than {propellant * 1e3:.0f} g of propellant"
    if motor.kind == "hybrid":
        return "its kind, a hybrid"
    return "the HP in its designation" if motor.designation.upper().startswith("HP-") else ""


def _level(motor: Motor, limits: Limits) -> int:
    return 1 + sum(motor.total_impulse > limits[name].value for name in ("level1_impulse", "level2_impulse"))
