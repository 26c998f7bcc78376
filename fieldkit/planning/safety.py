"""Safety lines of a planned flight: always all of them, each with the value found and the limit.

They advise and never forbid: the range safety officer decides. Commands and screens display them and make no decisions
of their own.

Derivation: mean thrust is the integral of the piecewise linear curve over its time; thrust to weight is its ratio to
the loaded weight at standard gravity. Limits have their sources in `fieldkit/data`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.messages import fine, per_wind
from fieldkit.motors.draft import PER_IMPULSE
from fieldkit.motors.motor import PLUGGED_DELAY, Motor
from fieldkit.physics.setups import RAIL_LENGTH
from fieldkit.planning import rule_lines
from fieldkit.planning.check import (
    OFF_APOGEE,
    SAFE_RISK,
    UNSAFE_RISK,
    SafetyCheck,
    Verdict,
    by_chance,
    figure,
    length,
    ratio,
    speed,
    worst,
)
from fieldkit.planning.classification import build_of
from fieldkit.planning.descent_rate import Fall
from fieldkit.planning.flown_descent import air_at_pads, landing_mass
from fieldkit.planning.governed import governed
from fieldkit.planning.landing import Landing, landing
from fieldkit.planning.landing_speed import landing_speed_line, two_device_lines
from fieldkit.planning.limits import Limit, Limits
from fieldkit.planning.quantiles import three_of_all
from fieldkit.planning.rules import RuleSet, known_rules
from fieldkit.quantities import percent
from fieldkit.settings import Settings, read_settings
from fieldkit.shapes import Array, Float
from fieldkit.units import DEGREE, STANDARD_GRAVITY, ZERO_CELSIUS

CERTIFIED_AT = 21 + ZERO_CELSIUS
"""Temperature of motors during certification. [K]"""
HALF_SECOND = 0.5
"""Time over which initial thrust is averaged. [s]"""
STAYS_ON_RAIL = "the rocket does not leave the rail"
"""The finding about the descent of a rocket that is too heavy for its motor."""


@lru_cache(maxsize=2048)
def thrusts(motor: Motor) -> tuple[float, float]:
    """Mean thrust of the first half second as in `first_thrust`, and the certified average, as rules ask for. [N]"""
    return first_thrust(motor), motor.rated_thrust


def first_thrust(motor: Motor) -> float:
    """Mean thrust of the first half second from ignition, of the whole burn if that is shorter. [N]"""
    end = min(HALF_SECOND, motor.thrust_end)
    time = np.concatenate([[0.0], motor.time[(motor.time > 0) & (motor.time < end)], [end]])
    thrust = np.interp(time, motor.time, motor.thrust)
    return float(np.trapezoid(thrust, time) / end)


def thrust_to_weight(motor: Motor, dry_mass: float) -> tuple[float, float]:
    """Thrust over weight on the pad at a dry mass [kg], for the first half second and the certified average. [1]"""
    weight = (dry_mass + motor.loaded_mass) * STANDARD_GRAVITY
    first, average = thrusts(motor)
    return first / weight, average / weight


def safety_lines(
    prediction: Prediction,
    site: Site,
    fall: Fall,
    limits: Limits,
    rules: Sequence[RuleSet] | None = None,
    own: Settings | None = None,
) -> list[SafetyCheck]:
    """All checks of a forecast: guidance, the rules that govern the launch, and reminders.

    `rules` defaults to the shipped sets and the user's own, `own` to the flyer's settings, which have certification,
    age and usual rules. Raises BadValue for a damaged file of rules, and for a site
    under an authority without rule sets.
    """
    plan, motor = prediction.plan, prediction.found.motor
    build = build_of(motor, math.nan if plan.dry_mass is None else plan.dry_mass)
    day = plan.date_time.date() if plan.date_time else None
    sets, own = known_rules() if rules is None else rules, own or read_settings()
    site = replace(site, rules=site.rules or own.rules)
    governed_by = governed(build, three_of_all(prediction.true_apogee)[2], site, sets, day)
    down = landing(prediction, fall)
    recovery, mass = plan.columns.recovery, landing_mass(plan, prediction.found)
    density = float(air_at_pads([plan]).density[0])
    descent = [
        _ejection(prediction, limits),
        *two_device_lines(recovery, mass, density, fall, limits),
        landing_speed_line(down.down, recovery.device, mass, density, fall, limits),
    ]
    if prediction.stays_on_rail:
        descent = [replace(line, verdict="unknown", finding=STAYS_ON_RAIL) for line in descent]
    lines = [
        rail_line(prediction.rail_speed, plan, limits),
        _by_code_first(rule_lines.weight_line(governed_by), thrust_check(motor, plan.dry_mass or math.nan, limits)),
        _stricter(rule_lines.wind_line(governed_by, plan.wind), _own("wind", plan.wind, limits)),
        _stricter(rule_lines.angle_line(governed_by, plan.rail_angle), _own("angle", plan.rail_angle, limits)),
        rule_lines.stability_line(
            governed_by,
            plan.columns.stability,
            prediction.rests_on,
            limits,
            added=motor.loaded_mass - prediction.heaviest_motor,
        ),
        _ceiling(prediction.true_apogee, site),
        _field(down, site, rule_lines.field_line(governed_by, site.size)),
        rule_lines.distance_line(governed_by, site.people),
        rule_lines.bystander_line(governed_by, site.bystanders),
        *descent,
        _temperature(plan, limits),
        rule_lines.mass_line(governed_by),
        rule_lines.class_line(governed_by),
        rule_lines.certification_line(governed_by, own.flyer.certification),
        rule_lines.age_line(governed_by, own.flyer.age(day)),
        rule_lines.complex_line(governed_by),
    ]
    return [*lines, *rule_lines.reminder_lines(governed_by)]


def _stricter(one: SafetyCheck, other: SafetyCheck | None) -> SafetyCheck:
    """The worse of two lines on the same item."""
    return one if other is None else worst([one, other])


def _by_code_first(code: SafetyCheck | None, guidance: SafetyCheck) -> SafetyCheck:
    """The line of a code if its limit is broken, so that its rule is cited; else that of the guidance, or the worse."""
    return guidance if code is None else code if code.verdict == "unsafe" else worst([guidance, code])


OWN_BOUNDS = {"wind": "ground wind", "angle": "launch angle"}
"""Bounds that users set in addition to the rules, and the line of each."""


def _own(name: str, value: float | None, limits: Limits) -> SafetyCheck | None:
    """The line for a bound in the user's own `limits.toml`; None if there is no bound or no value to check."""
    if name not in limits or value is None:
        return None
    limit = limits[name]
    verdict: Verdict = "ok" if abs(value) <= limit.value else "unsafe"
    most, found = (f"{one / DEGREE:.1f}°" if name == "angle" else speed(one) for one in (limit.value, abs(value)))
    return SafetyCheck(OWN_BOUNDS[name], verdict, f"{found}, at most {most}", limit.source)


