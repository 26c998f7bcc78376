"""The figures of the program compared with the tables of collected facts, `../shared/rules.md`, if that file exists."""

import datetime
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.motors import catalogue
from fieldkit.motors.delay_tolerance import delay_tolerance
from fieldkit.motors.search import LETTER_DELAYS
from fieldkit.physics.atmosphere import altimeter_gain
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.planning.classification import build_of, why_high_power
from fieldkit.planning.contest import season, seasons
from fieldkit.planning.contest_flight import judged_duration
from fieldkit.planning.delay import drill_of, offered
from fieldkit.planning.finals import finals_targets
from fieldkit.planning.limits import limits
from fieldkit.planning.rules import Rule, rule_sets
from fieldkit.units import FOOT, MILE

FACTS = Path(__file__).parents[3] / "shared" / "rules.md"
pytestmark = [pytest.mark.fast, pytest.mark.skipif(not FACTS.exists(), reason="the collected facts are not here")]
SETS = {one.key: one for one in rule_sets()}


def table(*first: str) -> Iterator[list[str]]:
    """The rows of the table whose heading starts with some cells, without emphasis."""
    lines = FACTS.read_text(encoding="utf-8").splitlines()
    heads = [row for row, line in enumerate(lines) if cells(line)[: len(first)] == list(first)]
    assert len(heads) == 1, first
    for line in lines[heads[0] + 2 :]:
        if not line.startswith("|"):
            return
        yield cells(line)


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.replace("**", "").strip().strip("|").split("|")]


def number(text: str) -> float:
    """The first number in a text."""
    found = re.search(r"\d[\d,]*(?:\.\d+)?", text)
    assert found, text
    return float(found[0].replace(",", ""))


def upper(span: str) -> float:
    """The upper end of a range such as `1,280.01-2,560`."""
    return number(span.split("-")[1])


def rule(key: str, check: str) -> Rule:
    return next(one for one in SETS[key].rules if one.check == check)


def test_the_fields_of_the_model_code() -> None:
    sites, rows = (
        rule("nar_model", "field size"),
        list(table("Installed impulse, N s", "Motor", "Minimum dimension, ft")),
    )
    assert len(sites.rows) == len(rows) == 9
    for row, (span, motor, feet, metres) in zip(sites.rows, rows, strict=True):
        assert (sites.least(upper(span), 0.0) or 0) / FOOT == pytest.approx(number(feet))
        assert row.up_to == upper(span)
        assert row.text.mark == ("T" if "T" in metres else "O"), motor


def test_the_distances_of_high_power() -> None:
    distance, rows = (
        rule("nar_high_power", "pad distance"),
        list(table("Installed impulse, N s", "Motor", "Cleared diameter")),
    )
    assert len(distance.rows) == len(rows) == 8
    for span, _, cleared, people, several in rows:
        row = distance.row(upper(span), 0.0)
        assert row is not None
        assert row.up_to == upper(span)
        found = (row.cleared, distance.least(upper(span), 0.0), distance.least(upper(span), 0.0, complex_rocket=True))
        assert [(one or 0.0) / FOOT for one in found] == pytest.approx(
            [number(cleared), number(people), number(several)]
        )


def test_the_words_of_the_model_code() -> None:
    words = " ".join(one.text.words for one in SETS["nar_model"].rules)
    quoted = [quote for _, _, quote in table("Rule", "Figure", "Quote") if quote]
    assert len(quoted) == 12
    for quote in quoted:
        assert quote.strip('"') in words


def test_the_levels_of_certification() -> None:
    rows = [row for row in table("Level", "Classes") if row[0] != "none"]
    assert [row[0] for row in rows] == ["1", "2", "3"]
    for level, _, span, mark in rows:
        needed = rule("nar_high_power", "certification")
        assert needed.least(upper(span), 0.0) == float(level)
        assert needed.least(number(span), 0.0) == float(level)
        assert needed.text.mark == mark
    assert [row.up_to for row in needed.rows] == [upper(span) for _, _, span, _ in rows]


