"""A season's limits on the pad, line by line: mass, impulse, length, the motor list, and rules to check by eye."""

import math
import re
from pathlib import Path

from fieldkit import files, units
from fieldkit.flight import Flight
from fieldkit.messages import QUANTITY, of_unit
from fieldkit.motors import Found
from fieldkit.motors.motor import Motor, impulse_class
from fieldkit.motors.names import parse, squeeze
from fieldkit.paths import data_file
from fieldkit.planning.check import BY_EYE, SafetyCheck, Verdict
from fieldkit.planning.classification import build_of, why_high_power
from fieldkit.planning.contest import Season
from fieldkit.planning.rules import MARKS, known_rules
from fieldkit.quantities import rounded

ROUNDING = 1e-9
"""Excess over a limit that is only the rounding of a sum, as a fraction of the limit. [1]"""

_DELAYS = re.compile(r"[\d.,]")
"""Characters of a list of delays that are read with the letters: `3,6,9T`."""
LOADABLE_SUFFIX = "L"
"""Last letter of a motor that is sold loaded too: `F42T/L`."""


def approved_motors(year: int, own: Path | None = None) -> frozenset[str] | None:
    """The lines of a season's approved list, in the user's file `2027_motors.txt`, one motor each; None without it."""
    file = own / f"{year}_motors.txt" if own is not None else None
    if file is None or not file.exists():
        return None
    lines = (line.partition("#")[0].strip() for line in files.read_own(file).splitlines())
    return frozenset(line for line in lines if line)


def motor_line(rule: Season, found: Found, approved: frozenset[str] | None) -> SafetyCheck:
    """Whether a motor is on the season's approved list in the user's file."""
    motor = found.motor
    name = f"{motor.maker} {motor.designation}"
    if approved is None:
        kept = "impulse within the limit; " if rule.impulse is None or motor.total_impulse <= rule.impulse else ""
        where = f"{rule.year}_motors.txt among your own seasons"
        return SafetyCheck("contest motor list", "unknown", f"{kept}check the season's motor list ({where})", "")
    listed = any(_is_listed(motor, line) for line in approved)
    text = f"{name} is {'on' if listed else 'not on'} your copy of the list"
    return SafetyCheck("contest motor list", "ok" if listed else "unsafe", text, f"{rule.year}_motors.txt")


def _is_listed(motor: Motor, line: str) -> bool:
    """Whether a line names a motor, with or without its maker, letters and delays: `AeroTech F39-6,9T`.

    A line without maker and letters, `F50`, names only the motor with exactly that designation.
    """
    if squeeze(line) in (squeeze(motor.designation), squeeze(f"{motor.maker} {motor.designation}")):
        return True
    on_list, own = parse(line), parse(motor.designation)
    letters = _DELAYS.sub("", on_list.letters)
    if on_list.core != motor.name or on_list.prefix not in ("", own.prefix) or on_list.maker not in ("", motor.maker):
        return False
    if not (letters or on_list.maker):
        return False
    return letters in ("", own.letters) or letters + LOADABLE_SUFFIX == own.letters


def allowed(rule: Season, plan: Flight, found: Found, length: float | None = None) -> list[SafetyCheck]:
    """One line for each limit of a season: mass on the pad, total impulse, minimum length [m] of the rocket, rules to
    check by eye, and the flyer's copy of the motor list. Raises BadValue for a damaged file of rules."""
    mass = None if plan.dry_mass is None else plan.dry_mass + found.motor.loaded_mass
    checks = [
        ("contest mass", mass, rule.mass, "at most", "g"),
        ("contest impulse", found.motor.total_impulse, rule.impulse, "at most", "N s"),
        ("contest length", length, rule.length, "at least", "mm"),
    ]
    lines = []
    for name, value, limit, how, unit in checks:
        if limit is None:
            continue
        source, wanted = _limit_source(rule, name), f"{how} {_shown(limit, unit)}"
        if value is None:
            lines.append(SafetyCheck(name, "unknown", f"not given; {wanted}", source))
            continue
        well = value <= limit * (1 + ROUNDING) if how == "at most" else value >= limit * (1 - ROUNDING)
        own = next((digits for digits in range(4, 9) if well or rounded(value, digits) != rounded(limit, digits)), 9)
        lines.append(SafetyCheck(name, "ok" if well else "unsafe", f"{_shown(value, unit, own)}, {wanted}", source))
    lines += [class_line(rule, found)] if rule.impulse is not None else []
    for name, text in rule.by_hand:
        look = f"{BY_EYE}{text}"
        lines.append(SafetyCheck(f"contest {name}", "unknown", look, _limit_source(rule, name)))
    return [*lines, motor_line(rule, found, approved_motors(rule.year, data_file("seasons")))]


def _shown(value: float, unit: str, digits: int = 4) -> str:
    """A figure of a limit [SI] within a finding."""
    return of_unit(value, unit, digits=digits, scale=units.unit(QUANTITY[unit], unit))


def class_line(rule: Season, found: Found) -> SafetyCheck:
    """The class of the motor against the largest of the season, which that of its impulse limit is; a motor of high
    power, by its thrust too, is none of model rockets, which contests are for.

    Raises BadValue for a damaged file of rules.
    """
    name, motor = "contest motor class", found.motor
    parts = motor.parts or (motor,)
    largest = impulse_class(rule.impulse or math.inf)
    if why := why_high_power(build_of(motor, math.nan), known_rules()):
        text = f"class {largest} or smaller; high power because of {why}"
        return SafetyCheck(name, "unsafe", text, _limit_source(rule, "motors"))
    above = [one for one in parts if one.total_impulse > (rule.impulse or math.inf) * (1 + ROUNDING)]
    own = impulse_class(max(one.total_impulse for one in parts))
    verdict: Verdict = "unsafe" if above else "ok"
    return SafetyCheck(name, verdict, f"class {own}, {largest} or smaller", _limit_source(rule, "motors"))


def _limit_source(rule: Season, name: str) -> str:
    """The source of a season's limit, and its reliability."""
    mark = MARKS.get(rule.marks.get(name.removeprefix("contest "), rule.mark), "unverified")
    source = f"season {rule.year}: {rule.source}; {mark}"
    return source if rule.checked else f"{source}, not checked against this season's rules"
