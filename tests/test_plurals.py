"""Counts agree with their nouns: `1 flight`, never `1 flights`."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from fieldkit.quantities import counted

pytestmark = pytest.mark.fast
CHECK_SHAPES = False

ROOT = Path(__file__).parents[1]
NOT_SHOWN = ("fieldkit/inference/training", "fieldkit/inference/validation", "fieldkit/inference/history")
"""Code whose messages are for developers."""
NOUNS = """
    apps bytes candidates cells characters clusters columns draws duplicates elements errors figures files flights
    flyers headers histories lines logs motors notes notices numbers packets parts pieces plans points ports readouts
    rockets rows samples sentences simulations stages tests
"""
PLURAL = re.compile(
    rf"\{{([^{{}}]*)\}} (?:(?:more|normal|other|unique|earlier|simulated) )?({'|'.join(NOUNS.split())})\b"
)
"""A value and a plural noun after it: `{len(flights)} normal flights`."""
CONSTANT = re.compile(r"[A-Z_]+")
"""The name of a constant, whose value is known to be more than one."""
NEVER_ONE = {
    "len(where)": "ports, reported only if there are several",
    "len(candidates)": "motors, reported only if a name has several meanings",
    "len(stages)": "stages, reported only if there are several",
    "len(found)": "motors for the shortlist beyond a limit; simulations that differ",
    "len(places)": "columns of one name, reported only if there are several",
    "len(parts)": "parts beyond a limit",
    "len(planned)": "flights beyond the room on a page",
    "len(log)": "bytes beyond a limit",
    "count": "motors of a cluster out of bounds; files read together; flights of a pattern; flights of the demo",
    "rule.declared": "flights that a season lets a team declare",
    "len(governed_by.build.motors)": "motors of a cluster",
    "found.forecasts": "the window of recent forecasts",
    "len(found.flights)": "the flights of the demo",
    "found.predictions[0].rests_on": "the flights of the demo",
    "self.every": "the period of a pattern, from two on",
    "width": "bytes of a record",
    "size": "bytes beyond a limit",
    "least": "numbers of a sentence",
    "largest": "bytes, a limit",
    "total": "points, a decimal number",
    "points": "points, a decimal number",
    "best.gain_error": "points, a decimal number",
    "advice.gain_error": "points, a decimal number",
    "len(READOUT_QUESTIONS)": "readouts that are asked for",
    "found['n']": "simulated flights of the paper, thousands",
}
"""Expressions that are never one, or are not counts, each with what it is."""


@cache
def _texts() -> tuple[tuple[str, int, str], ...]:
    """Formatted strings of the program, each value as `{expression}`."""
    return tuple(_read())


def _read() -> Iterator[tuple[str, int, str]]:
    for file in sorted(path for folder in ("fieldkit", "parsers") for path in (ROOT / folder).rglob("*.py")):
        name = file.relative_to(ROOT).as_posix()
        if name.startswith(NOT_SHOWN):
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                yield name, node.lineno, "".join(_part(part) for part in node.values)


def _part(part: ast.expr) -> str:
    if isinstance(part, ast.FormattedValue):
        return "{" + ast.unparse(part.value).replace("{", "(").replace("}", ")") + "}"
    return str(part.value) if isinstance(part, ast.Constant) else ""


def uncounted(text: str) -> list[str]:
    """The counts of a text whose noun is always plural."""
    return [
        f"{value} {noun}"
        for value, noun in PLURAL.findall(text)
        if not CONSTANT.fullmatch(value) and value not in NEVER_ONE
    ]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("{len(ids)} flights", ["len(ids) flights"]),
        ("{number} normal flights in it", ["number flights"]),
        ("at most {MAX_MOTORS} motors", []),
        ("{counted(len(ids), 'flight')}", []),
    ],
)
def test_a_count_with_a_fixed_plural_is_found(text: str, found: list[str]) -> None:
    assert uncounted(text) == found


def test_no_count_has_a_fixed_plural() -> None:
    found = [f"{name}:{line}: {one}" for name, line, text in _texts() for one in uncounted(text)]
    assert not found, "\n".join(found)


def test_each_exception_is_needed() -> None:
    values = {value for _, _, text in _texts() for value, _ in PLURAL.findall(text)}
    assert NEVER_ONE.keys() <= values


@pytest.mark.parametrize(
    ("count", "text"), [(0, "0 rows"), (1, "1 row"), (2, "2 rows"), (999, "999 rows"), (1200, "1,200 rows")]
)
def test_a_count_agrees_with_its_noun(count: int, text: str) -> None:
    assert counted(count, "row") == text