@pytest.mark.parametrize(
    ("topic", "check", "unit"),
    [
        ("Rail angle", "launch angle", math.pi / 180),
        ("Wind", "ground wind", 0.44704),
        ("Impulse", "impulse", 1.0),
        ("Site", "field size", FOOT),
        ("Site, small high power", "small high power field", FOOT),
        ("Occupied buildings", "occupied buildings", FOOT),
    ],
)
def test_the_figures_of_the_high_power_code(topic: str, check: str, unit: float) -> None:
    (row,) = [row for row in table("Rule", "Figure", "Mark") if row[0] == topic]
    one = rule("nar_high_power", check)
    figure = number(row[1].split(" or ")[-1])
    assert one.rows[0].value / unit == pytest.approx(figure)
    assert one.text.mark == row[2][0]


def test_every_season() -> None:
    rows = list(table("Season", "Target, ft"))
    assert [int(row[0]) for row in rows] == list(seasons())
    for year, target, window, eggs, _, mass, _, mark in rows:
        rule = season(int(year))
        assert rule.target / FOOT == pytest.approx(number(target))
        assert rule.window == tuple(map(float, window.split("-")))
        assert rule.eggs.startswith(f"{number(eggs):g} egg")
        assert (rule.mass or 0) * 1e3 == pytest.approx(number(mass))
        assert (rule.length or 0) * 1e3 == pytest.approx(650.0)
        assert rule.mark == mark[0]
        assert rule.impulse == 80.0


def test_the_drills_of_the_manufacturers() -> None:
    text = FACTS.read_text(encoding="utf-8")
    for motor, made in (("H128W", "removes **2, 4, 6 or 8 s**"), ("Cesaroni 232H123-14A", "removes **3, 5, 7, 9 s**")):
        assert made in text
        tool = drill_of(catalogue().resolve(motor).motor)
        assert tool is not None
        assert list(tool.takes_off) == [float(one) for one in re.findall(r"\d", made)]


LIMITS = [
    ("Speed off the rod or rail", "rail_speed", r"RockSim default (\d+) ft/s", FOOT),
    ("Rail speed and wind", "rail_speed_per_wind", r"at least (\d) x the wind", 1.0),
    ("Thrust to weight", "thrust_to_weight", r"^(\d):1 at lift-off", 1.0),
    ("Thrust to weight", "thrust_to_weight_unsafe", r"under (\d):1 unsafe", 1.0),
    ("Stability", "stability", r"at least (\d) calibre", 1.0),
    ("Stability", "stability_most", r"above about 2.5-(\d) weathercocks", 1.0),
    ("Descent, model", "landing_speed_slow", r"about (\d)-6 m/s", 1.0),
    ("Descent, large", "landing_speed", r"landing under (\d+) ft/s", FOOT),
    ("Descent, student launch", "drogue_speed_slow", r"drogue about (\d+)-55 ft/s", FOOT),
    ("Descent, large", "drogue_speed", r"drogue 75-(\d+) ft/s", FOOT),
    ("Descent, large", "main_altitude", r"main by ([\d,]+) ft", FOOT),
    ("Minimum altitude for Eggtimer deployment", "main_altitude_low", r"^(\d+) ft", FOOT),
    ("Descent, student launch", "landing_energy", r"at most 75 ft lbf \((\d+) J\)", 1.0),
]
"""Rows of the table of guidance, the threshold they are the source of, the figure, and its unit in SI."""


@pytest.mark.parametrize(("topic", "name", "figure", "unit"), LIMITS, ids=[one[1] for one in LIMITS])
def test_guidance_that_is_not_law(topic: str, name: str, figure: str, unit: float) -> None:
    (row,) = [row for row in table("Topic", "Value") if row[0] == topic]
    found = re.search(figure, row[1])
    assert found, row[1]
    assert limits()[name].value == pytest.approx(number(found[1]) * unit)


