"""Safety lines from rule sets: wind, angle, mass, impulse, field, distances, certification, and reminders.

If several sets have a rule for the same item, the line is that of the strictest. An unverified rule is marked, and its
line is never worse than caution.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date

from fieldkit.flight.recovery import MAX_STABILITY
from fieldkit.motors.motor import impulse_class
from fieldkit.motors.several import ONE_UNLIT
from fieldkit.planning.check import BY_EYE, SafetyCheck, Verdict, compared, figure, length, lengths, ratio, speed, worst
from fieldkit.planning.governed import UNTESTED, Governed
from fieldkit.planning.limits import Limits
from fieldkit.planning.rules import Rule, RuleRow, governing, known_rules, read_authorities
from fieldkit.units import DEGREE, STANDARD_GRAVITY

NO_RULE = "no rule in the chosen sets"
BREEZE, STABLE = 4.47, "with 4 calibers 0.5 to 1.3% lower than with 2"
"""A wind [m/s], and how much a larger margin lowers an apogee in it: flights of F24-4W (322 g, 66 mm), A8-3 (40 g,
25 mm) and C6-5 (60 g, 25 mm), with a Cd of 0.6."""
HEAVIER_MOTOR = 0.02
"""Mass of a motor beyond the heaviest one flown, over the mass on the pad, that requires another check of stability:
with the motor about five calibers behind the center of gravity it moves it back by a tenth of a caliber. [1]"""


def _line(
    check: str, rules: Sequence[Rule], judge: Callable[[Rule], SafetyCheck | None], without: str = NO_RULE
) -> SafetyCheck:
    """The strictest result of several rules."""
    found = [one for rule in rules if (one := judge(rule)) is not None]
    return worst(found) if found else SafetyCheck(check, "unknown", without, "")


def _check(name: str, verdict: Verdict, text: str, rule: Rule, row: RuleRow | None = None) -> SafetyCheck:
    text_of_rule = (row or rule).text
    verdict = "caution" if verdict == "unsafe" and text_of_rule.unverified else verdict
    words = f"{text_of_rule.words} ({row.stated})" if row is not None and row.stated else text_of_rule.words
    return SafetyCheck(name, verdict, text, f"{rule.of}; {text_of_rule.origin()}", words, text_of_rule.mark)


def wind_line(governed_by: Governed, wind: float | None) -> SafetyCheck:
    """Ground wind [m/s] against its upper limit."""

    def judge(rule: Rule) -> SafetyCheck:
        limit = rule.rows[0].value
        most = f"no launch above {speed(limit)}"
        if wind is None:
            return _check("ground wind", "unknown", f"not given; {most}", rule)
        text = f"{speed(wind)}; {most}"
        return _check("ground wind", "ok" if wind <= limit else "unsafe", text, rule)

    return _line("ground wind", governed_by.rules("ground wind"), judge)


def angle_line(governed_by: Governed, angle: float | None) -> SafetyCheck:
    """Angle of the rail from vertical [rad] against its upper limit."""

    def judge(rule: Rule) -> SafetyCheck:
        limit = rule.rows[0].value / DEGREE
        if angle is None:
            return _check("launch angle", "unknown", f"not given; at most {limit:.0f}°", rule)
        text = f"{abs(angle) / DEGREE:.0f}° from vertical, at most {limit:.0f}°"
        return _check("launch angle", "ok" if abs(angle) / DEGREE <= limit + 1e-6 else "unsafe", text, rule)

    rules = sorted(governed_by.rules("launch angle"), key=lambda rule: rule.rows[0].value)
    return _line("launch angle", rules, judge)


def mass_line(governed_by: Governed) -> SafetyCheck:
    """Lift-off mass, propellant and total impulse against the codes' limits for the kind of rocket."""
    build = governed_by.build
    found = {"mass": (build.mass, "g", ""), "propellant": (build.propellant, "g", " of propellant")}
    found["impulse"] = (build.impulse, "N s", "")
    lines = []
    for name, (value, unit, what) in found.items():
        for rule in governed_by.rules(name):
            limit = rule.rows[0].value
            verdict: Verdict = "unknown" if math.isnan(value) else "ok" if value <= limit + 1e-9 else "unsafe"
            own, most = compared(value, limit, unit)
            shown = f"{name} unknown" if math.isnan(value) else f"{own}{what}"
            lines.append(_check("mass and impulse", verdict, f"{shown}, at most {most}", rule))
    if not lines:
        return SafetyCheck("mass and impulse", "unknown", NO_RULE, "")
    last = worst(lines)
    texts = "; ".join(one.finding for one in lines)
    return SafetyCheck(last.name, last.verdict, texts, last.source, last.rule, last.mark)