def rail_line(speeds: Float[Array, "draw"], plan: Flight, limits: Limits) -> SafetyCheck:
    """Speed off the rail [m/s] against the wind that turns the rocket there.

    The relative wind at the end of the rail meets the rocket at an angle whose tangent is wind over speed. Guidance
    asks for a speed of four times the wind, 14 degrees, and of 44 ft/s in any wind, which is four times 7.5 mph. Less
    is a caution; less than half of it, 27 degrees, is beyond the stall of flat fins (15 to 20 degrees) and unsafe.
    """
    fixed, times, fraction = (limits[name] for name in ("rail_speed", "rail_speed_per_wind", "rail_speed_unsafe"))
    speeds = np.nan_to_num(speeds)
    wind = plan.wind or 0.0
    needed = max(fixed.value, times.value * wind)
    middle, windy = three_of_all(speeds)[1], needed > fixed.value
    chance = float(np.mean(speeds < needed))
    slow = float(np.mean(speeds < fraction.value * needed)) >= UNSAFE_RISK
    verdict: Verdict = "ok" if chance < SAFE_RISK else "unsafe" if slow else "caution"
    text = f"{speed(middle)}, good from {speed(needed)}{f', {times.value:g} times the wind' if windy else ''}"
    text += f", unsafe below {speed(fraction.value * needed)}; {percent(chance)} chance of less than good"
    if verdict != "ok":
        light = wind if windy else fixed.value / times.value
        angle = math.degrees(math.atan2(light, middle))
        text += f": a wind of {speed(light)} meets it at {angle:.0f}°"
    if plan.rail_length is None:
        usual, twice = fine(RAIL_LENGTH, "m"), fine(2 * RAIL_LENGTH, "m")
        text += f"; rail length not given, {usual} assumed: faster off a longer one, by 20 to 45% off {twice}"
    return SafetyCheck("rail exit speed", verdict, text, (fraction if slow else times if windy else fixed).source)


def thrust_check(motor: Motor, dry_mass: float, limits: Limits) -> SafetyCheck:
    """Thrust to weight of a motor on the pad at a dry mass. [kg]"""
    first, average = thrust_to_weight(motor, dry_mass)
    return thrust_line({"in the first half second": first, "on average": average}, limits)


def thrust_line(found: Mapping[str, float], limits: Limits) -> SafetyCheck:
    """Thrust to weight over some times, by their names. [1]"""
    good, unsafe = limits["thrust_to_weight"], limits["thrust_to_weight_unsafe"]
    least = min(found.values())
    verdict: Verdict = "ok" if least >= good.value else "caution" if least >= unsafe.value else "unsafe"
    shown = ", ".join(f"{ratio(value, good.value, unsafe.value)} {when}" for when, value in found.items())
    text = f"{shown}; good above {good.value:g}, unsafe below {unsafe.value:g}"
    return SafetyCheck("thrust to weight", verdict, text, good.source if verdict != "unsafe" else unsafe.source)


def _ceiling(heights: Float[Array, "draw"], site: Site) -> SafetyCheck:
    source = f"ceiling of {site.name}" if site.name else "ceiling entered"
    high = three_of_all(heights)[2]
    text = f"95% chance of staying below {length(high)} above the pad"
    if site.ceiling is None:
        return SafetyCheck("ceiling", "unknown", f"{text}; no waiver or ceiling given", source)
    verdict: Verdict = "ok" if high <= site.ceiling else "unsafe"
    return SafetyCheck("ceiling", verdict, f"{text}; ceiling {length(site.ceiling)}", source)