def test_the_program_warns_of_an_opening_speed_sooner_than_the_guidance() -> None:
    (row,) = [row for row in table("Topic", "Value") if row[0] == "Deployment speed"]
    assert limits()["eject_speed"].value < number(row[1].split("above")[1])


def section(start: str, end: str) -> str:
    """The text of the facts between two phrases, without emphasis and line breaks."""
    text = " ".join(FACTS.read_text(encoding="utf-8").replace("**", "").split())
    return text[text.index(start) : text.index(end, text.index(start))]


CLASS_ENDS = {letter: 1.25 * 2**place for place, letter in enumerate("ABCDEFGHIJKLMNO", start=1)}
"""Upper limit of the total impulse of each class of motors. [N s]"""
MODEL = {
    "Launch distance, D or smaller": ("pad distance", 0, FOOT),
    "Launch distance, larger": ("pad distance", 1, FOOT),
    "Rod angle": ("launch angle", 0, math.pi / 180),
    "Mass": ("mass", 0, 1e-3),
    "Wind": ("ground wind", 0, MILE / 3600),
    "Propellant, impulse": ("propellant", 0, 1e-3),
}
"""Rows of the model rocket code with a figure: the check, its row, and the unit in SI."""


def test_the_figures_of_the_model_code() -> None:
    rows = {row[0]: row[1] for row in table("Rule", "Figure", "Quote")}
    assert set(MODEL) <= set(rows)
    for topic, (check, row, unit) in MODEL.items():
        assert rule("nar_model", check).rows[row].value / unit == pytest.approx(number(rows[topic])), topic
    assert rule("nar_model", "impulse").rows[0].value == number(rows["Propellant, impulse"].split("g,")[1])
    largest = CLASS_ENDS["D"], rule("nar_model", "impulse").rows[0].value
    assert tuple(row.up_to for row in rule("nar_model", "pad distance").rows) == largest
    assert "1.5 times" in rule("nar_model", "more than ten at once").text.words
    assert number(rows["More than ten at once"]) == 1.5
    assert f"{number(rows['Misfire']):g} seconds" in rule("nar_model", "misfire").text.words


DATED = [
    ("nar_model", "text of August 2012", datetime.date(2012, 8, 1), "O"),
    ("nar_high_power", "effective August 2012", datetime.date(2012, 8, 1), "T"),
    ("tripoli", "rocketryforum.com/threads/181815, 2022", datetime.date(2022, 1, 1), "T"),
    ("tripoli_research", "code of May 2016", datetime.date(2016, 5, 1), "T"),
    ("california", "govt.westlaw.com, O", datetime.date(2026, 1, 1), "O"),
    ("car", "legacy.canadianrocketry.org, T", datetime.date(2026, 1, 1), "T"),
    ("ukra", "openrocket#2772, T", datetime.date(2026, 1, 1), "T"),
    ("faa", "text as of 2026", datetime.date(2026, 1, 1), "O"),
    ("nar_contest", "nar.org .../launching-requirements, O", datetime.date(2026, 1, 1), "O"),
]


@pytest.mark.parametrize(("key", "fact", "day", "mark"), DATED, ids=[one[0] for one in DATED])
def test_every_code_has_the_date_and_the_mark_of_its_source(key: str, fact: str, day: datetime.date, mark: str) -> None:
    assert fact in section("# Rules", "## 4.")
    assert (SETS[key].valid_from, SETS[key].text.mark) == (day, mark)


def test_every_shipped_code_is_compared_with_its_source() -> None:
    as_others_have_it = {"tripoli_model", "tripoli_high_power"}
    assert {one[0] for one in DATED} == set(SETS) - as_others_have_it
    for key, of in (("tripoli_model", "nar_model"), ("tripoli_high_power", "nar_high_power")):
        own, other = rule(key, "field size"), rule(of, "field size")
        assert SETS[key].text.unverified
        for impulse in (1.0, 2.0, 4.0, 9.0, 15.0, 30.0, 150.0, 300.0, 700.0):
            assert own.least(impulse, 900.0) == other.least(impulse, 900.0)