def weight_line(governed_by: Governed) -> SafetyCheck | None:
    """Lift-off weight against the certified average thrust, if a code limits it; None if none does."""

    def judge(rule: Rule) -> SafetyCheck:
        found = governed_by.build.rated_thrust / (governed_by.build.mass * STANDARD_GRAVITY)
        least = 1 / rule.rows[0].value
        verdict: Verdict = "unknown" if math.isnan(found) else "ok" if found >= least - 1e-6 else "unsafe"
        text = f"{ratio(found, least - 1e-6)} from the certified thrust, needs at least {least:.0f}"
        return _check("thrust to weight", verdict, text, rule)

    rules = governed_by.rules("weight over thrust")
    return _line("thrust to weight", rules, judge) if rules else None


def field_line(governed_by: Governed, size: float | None) -> SafetyCheck:
    """The field's shorter side [m] against the codes' minimum."""

    def judge(rule: Rule) -> SafetyCheck:
        needed = rule.least(governed_by.build.impulse, governed_by.altitude)
        row = rule.row(governed_by.build.impulse, governed_by.altitude)
        if needed is None:
            return _check("field size", "unknown", "beyond the table of the code", rule)
        why = ""
        if rule.pad_inside and (round_pad := 2 * governed_by.people_distance()) > needed:
            needed, why = round_pad, ", twice the distance of people from a pad in its middle"
        if size is None:
            text = f"the code requires {length(needed)} across{why}; field size not given"
            return _check("field size", "unknown", text, rule, row)
        if row is not None and (sure := rule.verified_below(row)) and size < sure.value - 1e-6:
            row, needed = sure, sure.value
        wanted, own = lengths(needed, size)
        text = f"the code requires {wanted} across{why}"
        verdict: Verdict = "ok" if size >= needed - 1e-6 else "unsafe"
        if verdict == "unsafe" and (small := _small_field(governed_by)) and size >= small.rows[0].value - 1e-6:
            text_small = f"{text}, {length(small.rows[0].value)} for small high power; this field is {own}"
            return _check("field size", "caution", text_small, small)
        return _check("field size", verdict, f"{text}; this field is {own}", rule, row)

    wanted = governed_by.rules("field size")
    wanted.sort(key=lambda rule: -(rule.least(governed_by.build.impulse, governed_by.altitude) or math.inf))
    return _line("field size", wanted, judge)


@dataclass(frozen=True, slots=True)
class FieldSize:
    """The shorter side of a field that a `code` requires for model rockets with motors of some classes. [m]"""

    code: str
    classes: str
    least: float


def field_sizes(rules: str) -> list[FieldSize]:
    """The fields that the first of some authorities with a table by impulse requires today for model rockets.

    Raises BadValue for a damaged file of rules and for an authority without rule sets.
    """
    sets = governing(known_rules(), read_authorities(rules), False, date.today())
    for one in sets:
        for rule in one.rules:
            if rule.check == "field size" and rule.by == "impulse":
                letters: dict[float, list[str]] = {}
                for row in rule.rows:
                    letter = impulse_class(row.up_to)
                    letters.setdefault(row.value, []).append("two Gs" if letter == "H" else letter)
                return [
                    FieldSize(one.title, f"{own[0]} to {own[-1]}" if own[1:] else own[0], least)
                    for least, own in letters.items()
                ]
    return []


def _small_field(governed_by: Governed) -> Rule | None:
    """The rule for the field of a small high-power rocket, if it applies."""
    for rule in governed_by.rules("small high power field"):
        build, only = governed_by.build, rule.only
        if build.impulse < only["impulse"] and build.mass < only["mass"] and governed_by.altitude < only["altitude"]:
            return rule
    return None


