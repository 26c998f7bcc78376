"""The scenarios: effects, strengths, requirements for the season, and the right verdict."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from bench.rockets import Needs


@dataclass(frozen=True, slots=True)
class Part:
    """One effect in a scenario and its strengths, weak to strong, in the effect's own unit."""

    effect: str
    strengths: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Scenario:
    """A kind of set. `label` is the right verdict: effects joined by `+`, `none` or `unexplained`."""

    name: str
    label: str
    parts: tuple[Part, ...]
    needs: Needs = Needs()

    def strengths(self, level: int) -> tuple[float, ...]:
        """The strength of every part at a level; levels cycle."""
        return tuple(part.strengths[level % len(part.strengths)] for part in self.parts)

    def needs_at(self, level: int) -> Needs:
        """Requirements for a season at a level: weathercocking is a property of the rocket."""
        for part, strength in zip(self.parts, self.strengths(level), strict=True):
            if part.effect == "wind":
                return replace(self.needs, margin=(strength, strength + 0.05), rail=(0.9, 1.2), lift=(3.5, 8.0))
        return self.needs


INFORMATIVE = ("all", "all", "three")
"""Readouts for effects that the apogee alone cannot show."""
TEN = ("all",)

WIND = Part("wind", (1.3, 2.3, 3.5))
LAUNCH_ANGLE = Part("launch_angle", (5, 9, 15))
EJECTION = Part("early_ejection", (1.2, 2.0, 3.0))
AIR = Part("air_density", (1200, 2000, 3000))
HOT = Part("hot_days", (14, 20, 26))
MASS = Part("mass_offset", (0.05, 0.10, 0.15))
THRUST = Part("motor_thrust", (0.05, 0.08, 0.12))
CURVE = Part("thrust_curve", (0.15, 0.3, 0.5))
MACH = Part("mach_drag", (0.6, 1.0, 1.6))
SCALE = Part("altimeter_scale", (0.03, 0.05, 0.07))
WEAR = Part("wear", (0.01, 0.02, 0.04))
FRICTION = Part("rail_friction", (0.5, 1.0, 2.0))
BASE = Part("base_drag", (0.12, 0.25, 0.4))
MULTI_SITE = Needs(sites=2, conditions="all", high=300.0)
FAST = Needs(classes=("fast",), readouts=INFORMATIVE, top_speed=300.0, cd=(0.32, 0.45), lift=(5.0, 80.0))

_ALL = (
    Scenario("null", "none", (Part("none", (0,)),)),
    Scenario("null_scatter", "none", (Part("none", (0,)),), Needs(scatter=1.8)),
    Scenario("null_realistic", "none", (Part("realistic", (0,)),)),
    Scenario("wind", "wind", (WIND,), Needs(conditions="wind")),
    Scenario("wind_declared", "wind", (WIND,), Needs(conditions="all")),
    Scenario("launch_angle", "launch_angle", (LAUNCH_ANGLE,), Needs(readouts=INFORMATIVE)),
    Scenario("early_ejection", "early_ejection", (EJECTION,), Needs(readouts=INFORMATIVE)),
    Scenario("air_density", "air_density", (AIR,), MULTI_SITE),
    Scenario("hot_days", "air_density", (HOT,)),
    Scenario("mass_offset", "mass_offset", (MASS,), Needs(configs=2)),
    Scenario("motor_thrust", "motor_thrust", (THRUST,)),
    Scenario("thrust_curve", "thrust_curve", (CURVE,), Needs(readouts=TEN)),
    Scenario("mach_drag", "mach_drag", (MACH,), FAST),
    Scenario("altimeter_scale", "altimeter_scale", (SCALE,), Needs(readouts=INFORMATIVE)),
    Scenario("wear", "wear", (WEAR,)),
    Scenario("rail_friction", "rail_friction", (FRICTION,), Needs(readouts=TEN, rail=(1.8, 2.4))),
    Scenario("base_drag", "base_drag", (BASE,), Needs(readouts=INFORMATIVE)),
    Scenario("pair_wind_mass", "wind+mass_offset", (WIND, MASS), Needs(configs=2, conditions="wind")),
    Scenario("pair_wind_wear", "wind+wear", (WIND, WEAR), Needs(conditions="all")),
    Scenario("pair_thrust_wear", "motor_thrust+wear", (THRUST, WEAR), Needs(readouts=INFORMATIVE)),
    Scenario("pair_air_mass", "air_density+mass_offset", (AIR, MASS), replace(MULTI_SITE, configs=2)),
    Scenario("pair_ejection_scale", "early_ejection+altimeter_scale", (EJECTION, SCALE), Needs(readouts=TEN)),
    Scenario(
        "pair_mach_air", "mach_drag+air_density", (MACH, AIR), replace(FAST, sites=2, conditions="all", high=300.0)
    ),
    Scenario("pair_scale_wear", "altimeter_scale+wear", (SCALE, WEAR), Needs(readouts=TEN)),
    Scenario("pair_thrust_mass", "motor_thrust+mass_offset", (THRUST, MASS), Needs(configs=2, readouts=TEN)),
    Scenario("unknown_hour", "unexplained", (Part("hour_bias", (1.5, 2.5, 4.0)),)),
    Scenario("unknown_bad_day", "unexplained", (Part("bad_day", (0.2, 0.4, 0.7)),)),
    Scenario("unknown_drag_step", "unexplained", (Part("drag_step", (0.15, 0.3, 0.5)),)),
    Scenario("unknown_third_payload", "unexplained", (Part("third_payload", (0.08, 0.15, 0.25)),)),
)
SCENARIOS: Mapping[str, Scenario] = {scenario.name: scenario for scenario in _ALL}
"""Every scenario by its name."""