def test_clusters_and_stages_of_model_rockets() -> None:
    fact = section("Clusters and stages (NAR", "Tripoli:")
    assert "15 ft up to 20 N s total, 30 ft above" in fact
    rows, text = rule("nar_model", "complex rocket").rows, rule("nar_model", "complex rocket").text
    assert [(row.up_to, row.value / FOOT) for row in rows] == [(20.0, pytest.approx(15)), (320.0, pytest.approx(30))]
    assert text.words.strip("“”") in fact
    assert (text.mark, text.valid_from) == ("O", datetime.date(2024, 9, 1))
    assert "September 2024, nar.org/safety, O" in fact


def test_the_distances_of_tripoli() -> None:
    assert "starts at 50 ft for A-G, up to 160 N s" in section("Tripoli: its safe", "Not a safety")
    first, *above = rule("tripoli", "pad distance").rows
    assert (first.up_to, first.value / FOOT) == (160.0, pytest.approx(50))
    nar = rule("nar_high_power", "pad distance")
    for row in above:  # as the table of NFPA 1127, which both follow
        same = nar.row(row.up_to, 0.0)
        assert same is not None
        assert (row.value, row.complex, row.cleared) == (same.value, same.complex, same.cleared)
    assert [row.up_to for row in above] == [row.up_to for row in nar.rows[2:]]


def test_the_distances_of_tripoli_research() -> None:
    fact = section("Tripoli research launches", "California Title 19 section 1036 (govt")
    found = re.findall(r"(?:\w-)?([A-Z]) ([\d,]+)/([\d,]+)", fact)
    assert [one[0] for one in found] == list("JKLMNOT")
    distance = rule("tripoli_research", "pad distance")
    assert len(distance.rows) == len(found)
    for letter, simple, complicated in found:
        impulse = CLASS_ENDS.get(letter, 1.25 * 2**20)
        assert impulse in {row.up_to for row in distance.rows}
        for text, several in ((simple, False), (complicated, True)):
            assert (distance.least(impulse, 0.0, complex_rocket=several) or 0) / FOOT == pytest.approx(number(text))


def test_the_distances_of_california() -> None:
    fact = section("California Title 19 section 1036 (govt", "Canada, CAR")
    found = [(number(to), number(feet)) for to, feet in re.findall(r"to ([\d,]+)(?: N s)? ([\d,]+) ft", fact)]
    assert len(found) == 6
    assert "clusters one class higher" in fact
    distance = rule("california", "pad distance")
    for row in distance.rows:
        feet = next(feet for impulse, feet in found if row.up_to <= impulse)
        assert (distance.least(row.up_to, 0.0) or 0) / FOOT == pytest.approx(feet)
    assert {impulse for impulse, _ in found} <= {row.up_to for row in distance.rows}
    simple = {row.up_to: row.value for row in distance.rows}
    for row in distance.rows[:-1]:
        assert row.complex == pytest.approx(simple.get(2 * row.up_to))  # the table ends at N
    assert distance.rows[-1].complex == distance.rows[-1].value


def test_the_angle_and_the_wind_of_california_are_those_of_high_power() -> None:
    rows = {row[0]: row for row in table("Rule", "Figure", "Mark")}
    assert "California Title 19 section 1036 says the same for high power (O)" in rows["Rail angle"][2]
    assert "Title 19 section 1036: 20 mph (O)" in rows["Wind"][2]
    for topic, check, unit in (("Rail angle", "launch angle", math.pi / 180), ("Wind", "ground wind", MILE / 3600)):
        found = rule("california", check)
        assert found.rows[0].value / unit == pytest.approx(number(rows[topic][1]))
        assert found.text.mark == "O"