def distance_line(governed_by: Governed, people: float | None) -> SafetyCheck:
    """The distance from the pad to the people at the launch [m] against the table or its column for complex rockets."""
    name, build = "pad distance", governed_by.build

    def judge(rule: Rule) -> SafetyCheck:
        row = rule.row(build.impulse, governed_by.altitude)
        needed = rule.least(build.impulse, governed_by.altitude, complex_rocket=build.complex)
        if row is None or needed is None:
            return _check(name, "unsafe", f"{build.impulse:.0f} N s is beyond the table", rule)
        wanted, *own = lengths(needed) if people is None else lengths(needed, people)
        text = f"people at least {wanted} away"
        if build.complex and row.complex is not None:
            text += " because the rocket is complex"
        if row.cleared is not None:
            times = governed_by.cleared_times()
            sparks = f", {times:g} times as wide because of sparks" if times > 1 else ""
            text += f", {length(times * row.cleared)} across cleared around the pad{sparks}"
        if people is None:
            return _check(name, "unknown", f"{text}; distance not given", rule, row)
        verdict: Verdict = "ok" if people >= needed - 1e-6 else "unsafe"
        return _check(name, verdict, f"{text}; they are {own[0]} away", rule, row)

    rules = governed_by.rules(name)
    rules.sort(
        key=lambda rule: -(rule.least(build.impulse, governed_by.altitude, complex_rocket=build.complex) or math.inf)
    )
    return _line(name, rules, judge)


def bystander_line(governed_by: Governed, away: float | None) -> SafetyCheck:
    """The distance to uninvolved people and property [m] against the law's minimum for the class."""
    name = "bystanders"

    def judge(rule: Rule) -> SafetyCheck:
        needed = rule.least(governed_by.build.impulse, governed_by.altitude) or 0.0
        wanted, *own = lengths(needed) if away is None else lengths(needed, away)
        text = f"uninvolved people and property at least {wanted} away"
        if away is None:
            return _check(name, "unknown", f"{text}; distance not given", rule)
        verdict: Verdict = "ok" if away >= needed - 1e-6 else "unsafe"
        return _check(name, verdict, f"{text}; they are {own[0]} away", rule)

    rules = governed_by.rules(name)
    if not rules and governed_by.legal == 1:
        law = governed_by.law.title if governed_by.law else ""
        return SafetyCheck(name, "ok", "no set distance for class 1, but no hazard to them", law)
    return _line(name, rules, judge)


def class_line(governed_by: Governed) -> SafetyCheck:
    """Model or high power, and the class of the law."""
    build = governed_by.build
    mass = "unknown mass" if math.isnan(build.mass) else f"{figure(build.mass, 'g')} on the pad"
    text = f"{figure(build.propellant, 'g')} of propellant, {mass}, {build.impulse:.0f} N s"
    law = governed_by.law
    source = f"{law.title}; {law.text.origin()}" if law else ""
    words = str(law.classes.get("says", "")) if law else ""
    name = f"class {governed_by.legal}" if governed_by.legal else "no air law in the chosen sets"
    if governed_by.legal == 3:
        return SafetyCheck("class", "unsafe", f"{text}: class 3, beyond high power", source, words, "O")
    if not governed_by.why and governed_by.legal in (None, 1):
        return SafetyCheck("class", "ok", f"{text}: {name}, a model rocket", source)
    waiver = ", which needs an authorization (waiver) in controlled airspace" if governed_by.legal == 2 else ""
    high = f"high power because of {governed_by.why}" if governed_by.why else "not high power under club rules"
    return SafetyCheck("class", "caution", f"{text}: {name}{waiver}, {high}", source)


def certification_line(governed_by: Governed, own: int | None = None) -> SafetyCheck:
    """The certification level that the motors require, against the flyer's own; None if not known, 0 for none.

    A flyer may fly for the next level at a certification flight; a motor above it is not allowed.
    """
    name = "certification"
    if not governed_by.why:
        return SafetyCheck(name, "ok", "none needed: not high power", "")

    def judge(rule: Rule) -> SafetyCheck:
        level = rule.least(governed_by.build.impulse, governed_by.altitude)
        if level is None:
            return _check(name, "unsafe", f"{governed_by.build.impulse:.0f} N s is beyond every level", rule)
        text = f"requires certification level {level:.0f}"
        if own is None:
            return _check(
                name, "caution", f"{text}; yours is not on your card (fieldkit flyer --certification 1)", rule
            )
        if own >= level:
            return _check(name, "ok", f"{text}; yours is {own}", rule)
        yours = f"yours is {own}" if own else "you have none"
        if level == own + 1:
            return _check(name, "caution", f"{text}; {yours}: only as a certification flight, with its witnesses", rule)
        return _check(name, "unsafe", f"{text}; {yours}", rule)

    return _line(name, governed_by.rules(name), judge, "high power: none of the chosen rules names a level")


