"""Rule sets: the tables of the codes, chosen by motor, mass, authority and day, and the resulting lines."""

import datetime
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.planning import rule_lines
from fieldkit.planning.classification import build_of, legal_class, why_high_power
from fieldkit.planning.governed import Governed, governed
from fieldkit.planning.rules import MARKS, Rule, RuleSet, governing, read_authorities, rule_sets
from fieldkit.services.contest_day import keep_day
from fieldkit.services.sites import keep_site, site_of
from fieldkit.units import FOOT

pytestmark = pytest.mark.fast

SETS = {one.key: one for one in rule_sets()}
TODAY = datetime.date(2026, 11, 22)


def rule(key: str, check: str) -> Rule:
    return next(one for one in SETS[key].rules if one.check == check)


def under_rules(name: str, dry_mass: float = 0.3, altitude: float = 200.0, rules: str = "") -> Governed:
    build = build_of(catalogue().resolve(name).motor, dry_mass)
    return governed(build, altitude, Site(rules=rules), rule_sets(), TODAY)


def test_the_launch_sites_of_the_model_code_agree_with_its_table() -> None:
    """Source: NAR Model Rocket Safety Code, August 2012, launch site dimensions."""
    table = {1.25: 50, 2.5: 100, 5: 200, 10: 400, 20: 500, 40: 1000, 80: 1000, 160: 1000, 320: 1500}
    sites = rule("nar_model", "field size")
    for impulse, feet in table.items():
        assert (sites.least(impulse, 100.0) or 0) / FOOT == pytest.approx(feet)
    assert sites.least(321.0, 100.0) is None
    assert [row.text.mark for row in sites.rows] == ["O"] * 8 + ["T"]


def test_the_launch_distances_of_the_model_code_are_fifteen_and_thirty_feet() -> None:
    distance = rule("nar_model", "pad distance")
    assert [(distance.least(impulse, 0.0) or 0) / FOOT for impulse in (20.0, 20.01, 160.0)] == pytest.approx(
        [15, 30, 30]
    )


@pytest.mark.parametrize(
    ("impulse", "cleared", "people", "complex_rocket"),
    [
        (320, 50, 100, 200),
        (640, 50, 100, 200),
        (1280, 50, 100, 200),
        (2560, 75, 200, 300),
        (5120, 100, 300, 500),
        (10240, 125, 500, 1000),
        (20480, 125, 1000, 1500),
        (40960, 125, 1500, 2000),
    ],
)
def test_the_distances_of_high_power_agree_with_the_table(
    impulse: float, cleared: float, people: float, complex_rocket: float
) -> None:
    """Source: minimum distance table of NAR and NFPA 1127."""
    distance = rule("nar_high_power", "pad distance")
    row = distance.row(impulse, 0.0)
    assert row is not None
    assert (row.cleared or 0) / FOOT == pytest.approx(cleared)
    assert (distance.least(impulse, 0.0) or 0) / FOOT == pytest.approx(people)
    assert (distance.least(impulse, 0.0, complex_rocket=True) or 0) / FOOT == pytest.approx(complex_rocket)
    assert distance.row(impulse + 0.005, 0.0) is not row