def test_the_angle_wind_and_levels_of_tripoli_are_marked_by_their_source() -> None:
    wind, angle, levels = (rule("tripoli", one) for one in ("ground wind", "launch angle", "certification"))
    assert "20 mph (openrocket#2772, T)" in section("UK, UKRA", "## 3.")
    assert (wind.rows[0].value / (MILE / 3600), wind.text.mark) == (pytest.approx(20), "T")
    nar = rule("nar_high_power", "launch angle")
    assert (angle.rows[0].value, angle.text.mark) == (nar.rows[0].value, "U")
    ends = [(row.up_to, row.value) for row in rule("nar_high_power", "certification").rows]
    assert [(row.up_to, row.value) for row in levels.rows[:2]] == ends[:2]
    assert levels.rows[2].value == ends[2][1]


def test_the_fields_of_canada() -> None:
    fact = section("Canada, CAR", "UK, UKRA")
    found = re.findall(r"([\d,]+) (k?m) to ([\d,]+)", fact)
    assert len(found) == 4
    fields = rule("car", "field size")
    for size, unit, feet in found:
        metres = number(size) * (1000 if unit == "km" else 1)
        row = fields.row(50.0, number(feet) * FOOT)
        assert row is not None
        assert (row.value, row.up_to) == pytest.approx((metres, number(feet) * FOOT))
    assert "never under half the altitude" in fact
    assert fields.of_altitude == 0.5


def test_the_rules_of_the_uk() -> None:
    fact = section("UK, UKRA", "## 3.")
    assert rule("ukra", "ground wind").rows[0].value / (MILE / 3600) == pytest.approx(number(fact.split("UKRA:")[1]))
    assert "double the distance (ukra.org.uk/sb1, O)" in fact
    assert (rule("ukra", "odd rockets").rows[0].value, rule("ukra", "odd rockets").text.mark) == (2.0, "O")


def test_what_makes_a_rocket_high_power() -> None:
    fact = section("What makes a flight high power", "* The certified")
    limit = SETS["nar_high_power"].definition
    words = {
        "impulse_of_several_ns": "several motors above {:g} N s",
        "impulse_of_one_ns": "one motor above {:g} N s",
        "average_thrust_n": "average thrust above {:.1f} N",
        "propellant_g": "more than {:g} g propellant",
        "mass_g": "lift-off mass above {:,g} g",
    }
    for name, text in words.items():
        assert text.format(limit[name]) in fact
    assert "hybrid" in fact
    assert limit["kinds"] == ["hybrid"]
    assert 'carry "HP" in the designation' in fact
    assert limit["mark"] == "O"


def test_the_cases_at_the_limit_of_average_thrust() -> None:
    cases = section("* Cases: G80T", "* For certification")
    sets = rule_sets()
    for name, certified in (("G80T", "77.99"), ("G72DM", "80.78"), ("G75M", "87.54")):
        motor = catalogue().resolve(name).motor
        assert certified in cases
        assert motor.rated_thrust == float(certified)
        why = why_high_power(build_of(motor, 0.3), sets)
        assert bool(why) == (float(certified) > 80.0)


def test_the_words_of_the_high_power_code() -> None:
    rows = {row[0]: row for row in table("Rule", "Figure", "Mark")}
    misfire = rule("nar_high_power", "misfire").text
    countdown, wait = re.findall(r"(\d+) s", rows["Countdown, misfire"][1])
    for figure in (
        f"countdown of {countdown} s",
        f"wait {wait} s",
        f"within {number(rows['Smoking, flames'][1]):g} ft",
    ):
        assert figure in misfire.words
    assert misfire.mark == rows["Countdown, misfire"][2][0] == rows["Smoking, flames"][2][0]
    assert "1/3 of the certified average thrust" in rows["Thrust"][1]
    weight = rule("nar_high_power", "weight over thrust")
    assert weight.rows[0].value == pytest.approx(1 / 3)
    assert weight.text.mark == rows["Thrust"][2][0]
    assert rule("nar_high_power", "field size").of_altitude == 0.5
    assert "half the maximum altitude expected or 1,500 ft, whichever is greater" in rows["Site"][1]
    assert "pad not nearer to the edge than the personnel distance" in rows["Site"][1]
    assert rule("nar_high_power", "field size").pad_inside
    small = rule("nar_high_power", "small high power field")
    bounds = [
        number(one)
        for one in re.findall(r"under ([\d,]+)|below ([\d,]+)", rows["Site, small high power"][1])
        for one in one
        if one
    ]
    assert bounds == [small.only["impulse"], small.only["mass"] * 1e3, pytest.approx(small.only["altitude"] / FOOT)]
    several = section("Three or more at once", "Sparky:")
    assert "twice the complex distance, not more than 2,000 ft" in several
    words = rule("nar_high_power", "three or more at once").text
    assert ("twice the distance of complex rockets" in words.words, words.mark) == (True, "O")
    assert "or 1.5 x the highest altitude, whichever is less" in several
    assert "1.5 times the highest expected altitude, whichever is less" in words.words
    assert "cleared diameter x 1.5 (T)" in section("Sparky: cleared", "Tripoli research")
    assert rule("nar_high_power", "sparky motors").text.mark == "T"


