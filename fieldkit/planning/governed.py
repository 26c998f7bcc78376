"""A rocket under the rule sets that govern it: model or high power, its legal class, and the rules that apply."""

import datetime
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from fieldkit.flight.site import Site
from fieldkit.planning.classification import Build, legal_class, why_high_power
from fieldkit.planning.rules import Rule, RuleSet, governing, read_authorities

UNTESTED = "untested stability"
"""The rule about the stability of a rocket that has not flown, a text on which the check of the static margin rests."""
FIGURE_RULES = (
    "ground wind",
    "launch angle",
    "mass",
    "propellant",
    "impulse",
    "weight over thrust",
    "field size",
    "small high power field",
    "pad distance",
    "complex rocket",
    "bystanders",
    "certification",
    UNTESTED,
    "age",
)
"""Rules that a value of the plan is checked against; all others become reminders."""


@dataclass(frozen=True, slots=True)
class Governed:
    """A build under the rule sets that govern it: why it is high power, if it is, its legal class, and its rules.
    `altitude` is the expected one. [m]"""

    build: Build
    sets: tuple[RuleSet, ...]
    why: str
    legal: int | None
    law: RuleSet | None
    altitude: float

    def rules(self, check: str) -> list[Rule]:
        """The rules of one kind that apply to this build."""
        return [
            rule
            for one in self.sets
            for rule in one.rules
            if rule.check == check and rule.rows and (not rule.classes or self.legal in rule.classes)
        ]

    def texts(self, check: str) -> list[Rule]:
        """The rules of one kind that are only text."""
        return [rule for one in self.sets for rule in one.rules if rule.check == check and not rule.rows]

    def over(self, rule: Rule) -> bool:
        """Whether one of the motors exceeds one of the figures of a rule, if it has any."""
        return not rule.motors_over or any(
            one.total_impulse > rule.motors_over.get("impulse", inf)
            or one.rated_thrust > rule.motors_over.get("average", inf)
            or one.propellant_mass > rule.motors_over.get("propellant", inf)
            for one in self.build.motors
        )

    def people_distance(self) -> float:
        """The distance that the codes require from the pad to the people at the launch; 0 without one. [m]"""
        rules, several = self.rules("pad distance"), self.build.complex
        needed = (rule.least(self.build.impulse, self.altitude, complex_rocket=several) for rule in rules)
        return max((distance or 0.0 for distance in needed), default=0.0)

    def reminders(self) -> list[Rule]:
        """The rules that no value of a plan can be checked against."""
        every = [
            rule
            for one in self.sets
            for rule in one.rules
            if rule.check not in FIGURE_RULES or not (rule.rows or rule.check == UNTESTED)
        ]
        return [
            rule
            for rule in every
            if (not rule.classes or self.legal in rule.classes) and (not rule.propellants or self._burns(rule))
        ]

    def cleared_times(self) -> float:
        """How much wider the cleared area around the pad must be with these motors than the table says. [1]"""
        return max((rule.cleared_times for one in self.sets for rule in one.rules if self._burns(rule)), default=1.0)

    def _burns(self, rule: Rule) -> bool:
        """Whether a motor of this build burns a propellant of a rule."""
        return any(motor.propellant in rule.propellants for motor in self.build.motors)


def governed(
    build: Build, altitude: float, site: Site, sets: Sequence[RuleSet], day: datetime.date | None = None
) -> Governed:
    """The rules for a build with an expected altitude [m], at a site, on a day (today by default).

    Raises BadValue for an authority without rule sets.
    """
    authorities, day = read_authorities(site.rules), day or datetime.date.today()
    own = [one for one in sets if one.authority.casefold() in {name.casefold() for name in authorities}]
    why = why_high_power(build, [*own, *sets])
    chosen = governing(sets, authorities, bool(why), day)
    law = next((one for one in chosen if one.classes), None)
    legal = legal_class(build, law.classes) if law else None
    return Governed(build, tuple(chosen), why, legal, law, altitude)
