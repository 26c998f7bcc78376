"""Safety lines of a rocket with several stages, of which one flight is simulated and no landing."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import Found
from fieldkit.motors.motor import PLUGGED_DELAY
from fieldkit.planning import rule_lines
from fieldkit.planning.check import SafetyCheck, speed
from fieldkit.planning.classification import build_of
from fieldkit.planning.governed import governed
from fieldkit.planning.limits import Limit, Limits
from fieldkit.planning.rules import known_rules
from fieldkit.planning.safety import rail_line, thrust_line, thrust_to_weight
from fieldkit.settings import read_settings


def staged_lines(
    plan: Flight, found: Found, flown: Mapping[str, float], site: Site, limits: Limits
) -> list[SafetyCheck]:
    """The checks of a rocket with several stages: those of its one simulated flight, by column as in
    `fieldkit.physics.single.field_flight`, and the rules that govern the launch. Raises BadValue as `safety_lines`."""
    motor, mass = found.motor, math.nan if plan.dry_mass is None else plan.dry_mass
    day, own = plan.date_time.date() if plan.date_time else None, read_settings()
    site = replace(site, rules=site.rules or own.rules)
    by = governed(build_of(motor, mass), flown["true_apogee_m"], site, known_rules(), day)
    margin = "each stage as it flies: the whole rocket, and the upper stage alone"
    lines = [
        rail_line(np.array([flown.get("rail_speed_mps", 0.0)]), plan, limits),
        thrust_line({"in the first half second": thrust_to_weight(motor, mass)[0]}, limits),
        rule_lines.wind_line(by, plan.wind),
        rule_lines.angle_line(by, plan.rail_angle),
        replace(rule_lines.stability_line(by, None, 0, limits), finding=f"check it before flight: {margin}"),
        rule_lines.field_line(by, site.size),
        rule_lines.distance_line(by, site.people),
        rule_lines.bystander_line(by, site.bystanders),
        _staged_ejection(found.delay if plan.delay is None else plan.delay, flown, limits["eject_speed"]),
        SafetyCheck("landing speed", "unknown", "not modeled for stages: every part needs its own recovery", ""),
        rule_lines.mass_line(by),
        rule_lines.class_line(by),
        rule_lines.certification_line(by, own.flyer.certification),
        rule_lines.age_line(by, own.flyer.age(day)),
        rule_lines.complex_line(by, "if an upper one does not light, lower by all of its climb"),
    ]
    return [*lines, *rule_lines.reminder_lines(by)]


def _staged_ejection(delay: float | None, flown: Mapping[str, float], limit: Limit) -> SafetyCheck:
    """The speed at which the charge of the upper stage fires, in the one flight that was simulated."""
    name, fast = "ejection speed", flown.get("eject_speed_mps")
    if delay in (0, PLUGGED_DELAY):
        text = "the upper motor has no charge: an altimeter must deploy"
        return SafetyCheck(name, "caution" if delay else "unsafe", text, limit.source)
    if delay is None or fast is None:
        text = "delay of the upper motor unknown: add it to its name, as in C6-7"
        return SafetyCheck(name, "unknown", text, limit.source)
    after = flown.get("apogee_to_eject_s", 0.0)
    text = f"{speed(fast, 0)}, {abs(after):.1f} s {'after' if after >= 0 else 'before'} apogee"
    return SafetyCheck(
        name, "ok" if fast <= limit.value else "unsafe", f"{text}; at most {speed(limit.value, 0)}", limit.source
    )