def test_figures_agree_with_the_text_of_the_codes() -> None:
    angle = {key: np.degrees(rule(key, "launch angle").rows[0].value) for key in ("nar_model", "nar_high_power")}
    assert angle == pytest.approx({"nar_model": 30, "nar_high_power": 20})
    wind = [rule(key, "ground wind").rows[0].value for key in ("nar_model", "nar_high_power", "tripoli", "ukra")]
    assert wind == pytest.approx([8.9408] * 4)
    assert rule("nar_model", "mass").rows[0].value == 1.5
    assert rule("nar_model", "propellant").rows[0].value == 0.125
    assert rule("nar_model", "impulse").rows[0].value == 320
    assert rule("nar_high_power", "weight over thrust").rows[0].value == pytest.approx(1 / 3)
    assert rule("nar_contest", "pad to the edge of the field").rows[0].value == 10
    assert np.degrees(rule("nar_contest", "launch angle").rows[0].value) == pytest.approx(30)
    assert (rule("nar_high_power", "occupied buildings").least(0.0, 0.0) or 0) / FOOT == pytest.approx(1500)
    several = [rule("nar_model", "complex rocket").least(impulse, 0.0) or 0 for impulse in (20.0, 20.01)]
    assert np.array(several) / FOOT == pytest.approx([15, 30])
    assert rule("ukra", "odd rockets").rows[0].value == 2
    for key in ("nar_high_power", "tripoli"):
        levels = [rule(key, "certification").least(impulse, 0.0) for impulse in (640, 640.01, 5120, 5120.01, 40960)]
        assert levels == [1, 2, 2, 3, 3]
    assert rule("nar_high_power", "impulse").rows[0].value == 40960
    assert (rule("tripoli", "pad distance").least(160.0, 0.0) or 0) / FOOT == pytest.approx(50)
    research = [rule("tripoli_research", "pad distance").least(one, 0.0) or 0 for one in (1280, 2560, 40960, 50000)]
    assert np.array(research) / FOOT == pytest.approx([200, 250, 1500, 2000])
    canada = rule("car", "field size")
    assert [canada.least(100.0, feet * FOOT) for feet in (3000, 6000, 10000, 12000)] == [500, 1000, 2000, 3000]
    assert canada.least(100.0, 9999 * FOOT) == 2000
    assert canada.of_altitude == 0.5
    assert rule("nar_contest", "field size").least(50.0, 200.0) == 50.0


@pytest.mark.parametrize(
    ("key", "table"),
    [
        (
            "tripoli_research",
            {1280: (200, 250), 2560: (250, 350), 5120: (300, 500), 10240: (500, 1000), 20480: (1000, 1500)}
            | {40960: (1500, 2000), 1e6: (2000, 2500)},
        ),
        (
            "california",
            {320: (30, 150), 1280: (150, 200), 2560: (200, 300), 5120: (300, 500), 10240: (500, 1000)}
            | {20480: (1000, 1000)},
        ),
    ],
)
def test_the_distances_of_other_codes_agree_with_their_tables(
    key: str, table: dict[float, tuple[float, float]]
) -> None:
    distance = rule(key, "pad distance")
    for impulse, feet in table.items():
        found = [distance.least(impulse, 0.0, complex_rocket=several) or 0 for several in (False, True)]
        assert np.array(found) / FOOT == pytest.approx(feet)


@pytest.mark.parametrize(
    ("key", "check", "words"),
    [
        ("nar_model", "misfire", "wait 60 seconds"),
        ("nar_model", "more than ten at once", "1.5 times the maximum expected altitude"),
        ("nar_model", "sky", "into clouds, near airplanes"),
        ("nar_model", "recovery", "streamer or parachute that is undamaged, and flame-resistant wadding"),
        ("nar_high_power", "misfire", "countdown of 5 s"),
        ("nar_high_power", "misfire", "within 25 ft"),
        ("nar_high_power", "three or more at once", "2,000 ft"),
        ("nar_high_power", "sparky motors", "1.5 times as wide"),
        ("nar_high_power", "occupied buildings", "1,500 ft"),
        ("ukra", "odd rockets", "double the distance"),
    ],
)
def test_rules_that_no_figure_of_a_plan_can_check_are_quoted(key: str, check: str, words: str) -> None:
    assert words in rule(key, check).text.words
    name = ("93G80-14A" if check == "sparky motors" else "H128W") if key == "nar_high_power" else "C6"
    rules = "UKRA" if key == "ukra" else ""
    lines = {line.name: line for line in rule_lines.reminder_lines(under_rules(name, rules=rules))}
    assert words in lines[check].text
    assert lines[check].verdict == "unknown"


def test_the_law_requires_a_quarter_of_the_altitude_and_at_least_1500_feet() -> None:
    away = rule("faa", "bystanders")
    assert (away.least(0.0, 1000 * FOOT) or 0) / FOOT == pytest.approx(1500)
    assert (away.least(0.0, 8000 * FOOT) or 0) / FOOT == pytest.approx(2000)
    laws = SETS["faa"].classes
    motors = catalogue()
    names = {"F24W": 1, "H128W": 1, "J350W": 2}
    assert {name: legal_class(build_of(motors.resolve(name).motor, 0.4), laws) for name in names} == names
    assert legal_class(build_of(motors.resolve("F24W").motor, 1.6), laws) == 2


