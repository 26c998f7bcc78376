"""Every limit of the rules, just met and just missed: sites, distances, angle, wind, mass, impulse, certification."""

import datetime
import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from fieldkit import units
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import Found, catalogue
from fieldkit.motors.motor import Motor
from fieldkit.planning import rule_lines
from fieldkit.planning.check import SafetyCheck
from fieldkit.planning.classification import Build
from fieldkit.planning.contest import season
from fieldkit.planning.contest_limits import allowed
from fieldkit.planning.governed import Governed, governed
from fieldkit.planning.rules import rule_sets
from fieldkit.units import DEGREE, FOOT, STANDARD_GRAVITY

pytestmark = pytest.mark.fast
SETS = rule_sets()
TODAY = datetime.date(2026, 11, 22)
CLOSE = 1e-3
"""How far beyond a limit the values are, relative to it. [1]"""
C6 = catalogue().resolve("Estes C6").motor


def motor(impulse: float = 8.8, propellant: float = 0.02, thrust: float = 40.0, **changes: Any) -> Motor:
    """A motor with a total impulse [N s], propellant [kg], and certified average thrust [N]."""
    given: dict[str, Any] = {"total_impulse": impulse, "propellant_mass": propellant, "certified_average": thrust}
    return replace(C6, **given, **changes)


def rocket(*motors: Motor, mass: float = 0.3, altitude: float = 200.0, rules: str = "", high: bool = False) -> Governed:
    """A rocket of a mass on the pad [kg] with these motors, expected to reach an altitude [m]; `high` makes it high
    power by its propellant's kind and nothing else."""
    motors = motors or (motor(),)
    motors = tuple(replace(one, kind="hybrid") for one in motors) if high else motors
    build = Build(motors, mass, len(motors) > 1)
    return governed(build, altitude, Site(rules=rules), SETS, TODAY)


def typed(text: str, quantity: str) -> float:
    """A value as the flyer types it, with its unit. [SI]"""
    return units.parse(text, quantity, "")


def around(limit: float) -> tuple[float, float, float]:
    """A limit, and values just below and just above it."""
    return limit * (1 - CLOSE), limit, limit * (1 + CLOSE)


SITES = [(1.25, 50), (2.5, 100), (5, 200), (10, 400), (20, 500), (40, 1000), (80, 1000), (160, 1000), (320, 1500)]
"""Largest installed impulse [N s], and the least dimension of the site [ft]."""


@pytest.mark.parametrize(("impulse", "feet"), SITES)
def test_the_site_of_a_model_rocket(impulse: float, feet: int) -> None:
    parts = (motor(impulse),) if impulse <= 160 else (motor(impulse / 2), motor(impulse / 2))
    found = rocket(*parts)
    small, just, large = around(typed(f"{feet}ft", "length"))
    verdicts = [rule_lines.field_line(found, size).verdict for size in (small, just, large)]
    assert verdicts == ["unsafe", "ok", "ok"]


@pytest.mark.parametrize(("row", "next_row"), list(pairwise(SITES)))
def test_a_motor_just_above_a_class_needs_the_site_of_the_next(
    row: tuple[float, int], next_row: tuple[float, int]
) -> None:
    (impulse, _), (_, feet) = row, next_row
    parts = (motor(impulse + 0.01),) if impulse < 160 else (motor(80.01), motor(80.0))
    line = rule_lines.field_line(rocket(*parts), None)
    assert f"{feet} ft across" in line.words("US").replace(",", "")


@pytest.mark.parametrize(
    ("impulse", "feet"), [(1.0, 15), (20.0, 15), (20.01, 30), (160.0, 30)], ids=["A", "D", "above D", "G"]
)
def test_the_distance_from_the_pad_of_a_model_rocket(impulse: float, feet: int) -> None:
    near, just, far = around(typed(f"{feet}ft", "length"))
    verdicts = [rule_lines.distance_line(rocket(motor(impulse)), one).verdict for one in (near, just, far)]
    assert verdicts == ["unsafe", "ok", "ok"]