def test_what_else_the_safety_codes_say() -> None:
    rows = {row[0]: row for row in table("Rule", "Figure", "Quote")}
    assert "no targets" in rows["Sky"][1]
    assert "no targets" in rule("nar_model", "sky").text.words
    assert "safety key out" in rows["Misfire"][1]
    assert "safety key out" in rule("nar_model", "misfire").text.words
    assert rows["Recovery"][1] == "streamer or parachute, undamaged, flame-resistant wadding"
    for word in ("streamer", "parachute", "undamaged", "flame-resistant wadding"):
        assert word in rule("nar_model", "recovery").text.words
    letter = section("* For certification flights", "* The older limit")
    quote = re.search(r'"([^"]+)"', letter)
    assert quote
    assert quote[1] in rule("nar_high_power", "certification").text.words
    (level,) = [row for row in table("Level", "Classes") if row[0] == "1"]
    assert "high-power F, G" in level[1]
    assert "F and G of high power" in rule("nar_high_power", "certification").text.words


def test_the_altimeters_of_a_contest_of_the_nar() -> None:
    fact, words = section("NAR Sporting Code 20.2", "So every NAR"), rule("nar_contest", "altimeter").text.words
    assert '"accuracy of 1 percent of recorded altitude or 2 meters, whichever is greater"' in fact
    assert "accuracy of 1 percent of recorded altitude or 2 meters, whichever is greater" in words
    for there, here in (
        ("at least 16 bit", "at least 16 bits"),
        ("at least once a minute before launch", "at least once a minute"),
        ("resolution 1 m or better", "1 m"),
        ("at least 10 samples/s", "10 samples a second"),
        ("rejects ejection spikes", "ignores the ejection"),
    ):
        assert there in fact
        assert here in words


def test_the_law_of_the_united_states() -> None:
    fact, law = section("## 3. US air law", "## 4."), SETS["faa"].classes
    assert f"at most {law['class1_propellant_g']:g} g (4.4 oz)" in fact
    assert f"at most {law['class1_mass_g']:,g} g (53 oz)" in fact
    assert f"total impulse at most {law['class2_impulse_ns']:,g} N s (9,208 lb s)" in fact
    away = rule("faa", "bystanders")
    assert "greater of 1/4 of the maximum expected altitude or 457 m (1,500 ft)" in fact
    assert (away.of_altitude, away.rows[0].value / FOOT) == (0.25, pytest.approx(1500))
    assert away.rows[0].value == pytest.approx(457, abs=0.5)
    assert "slow-burning propellant; paper, wood, breakable plastic; no substantial metal" in fact
    words = rule("faa", "materials").text.words
    assert "slow-burning propellant, made of paper, wood or breakable plastic, without substantial metal" in words
    assert rule("faa", "materials").classes == (1,)
    assert "(101.23): suborbital, not into foreign airspace, unmanned, no hazard to people, property, aircraft" in fact
    words = rule("faa", "general air law").text.words
    assert words == "suborbital, not into foreign airspace, unmanned, no hazard to people, property or aircraft"
    assert rule("faa", "general air law").classes == ()  # all of them
    assert all(one.text.mark == "O" for one in SETS["faa"].rules)
    words = rule("faa", "sky").text.words
    for there, here in (
        ("five-tenths cloud", "five-tenths cloud"),
        ("visibility under 5 miles", "visibility under five miles"),
        ("between sunset and sunrise", "between sunset and sunrise"),
        ("within 5 nautical miles (9.26 km)", "within five nautical miles (9.26 km)"),
        ("a person of 18 or more in charge", "a person of 18 years or more in charge"),
    ):
        assert there in fact
        assert here in words
    assert "Classes 2 and 3 (101.25)" in fact
    assert away.classes == rule("faa", "sky").classes == (2, 3)