def test_there_is_no_spark_warning_for_a_motor_without_sparks() -> None:
    line_names = [line.name for line in rule_lines.reminder_lines(under_rules("H128W", 0.9))]
    assert "sparky motors" not in line_names
    assert "throws sparks" in under_rules("60F50-13A", 0.5).why


def test_a_motor_that_throws_sparks_needs_a_wider_cleared_area() -> None:
    """Source: the table's 50 ft, times 1.5."""
    sparky, plain = (
        rule_lines.distance_line(under_rules(name, 0.9), None).words("US") for name in ("93G80-14A", "H128W")
    )
    assert "75 ft across cleared around the pad, 1.5 times as wide because of sparks" in sparky
    assert "50 ft across cleared around the pad; distance" in plain


def test_the_law_of_classes_2_and_3_is_quoted() -> None:
    classes = SETS["faa"].classes
    assert [classes[name] for name in ("class1_propellant_g", "class1_mass_g", "class2_impulse_ns")] == [
        125,
        1500,
        40960,
    ]
    words = rule("faa", "sky").text.words
    for part in ("five-tenths cloud", "five miles", "sunset and sunrise", "five nautical miles", "18 years"):
        assert part in words
    assert rule("faa", "bystanders").classes == rule("faa", "sky").classes == (2, 3)


def test_the_edge_of_a_high_power_field_is_no_nearer_than_people_may_stand() -> None:
    """For an N motor people stay 1,000 ft away, so up to 2,000 ft high it needs 2,000 ft across, not the 1,500 ft for
    the altitude."""
    low, high = (under_rules("N1000W", 20.0, altitude=feet * FOOT) for feet in (2000.0, 9000.0))
    verdicts = [rule_lines.field_line(low, feet * FOOT).verdict for feet in (1500.0, 1990.0, 2000.0)]
    assert verdicts == ["unsafe", "unsafe", "ok"]
    assert "twice the distance of people" in rule_lines.field_line(low, None).text
    assert "twice" not in rule_lines.field_line(high, None).text
    assert rule_lines.field_line(high, 4490.0 * FOOT).verdict == "unsafe"
    assert rule_lines.field_line(under_rules("H128W", 0.9), 1500.0 * FOOT).verdict == "ok"


def test_the_limits_of_high_power_agree_with_the_published_figures() -> None:
    limit = SETS["nar_high_power"].definition
    names = ("impulse_of_several_ns", "impulse_of_one_ns", "average_thrust_n", "propellant_g", "mass_g")
    assert [limit[name] for name in names] == [320, 160, 80, 125, 1500]
    assert limit["kinds"] == ["hybrid"]


def test_every_figure_has_a_quotation_a_source_and_a_certainty() -> None:
    for one in SETS.values():
        for own in one.rules:
            for text in (own.text, *(row.text for row in own.rows)):
                assert text.words
                assert text.source
                assert text.mark in MARKS
                assert text.valid_from <= TODAY


@pytest.mark.parametrize(
    ("name", "mass", "high"),
    [
        ("G80T", 0.5, False),
        ("G72DM", 0.5, True),
        ("G75M-11", 0.5, True),
        ("F24W", 1.6, True),
        ("H128W", 0.9, True),
        ("HP-G75M", 0.5, True),
        ("60F50-13A", 0.5, True),
        ("G76G", 0.5, False),
    ],
)
def test_the_code_is_chosen_by_motor_and_mass(name: str, mass: float, high: bool) -> None:
    """G80T is certified at 77.99 N and no high-power motor, though its curve averages more than 80 N."""
    found = under_rules(name, mass)
    assert bool(found.why) is high
    assert found.sets[0].key == ("nar_high_power" if high else "nar_model")


def test_25_degrees_are_too_much_only_for_high_power() -> None:
    lines = {name: rule_lines.angle_line(under_rules(name, 0.9), np.radians(25)) for name in ("F24W", "H128W")}
    assert {name: line.verdict for name, line in lines.items()} == {"F24W": "ok", "H128W": "unsafe"}


def test_a_line_without_a_figure_also_quotes_the_rule() -> None:
    line = rule_lines.angle_line(under_rules("C6"), None)
    assert line.verdict == "unknown"
    assert "The rule: “pointed to within 30 degrees of the vertical”" in line.words()