@pytest.mark.parametrize(("impulse", "feet"), [(10.0, 15), (10.01, 30)])
def test_a_cluster_counts_with_the_impulse_of_all_its_motors(impulse: float, feet: int) -> None:
    pair = rocket(motor(10.0), motor(impulse))
    near, just, _ = around(feet * FOOT)
    assert [rule_lines.distance_line(pair, one).verdict for one in (near, just)] == ["unsafe", "ok"]
    assert f"people at least {feet} ft away" in rule_lines.complex_line(pair).words("US")
    assert rule_lines.complex_line(pair).verdict == "caution"
    assert rule_lines.complex_line(rocket(motor(10.0))).verdict == "ok"


HIGH = [
    (320.0, 100, 200),
    (640.0, 100, 200),
    (1280.0, 100, 200),
    (2560.0, 200, 300),
    (5120.0, 300, 500),
    (10240.0, 500, 1000),
    (20480.0, 1000, 1500),
    (40960.0, 1500, 2000),
]
"""Largest installed impulse [N s], and the distance of people from a simple and from a complex rocket [ft]."""


@pytest.mark.parametrize(("impulse", "simple", "several"), HIGH)
def test_the_distance_from_the_pad_of_high_power(impulse: float, simple: int, several: int) -> None:
    for parts, feet in (((motor(impulse),), simple), ((motor(impulse / 2), motor(impulse / 2)), several)):
        found = rocket(*parts, high=True)
        near, just, far = around(typed(f"{feet}ft", "length"))
        verdicts = [rule_lines.distance_line(found, one).verdict for one in (near, just, far)]
        assert verdicts == ["unsafe", "ok", "ok"], feet
    beyond = rule_lines.distance_line(rocket(motor(40960.01), high=True), 1e5)
    assert (beyond.verdict, "beyond the table" in beyond.text) == ("unsafe", True)


@pytest.mark.parametrize(
    ("altitude", "feet"), [(2999.0, 1500), (3000.0, 1500), (3002.0, 1501)], ids=["lower", "equal", "higher"]
)
def test_the_site_of_high_power_is_half_the_altitude_or_1500_feet(altitude: float, feet: int) -> None:
    found = rocket(motor(500.0), mass=3.0, altitude=altitude * FOOT)
    near, just = (feet - 0.1) * FOOT, feet * FOOT
    assert [rule_lines.field_line(found, one).verdict for one in (near, just)] == ["unsafe", "ok"]


@pytest.mark.parametrize(
    ("impulse", "mass", "altitude", "verdict"),
    [
        (159.9, 1.499, 1999.0, "caution"),
        (160.0, 1.499, 1999.0, "unsafe"),
        (159.9, 1.5, 1999.0, "unsafe"),
        (159.9, 1.499, 2000.0, "unsafe"),
    ],
)
def test_a_small_high_power_rocket_is_within_every_bound_of_its_rule(
    impulse: float, mass: float, altitude: float, verdict: str
) -> None:
    found = rocket(motor(impulse, thrust=90.0), mass=mass, altitude=altitude * FOOT)
    assert rule_lines.field_line(found, 1000 * FOOT).verdict == verdict
    assert rule_lines.field_line(found, 999 * FOOT).verdict == "unsafe"


@pytest.mark.parametrize(("high", "degrees"), [(False, 30), (True, 20)])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_angle_of_the_rail(high: bool, degrees: int, sign: int) -> None:
    found = rocket(high=high)
    angles = [sign * one * DEGREE for one in around(float(degrees))]
    assert [rule_lines.angle_line(found, one).verdict for one in angles] == ["ok", "ok", "unsafe"]
    assert rule_lines.angle_line(found, sign * typed(f"{degrees}deg", "angle")).verdict == "ok"