def age_line(governed_by: Governed, age: int | None = None) -> SafetyCheck:
    """The age at which the motors are sold, or the rocket may be flown, against the flyer's. [years]"""
    name = "age"

    def judge(rule: Rule) -> SafetyCheck:
        least = rule.rows[0].value
        if age is None:
            return _check(
                name, "unknown", f"from {least:.0f} years on; yours is not on your card (fieldkit flyer --born)", rule
            )
        verdict: Verdict = "ok" if age >= least else "unsafe"
        return _check(name, verdict, f"from {least:.0f} years on; you are {age}", rule)

    rules = [rule for rule in governed_by.rules(name) if governed_by.over(rule)]
    if not rules:
        return SafetyCheck(name, "ok", "no least age for these motors in the chosen sets", "")
    return _line(name, rules, judge)


def stability_line(
    governed_by: Governed, margin: float | None, flown: int, limits: Limits, added: float = 0.0
) -> SafetyCheck:
    """The static margin on the pad [1] against guidance; without one, what must be checked before a rocket that has not
    flown does, or not with so heavy a motor, by the codes' own words.

    `flown` are the flights of the rocket that were measured, `added` the mass of the motor beyond the heaviest one of
    these flights [kg].
    """
    name, least, most = "stability", limits["stability"], limits["stability_most"]
    times = "once" if flown == 1 else f"{flown} times"
    if margin is None and flown and not added > HEAVIER_MOTOR * governed_by.build.mass:
        return SafetyCheck(name, "ok", f"flown {times} with motors as heavy as this one", least.source)
    if margin is None:
        why = f"it flew {times}, but this motor is {figure(added, 'g')} heavier than any flown"
        why = f"no static margin, and {why if flown else 'this rocket has not flown'}"
        text = f"{why}: check it before flight, at least {least.value:g} caliber (--stability-cal, or its design)"
        verdict: Verdict = "caution" if flown else "unknown"

        def judge(rule: Rule) -> SafetyCheck:
            return _check(name, verdict, text, rule)

        if rules := governed_by.texts(UNTESTED):
            return _line(name, rules, judge)
        return SafetyCheck(name, verdict, text, least.source)
    if margin <= 1 / MAX_STABILITY:  # the least that a plan can state
        text = "the center of pressure is not behind the center of gravity: it is unstable with this motor"
        return SafetyCheck(name, "unsafe", text, least.source)
    text = f"{ratio(margin, least.value)} calibers, at least {least.value:g}"
    if margin < least.value:
        return SafetyCheck(name, "caution", f"{text}: show that it flies straight", least.source)
    if margin > most.value:
        return SafetyCheck(
            name,
            "caution",
            f"{text}; above {most.value:g} it turns into the wind: in {speed(BREEZE)} {STABLE}",
            most.source,
        )
    return SafetyCheck(name, "ok", text, least.source)


def complex_line(governed_by: Governed, one_unlit: str = ONE_UNLIT) -> SafetyCheck:
    """What a cluster or several stages require beyond a single motor, with how low it flies if one does not light."""
    name = "complex rocket"
    if not governed_by.build.complex:
        return SafetyCheck(name, "ok", "one motor, one stage", "")
    text = f"{len(governed_by.build.motors)} motors, forecast as if every one lights: {one_unlit}"

    def judge(rule: Rule) -> SafetyCheck:
        row = rule.row(governed_by.build.impulse, governed_by.altitude)
        wanted = "" if row is None else f", people at least {length(row.value)} away"
        return _check(name, "caution", text + wanted, rule, row)

    if rules := governed_by.rules(name):
        return _line(name, rules, judge)
    return SafetyCheck(name, "caution", f"{text}: the complex column of the distance table applies", "")


def reminder_lines(governed_by: Governed) -> Iterator[SafetyCheck]:
    """Rules that the program cannot check a plan against, in their own words."""
    for rule in governed_by.reminders():
        suffix = " (unverified)" if rule.text.unverified else ""
        words = f"{BY_EYE}{rule.text.words}{suffix}"
        yield SafetyCheck(rule.check, "unknown", words, f"{rule.of}; {rule.text.origin()}")