def test_a_300_foot_field_is_too_small_for_an_f() -> None:
    line = rule_lines.field_line(under_rules("F24W"), 300 * FOOT)
    assert line.verdict == "unsafe"
    assert "requires 305 m across" in line.text
    assert "requires 1000 ft across" in line.words("US")
    assert "(1,000 ft, up to 80 N s)" in line.rule  # as the table has it, whatever units are shown
    assert rule_lines.field_line(under_rules("F24W"), 1000 * FOOT).verdict == "ok"
    assert rule_lines.field_line(under_rules("F24W", rules="NAR contest"), 300 * FOOT).verdict == "ok"  # when it is one


def test_high_power_requires_1500_feet_or_half_the_altitude() -> None:
    tall = under_rules("J350W", 3.0, altitude=4000 * FOOT)
    assert "requires 2000 ft across" in rule_lines.field_line(tall, 1900 * FOOT).words("US")
    assert rule_lines.field_line(tall, 1900 * FOOT).verdict == "unsafe"
    assert rule_lines.field_line(under_rules("J350W", 3.0), 1500 * FOOT).verdict == "ok"


def test_a_small_high_power_field_is_unverified_and_no_better_than_caution() -> None:
    line = rule_lines.field_line(under_rules("G72DM", 0.5), 1000 * FOOT)
    assert line.verdict == "caution"
    assert "(unverified)" in line.words()
    assert rule_lines.field_line(under_rules("J350W", 3.0), 1000 * FOOT).verdict == "unsafe"


def test_the_distance_of_people_follows_the_table_and_is_larger_for_a_cluster() -> None:
    one = under_rules("H128W", 0.9)
    assert rule_lines.distance_line(one, 100 * FOOT).verdict == "ok"
    assert rule_lines.distance_line(one, 99 * FOOT).verdict == "unsafe"
    assert rule_lines.distance_line(one, None).verdict == "unknown"
    many = replace(one, build=replace(one.build, complex=True))
    assert rule_lines.distance_line(many, 100 * FOOT).verdict == "unsafe"
    assert "50 ft across cleared" in rule_lines.distance_line(one, None).words("US")
    assert rule_lines.distance_line(under_rules("C6-5"), 15 * FOOT).verdict == "ok"
    assert rule_lines.distance_line(under_rules("C6-5", rules="Tripoli"), 15 * FOOT).verdict == "unsafe"


def test_bystanders_have_a_distance_by_law_from_class_2_on() -> None:
    assert rule_lines.bystander_line(under_rules("F24W"), None).verdict == "ok"
    assert rule_lines.bystander_line(under_rules("J350W", 3.0), 400.0).verdict == "unsafe"
    assert rule_lines.bystander_line(under_rules("J350W", 3.0), 460.0).verdict == "ok"


def test_certification_depends_on_the_installed_impulse() -> None:
    texts = {name: rule_lines.certification_line(under_rules(name, 2.0)).text for name in ("H128W", "J350W", "M1297W")}
    assert [text.partition(";")[0][-1] for text in texts.values()] == ["1", "2", "3"]
    assert rule_lines.certification_line(under_rules("F24W")).verdict == "ok"


def test_high_power_weighs_at_most_a_third_of_its_thrust() -> None:
    heavy, light = rule_lines.weight_line(under_rules("H128W", 5.0)), rule_lines.weight_line(under_rules("H128W", 1.0))
    assert heavy is not None
    assert light is not None
    assert (heavy.verdict, light.verdict) == ("unsafe", "ok")
    assert rule_lines.weight_line(under_rules("F24W")) is None