@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("rules", ["", "Tripoli,FAA", "UKRA", "NAR,FAA,California"])
def test_the_wind(high: bool, rules: str) -> None:
    found = rocket(high=high, rules=rules)
    winds = around(typed("20mph", "speed"))
    assert [rule_lines.wind_line(found, one).verdict for one in winds] == ["ok", "ok", "unsafe"]


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"mass": 1.5}, "at lift-off"),
        ({"propellant": 0.125}, "of propellant"),
        ({"impulse": 160.0}, "more than 160 N s"),
        ({"thrust": 80.0}, "average thrust"),
    ],
)
def test_a_rocket_is_high_power_just_above_a_limit_and_a_model_rocket_at_it(
    changes: dict[str, float], why: str
) -> None:
    ((name, limit),) = changes.items()

    def of(value: float) -> Governed:
        if name == "mass":
            return rocket(mass=value)
        return rocket(motor(**{name: value}))

    below, at, above = map(of, around(limit))
    assert (below.why, at.why) == ("", "")
    assert why in above.why
    assert [one.sets[0].key for one in (at, above)] == ["nar_model", "nar_high_power"]
    assert rule_lines.class_line(at).verdict == "ok"
    assert rule_lines.class_line(above).verdict == "caution"


def test_a_cluster_is_high_power_above_320_newton_seconds_together() -> None:
    assert rocket(motor(160.0), motor(160.0)).why == ""
    assert "in all its motors" in rocket(motor(160.0), motor(160.0), motor(0.01)).why
    assert rocket(motor(159.0, propellant=0.0625), motor(160.0, propellant=0.0625)).why == ""
    assert "of propellant" in rocket(motor(159.0, propellant=0.0625), motor(1.0, propellant=0.0626)).why


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"kind": "hybrid"}, "hybrid"),
        ({"designation": "HP-F50"}, "HP in its designation"),
        ({"propellant": "Skidmark"}, "throws sparks"),
        ({"designation": "G80T", "certified_average": 77.99}, ""),
        ({"designation": "F100", "certified_average": 79.9}, ""),
        ({"designation": "G72", "certified_average": 80.78}, "certified average thrust of 80.8 N"),
    ],
)
def test_what_makes_a_motor_high_power_besides_its_size(changes: dict[str, Any], why: str) -> None:
    """The certified average decides, and neither the number in the name nor the average of the curve."""
    found = rocket(replace(motor(), **changes)).why
    assert (why in found) if why else not found


def test_the_average_of_the_curve_decides_only_without_a_certified_one() -> None:
    more = 81 / (C6.total_impulse / C6.rated_burn)
    strong = replace(C6, thrust=C6.thrust * more, total_impulse=C6.total_impulse * more, certified_average=None)
    assert "its impulse over its burn time, 81.0 N" in rocket(strong).why
    assert rocket(replace(strong, certified_burn=1.02 * C6.rated_burn)).why == ""
    assert rocket(replace(strong, certified_average=80.0)).why == ""


@pytest.mark.parametrize(
    ("impulse", "level"), [(160.01, 1), (640.0, 1), (640.01, 2), (5120.0, 2), (5120.01, 3), (40960.0, 3)]
)
@pytest.mark.parametrize("rules", ["", "Tripoli,FAA"])
def test_the_level_of_certification(impulse: float, level: int, rules: str) -> None:
    found = rocket(motor(impulse), rules=rules)
    line = rule_lines.certification_line(found)
    assert (line.verdict, line.text.partition(";")[0]) == ("caution", f"requires certification level {level}")
    own = [rule_lines.certification_line(found, own).verdict for own in range(4)]
    assert own == ["unsafe"] * (level - 1) + ["caution"] + ["ok"] * (4 - level)
    assert rule_lines.certification_line(rocket(motor(160.0), rules=rules)).verdict == "ok"


def test_nothing_is_allowed_beyond_the_largest_impulse() -> None:
    at, above = rocket(motor(40960.0, propellant=20.0)), rocket(motor(40961.0, propellant=20.0))
    assert rule_lines.mass_line(at).verdict == "ok"
    assert rule_lines.mass_line(above).verdict == "unsafe"
    assert rule_lines.certification_line(above).verdict == "unsafe"
    assert (at.legal, above.legal) == (2, 3)
    assert rule_lines.class_line(above).verdict == "unsafe"