def test_the_rules_of_a_contest_of_the_nar() -> None:
    fact = section("Not a safety rule:", "## 2.")
    field, edge = rule("nar_contest", "field size"), rule("nar_contest", "pad to the edge of the field")
    assert field.text.words.strip("“”") in fact
    assert field.of_altitude == 0.25
    assert edge.rows[0].value == number(fact.split("launcher at least")[1])
    assert math.degrees(rule("nar_contest", "launch angle").rows[0].value) == pytest.approx(
        number(fact.split("5.4 (older edition)")[1])
    )
    assert all(one.text.mark == "O" for one in SETS["nar_contest"].rules)


@pytest.mark.parametrize("year", seasons())
def test_the_words_of_every_season(year: int) -> None:
    """Every figure about eggs, body and finals in the table of seasons is in the words of the program's season."""
    (row,) = [row for row in table("Season", "Target, ft") if row[0] == str(year)]
    found, own = season(year), re.compile(r"\d+(?:\.\d+)?")
    texts = {3: found.eggs, 4: found.body, 6: found.finals}
    for place, text in texts.items():
        cell = re.sub(
            r"\(sheet: [^)]*\)|coin flip|16 May 2026|in round 2|42 teams|winner 7.7, second 8", "", row[place]
        )
        assert not set(own.findall(cell)) - set(own.findall(text)), (year, place)
    unsure = re.findall(r"\((?:(\w+) )?U\)", row[5])
    marked = {name for name, mark in found.marks.items() if mark == "U"}
    assert marked == ({"length"} if unsure == ["length"] else {"mass", "length"} if unsure else set())
    assert (found.best, found.declared) == (2, 3)
    assert found.per_metre * FOOT == pytest.approx(1.0)
    assert found.per_second == 4.0


def test_the_score_of_a_flight() -> None:
    fact = section("Score of a flight:", "No score at all")
    for text in ("1 point per foot", "4 points per second outside the window (to 0.01 s)", "in whole feet"):
        assert text in fact
    assert "up to three declared flights" in fact
    assert "the best two are summed" in fact
    time = section("Time: two timers", "Altitude: the reading")
    assert "mean to 0.01 s, .005 rounds up; if one watch failed, the other alone" in time
    timed = Flight(apogee=243.84, extra={"timer_1_s": "38.00", "timer_2_s": "38.01"})
    assert judged_duration(timed) == 38.01
    assert judged_duration(timed.with_changes(extra={"timer_1_s": "", "timer_2_s": "38.01"})) == 38.01


def test_the_finals_of_2027() -> None:
    (row,) = [row for row in table("Season", "Target, ft") if row[0] == "2027"]
    low, high = map(float, re.findall(r"(\d{3})-(\d{3})", row[6])[0])
    rules = season(2027)
    assert rules.finals_range == pytest.approx((low * FOOT, high * FOOT))
    assert "never 800" in row[6]
    assert rules.finals_never == pytest.approx(800 * FOOT)
    assert [one for one in finals_targets(rules) if abs(one / FOOT - 800) < 1] == []


