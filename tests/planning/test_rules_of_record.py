"""The figures of the program compared with the tables of collected facts, `../shared/rules.md`, if that file exists."""

import math
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldkit.motors import catalogue
from fieldkit.planning.contest import season, seasons
from fieldkit.planning.delay import drill_of
from fieldkit.planning.limits import limits
from fieldkit.planning.rules import Rule, rule_sets
from fieldkit.units import FOOT

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
        assert sites.row(upper(span), 0.0) is row
        assert row.text.mark == ("U" if "U" in metres else "O"), motor


def test_the_distances_of_high_power() -> None:
    distance, rows = (
        rule("nar_high_power", "pad distance"),
        list(table("Installed impulse, N s", "Motor", "Cleared diameter")),
    )
    assert len(distance.rows) == len(rows) == 8
    for span, _, cleared, people, several in rows:
        row = distance.row(upper(span), 0.0)
        assert row is not None
        found = (row.cleared, distance.least(upper(span), 0.0), distance.least(upper(span), 0.0, complex_rocket=True))
        assert [(one or 0.0) / FOOT for one in found] == pytest.approx(
            [number(cleared), number(people), number(several)]
        )


def test_the_words_of_the_model_code() -> None:
    words = " ".join(one.text.words for one in SETS["nar_model"].rules)
    quoted = [quote for _, _, quote in table("Rule", "Figure", "Quote") if quote]
    assert len(quoted) == 9
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


@pytest.mark.parametrize(
    ("topic", "name", "place"),
    [
        ("Speed off the rod or rail", "rail_speed", 0),
        ("Rail speed and wind", "rail_speed_per_wind", 0),
        ("Thrust to weight", "thrust_to_weight", 0),
        ("Thrust to weight", "thrust_to_weight_unsafe", 4),
    ],
)
def test_guidance_that_is_not_law(topic: str, name: str, place: int) -> None:
    (row,) = [row for row in table("Topic", "Value") if row[0] == topic]
    assert limits()[name].value == float(re.findall(r"\d+(?:\.\d+)?", row[1])[place])