def _field(down: Landing, site: Site, code: SafetyCheck) -> SafetyCheck:
    """The code's requirement for the field, and whether the landing stays on it, with the pad in its center."""
    if down.wind is None:
        verdict: Verdict = "unknown" if code.verdict == "ok" else code.verdict
        drifts = f"drifts {per_wind(three_of_all(down.drift)[1])} on the way down"
        return replace(code, verdict=verdict, finding=f"{code.finding}; wind not given; {drifts}")
    _, usual, reach = three_of_all(down.away)
    text = f"{code.finding}; lands {length(usual)} from the pad, 95% within {length(reach)}"
    if site.size is not None and 2 * reach > site.size and code.verdict in ("ok", "unknown"):
        return SafetyCheck(code.name, "caution", f"{text}: off the field", "half the field's shorter side")
    return replace(code, finding=text)


def _ejection(prediction: Prediction, limits: Limits) -> SafetyCheck:
    limit, name = limits["eject_speed"], "ejection speed"
    delay = prediction.plan.delay if prediction.plan.delay is not None else prediction.found.delay
    recovery = prediction.plan.columns.recovery
    if recovery.dual:
        opens = _altimeter_ejection(prediction, limit)
        return opens if delay in (None, PLUGGED_DELAY) else worst([opens, _early_charge(prediction, limit)])
    if delay == PLUGGED_DELAY:
        text = "a plugged motor has no charge: an altimeter must deploy; the landing assumes that it does at apogee"
        text += f": {OFF_APOGEE}"
        return SafetyCheck(name, "caution", text, limit.source)
    if delay is None:
        text = "delay unknown: add it to the motor's name, as in F24-4W; the landing assumes a charge at apogee"
        text += f": {OFF_APOGEE}"
        return SafetyCheck(name, "unknown", text, limit.source)
    if delay == 0:
        return SafetyCheck(name, "unsafe", "a booster motor (delay 0) has no charge for a parachute", limit.source)
    fired = np.isfinite(prediction.eject_speed)
    crashed = prediction.grounded
    chance = float(np.mean(np.nan_to_num(prediction.eject_speed) > limit.value)) + crashed
    text = f"{speed(three_of_all(prediction.eject_speed[fired])[1], 0)}; " if fired.any() else ""
    text += f"{percent(chance)} chance of more than {speed(limit.value, 0)}"
    text += f", {percent(crashed)} chance of hitting the ground first" if crashed >= 0.01 else ""
    return SafetyCheck("ejection speed", by_chance(chance), text, limit.source)


def _altimeter_ejection(prediction: Prediction, limit: Limit) -> SafetyCheck:
    """The speed at which an altimeter opens a drogue at apogee: the horizontal speed."""
    sideways = np.hypot(np.nan_to_num(prediction.drift_speed), np.nan_to_num(prediction.across_speed))
    chance = float(np.mean(sideways > limit.value))
    text = f"an altimeter opens the drogue at apogee, at {speed(three_of_all(sideways)[1], 0)}"
    text += f"; {percent(chance)} chance of more than {speed(limit.value, 0)}"
    return SafetyCheck("ejection speed", by_chance(chance), text, limit.source)


def _early_charge(prediction: Prediction, limit: Limit) -> SafetyCheck:
    """The chance that a motor's charge opens a rocket with an altimeter before apogee, at more than the limit: at worst
    caution, because most such motors can be flown without the charge. After apogee it is a backup."""
    early = np.nan_to_num(prediction.eject) < 0
    chance = float(np.mean(early & (np.nan_to_num(prediction.eject_speed) > limit.value)))
    fast = f"before apogee at more than {speed(limit.value, 0)}"
    text = f"{percent(chance)} chance that the motor's charge fires {fast}"
    verdict = by_chance(min(chance, SAFE_RISK))
    return SafetyCheck("ejection speed", verdict, f"{text}: take a longer delay or leave out the charge", limit.source)


def _temperature(plan: Flight, limits: Limits) -> SafetyCheck:
    cold, hot = limits["motor_cold"], limits["motor_hot"]
    value = plan.columns.motor_temperature
    certified, coldest, hottest = (figure(value, "c") for value in (CERTIFIED_AT, cold.value, hot.value))
    between = f"certified near {certified}, usable from {coldest} to {hottest}"
    if value is not None and cold.value <= value <= hot.value:
        return SafetyCheck("motor temperature", "ok", f"{figure(value, 'c')}; {between}", hot.source)
    if value is not None and value > hot.value:
        error = "a hotter one is stronger, which forecasts leave out: apogees are higher"
    else:
        error = "a colder one is weaker, which forecasts leave out: apogees are lower"
    shown = "not given" if value is None else figure(value, "c")
    verdict: Verdict = "unknown" if value is None else "caution"
    return SafetyCheck("motor temperature", verdict, f"{shown}; {between}; {error}, {PER_IMPULSE}", hot.source)