def test_the_motors_altimeters_and_dates_of_a_season() -> None:
    motors, dates = section("Motors: total impulse", "2027 launch:"), section("2027 launch:", "Approved altimeters")
    assert "F or smaller, on the season's approved list, single use or reload, unaltered apart from" in motors
    assert "2026: 4 June 2025; 2027: some 24/40 reloads were taken off" in motors
    for year, words in ((2026, "list of 4 June 2025"), (2027, "some 24/40 reloads were taken")):
        assert season(year).motors.startswith("F or smaller on the season's list")
        assert words in season(year).motors
    assert "Deadlines 6 Dec 2026 and 4 Apr 2027, finals 15 May 2027" in dates
    for day in ("6 December 2026", "4 April 2027", "15 May 2027"):
        assert day in season(2027).finals
    assert "no temperature correction is provided for" in section("Altitude: the reading", "| Season")
    assert "without a correction for temperature" in season(2027).altimeter


def test_an_altimeter_assumes_the_standard_atmosphere() -> None:
    """Real height is the reading times pad temperature over standard temperature; its two examples."""
    fact = section("Real height above the pad", "| Device")
    assert "reading x T_pad / T_std(pad elevation)" in fact
    examples = re.findall(r"([+-]?\d+) C(?: at sea level)?: x (\d\.\d+)", fact)
    assert len(examples) == 2
    for celsius, factor in examples:
        gain = altimeter_gain(np.zeros(1), np.array([float(celsius) + 273.15]), np.full(1, np.nan))
        assert 1 / gain[0] == pytest.approx(float(factor), abs=5e-4)
    formula = section("Formula: z(P)", "Real height")
    for constant in ("288.15 K", "0.0065 K/m", "287.05", "9.80665", "101,325 Pa"):
        assert constant in formula
    pressure = 101_325 * (1 - 0.0065 * 1000 / 288.15) ** (9.80665 / (0.0065 * 287.05))
    assert pressure_height(np.array([pressure]))[0] == pytest.approx(1000.0, abs=0.2)


def test_the_tolerance_of_a_delay() -> None:
    fact = section("* Delay tolerance:", "* AeroTech delay")
    assert "up to 20% or 1.5 second, whichever is greater, up to a max of 3 seconds" in fact
    assert "+-1.5 s up to 7.5 s nominal, 20 % to 15 s, never more than 3 s" in fact
    nominal = np.array([3.0, 7.5, 10.0, 15.0, 20.0])
    assert delay_tolerance(nominal) == pytest.approx([1.5, 1.5, 2.0, 3.0, 3.0])


def test_what_the_letters_of_a_delay_stand_for() -> None:
    assert "Letter codes S 4, 6; M 4-10; L 6-14; X 10-18 (T)" in section("* AeroTech delay drilling", "* Cesaroni")
    assert LETTER_DELAYS == {"S": "4 or 6", "M": "4 to 10", "L": "6 to 14", "X": "10 to 18"}


def test_what_may_be_drilled() -> None:
    text = section("* AeroTech delay drilling", "## 7.")
    assert "Not below about 4 s left on RMS, 6 s on DMS" in text
    assert "-14A gives 14, 12, 10, 8, 6" in text
    reload, single = (catalogue().resolve(name).motor for name in ("H128W", "AeroTech H100W_DMS"))
    tools = [drill_of(one) for one in (reload, single)]
    assert [one.least_left for one in tools if one] == [4.0, 6.0]
    assert list(offered(replace(reload, delays=(14.0,)), tools[0].takes_off if tools[0] else ())) == [
        14.0,
        12.0,
        10.0,
        8.0,
        6.0,
    ]
    assert "Pro54 DAT: any 0-10 s" in text
    wide = [motor for motor in catalogue().motors if motor.maker == "Cesaroni" and motor.kind == "reload"]
    for motor in wide:
        tool, size = drill_of(motor), round(motor.diameter * 1e3)
        steps = (3.0, 5.0, 7.0, 9.0) if size <= 38 else tuple(map(float, range(1, 11))) if size == 54 else None
        assert (tool.takes_off if tool else None) == steps, motor.designation
    assert "Quest, Estes: fixed delays, never drilled" in text
    fixed = [motor for motor in catalogue().motors if motor.maker in ("Quest", "Estes")]
    assert fixed
    assert not [motor for motor in fixed if drill_of(motor)]