@pytest.mark.parametrize(
    ("altitude", "feet"), [(5999.0, 1500.0), (6000.0, 1500.0), (6004.0, 1501.0)], ids=["lower", "equal", "higher"]
)
def test_bystanders_of_high_power_are_a_quarter_of_the_altitude_or_1500_feet_away(altitude: float, feet: float) -> None:
    found = rocket(motor(500.0, propellant=0.2), mass=3.0, altitude=altitude * FOOT)
    near, just = (feet - 0.1) * FOOT, feet * FOOT
    assert [rule_lines.bystander_line(found, one).verdict for one in (near, just)] == ["unsafe", "ok"]
    assert rule_lines.bystander_line(found, None).verdict == "unknown"


@pytest.mark.parametrize(
    ("mass", "propellant", "legal"), [(1.5, 0.125, 1), (1.5 * (1 + CLOSE), 0.125, 2), (1.5, 0.125 * (1 + CLOSE), 2)]
)
def test_the_class_of_the_law(mass: float, propellant: float, legal: int) -> None:
    found = rocket(motor(propellant=propellant), mass=mass)
    assert found.legal == legal
    assert rule_lines.bystander_line(found, None).verdict == ("ok" if legal == 1 else "unknown")


def test_high_power_weighs_at_most_a_third_of_its_certified_thrust() -> None:
    thrust = 150.0
    heaviest = thrust / 3 / STANDARD_GRAVITY
    lines = [rule_lines.weight_line(rocket(motor(200.0, thrust=thrust), mass=one)) for one in around(heaviest)]
    assert [line.verdict for line in lines if line] == ["ok", "ok", "unsafe"]
    assert rule_lines.weight_line(rocket(motor(100.0, thrust=1.0))) is None


@pytest.mark.parametrize(("altitude", "size"), [(1200.0, 300.0)])
def test_a_quarter_of_the_altitude_is_enough_only_in_a_contest_of_the_nar(altitude: float, size: float) -> None:
    contest, plain = (rocket(motor(60.0), altitude=altitude, rules=rules) for rules in ("NAR contest", ""))
    sizes = around(size)
    assert [rule_lines.field_line(contest, one).verdict for one in sizes] == ["unsafe", "ok", "ok"]
    assert [rule_lines.field_line(plain, one).verdict for one in sizes] == ["unsafe"] * 3


@pytest.mark.parametrize(("feet", "size"), [(3000.0, 500.0), (6000.0, 1000.0), (10000.0, 2000.0), (12000.0, 3000.0)])
def test_the_fields_of_canada(feet: float, size: float) -> None:
    found = rocket(motor(60.0), altitude=feet * FOOT, rules="CAR")
    assert [rule_lines.field_line(found, one).verdict for one in around(size)] == ["unsafe", "ok", "ok"]
    above = rule_lines.field_line(rocket(motor(60.0), altitude=feet * FOOT * (1 + CLOSE), rules="CAR"), size)
    assert above.verdict == ("unknown" if feet == 12000 else "unsafe")


def lines_of(dry_mass: float, impulse: float, length: float) -> dict[str, SafetyCheck]:
    found = Found(motor(impulse), None)
    return {one.name: one for one in allowed(season(2027), Flight(dry_mass=dry_mass), found, length)}


def test_the_limits_of_a_season() -> None:
    loaded = motor().loaded_mass
    cases: list[tuple[str, float, list[str], Callable[[float], dict[str, SafetyCheck]]]] = [
        ("contest mass", 0.65, ["ok", "ok", "unsafe"], lambda one: lines_of(one - loaded, 60.0, 0.7)),
        ("contest impulse", 80.0, ["ok", "ok", "unsafe"], lambda one: lines_of(0.5, one, 0.7)),
        ("contest length", 0.65, ["unsafe", "ok", "ok"], lambda one: lines_of(0.5, 60.0, one)),
    ]
    for name, limit, verdicts, given in cases:
        assert [given(one)[name].verdict for one in around(limit)] == verdicts, name


def test_an_unknown_value_is_never_ok() -> None:
    found = rocket(mass=math.nan)
    for line in (
        rule_lines.wind_line(found, None),
        rule_lines.angle_line(found, None),
        rule_lines.field_line(found, None),
        rule_lines.distance_line(found, None),
        rule_lines.mass_line(found),
    ):
        assert line.verdict == "unknown", line.name