def test_a_country_is_added_by_a_file(tmp_path: Path) -> None:
    (tmp_path / "moon.toml").write_text(
        'title = "Moon code"\nauthority = "MOON"\nfor = "any"\nvalid_from = 2026-01-01\nmark = "O"\n'
        'source = "a stone"\n'
        '[[rule]]\ncheck = "launch angle"\nat_most = 5\nunit = "deg"\nquote = "straight up"\n'
        '[[rule]]\ncheck = "dust"\nquote = "mind the dust"\n'
    )
    found = governed(build_of(catalogue().resolve("C6").motor, 0.1), 90.0, Site(rules="moon"), rule_sets(tmp_path))
    line = rule_lines.angle_line(found, np.radians(6))
    assert line.verdict == "unsafe"
    assert "“straight up”" in line.words()
    assert "Moon code; a stone; official text" in line.words()
    assert [one.name for one in rule_lines.reminder_lines(found)] == ["dust"]
    assert rule_lines.wind_line(found, 3.0).verdict == "unknown"
    with pytest.raises(BadValue, match=r"MARS.*MOON"):
        governing(rule_sets(tmp_path), ["MARS"], False, TODAY)


OWN = 'title = "Moon"\nauthority = "moon"\nfor = "any"\nvalid_from = 2026-01-01\nmark = "O"\nsource = "a stone"\n'


def test_a_rule_without_a_figure_is_a_reminder_on_any_subject(tmp_path: Path) -> None:
    (tmp_path / "moon.toml").write_text(OWN + '[[rule]]\ncheck = "ground wind"\nsays = "only in calm air"\n')
    found = governed(build_of(catalogue().resolve("C6").motor, 0.1), 90.0, Site(rules="moon"), rule_sets(tmp_path))
    assert rule_lines.wind_line(found, 3.0).verdict == "unknown"
    assert [one.finding for one in rule_lines.reminder_lines(found)] == ["check it yourself: only in calm air"]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ('[[rule]]\ncheck = "ground wind"\nat_most = nan\nunit = "mph"\n', "ground wind, at_most = nan"),
        ("[definition]\nmass_g = 1500\n", "impulse_of_several_ns"),
        ("[classes]\nclass1_mass_g = 1500\n", "class1_propellant_g"),
    ],
)
def test_an_incomplete_file_of_rules_is_refused_by_name(tmp_path: Path, text: str, named: str) -> None:
    (tmp_path / "moon.toml").write_text(OWN + text)
    with pytest.raises(BadValue, match=rf"moon\.toml.*{named}"):
        rule_sets(tmp_path)


@pytest.mark.parametrize(
    ("text", "named"), [("title = 1", "found"), ('mark = "X"', "found"), ("[[", "TOML"), ("rule = 3", "found")]
)
def test_a_damaged_file_of_rules_is_named(tmp_path: Path, text: str, named: str) -> None:
    (tmp_path / "odd.toml").write_text(text)
    with pytest.raises(BadValue, match=rf"odd\.toml: {named}|odd\.toml.*{named}"):
        rule_sets(tmp_path)


def test_the_version_of_a_code_valid_on_the_day_is_used() -> None:
    old = SETS["nar_model"]
    new = replace(old, valid_from=datetime.date(2027, 1, 1))

    def on(day: datetime.date) -> RuleSet:
        return governing([old, new], ["NAR"], False, day)[0]

    assert on(datetime.date(2026, 6, 1)) is old
    assert on(datetime.date(2027, 6, 1)) is new
    assert on(datetime.date(2000, 1, 1)) is old


def test_the_limits_of_high_power_are_in_the_file() -> None:
    build = build_of(catalogue().resolve("F24W").motor, 0.3)
    assert not why_high_power(build, [SETS["nar_high_power"]])
    five = replace(build, motors=build.motors * 8)
    assert "in all its motors" in why_high_power(five, [SETS["nar_high_power"]])
    assert read_authorities("") == ("NAR", "FAA")


def test_the_distances_and_the_authority_of_a_site_are_saved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(tmp_path / "ledger.db")
    assert (
        main(["--ledger", file, "sites", "Moor", "--people", "100ft", "--rules", "UKRA", "--field-size", "500m"]) == 0
    )
    assert main(["--ledger", file, "sites", "Moor", "--rules", "XYZ"]) == 1
    assert "expected one of" in capsys.readouterr().err
    with Ledger.open(file) as ledger:
        site = site_of(ledger, "Moor")
        assert (site.people, site.size, site.rules) == (pytest.approx(30.48), pytest.approx(500.0), "UKRA")
        keep_site(ledger, "Moor", size=400.0)
        keep_day(ledger, 2027, site=site_of(ledger, "Moor"))
        assert site_of(ledger, "Moor").rules == "UKRA"
