"""Every regular expression of the program takes at most linear time in the length of its text."""

import ast
import importlib
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from fieldkit.plugins import plugins

CHECK_SHAPES = False
ROOT = Path(__file__).parents[1]
ASKED = ("match", "search", "fullmatch", "finditer", "findall", "sub", "split")
USED = re.compile(rf"\bre\.(compile|{'|'.join(ASKED)})\b")
LENGTHS = (20, 400, 1500)
"""Lengths of hostile texts: exponential time is visible at the first, polynomial time at the last. [characters]"""
ENOUGH = 0.1
"""Maximum time of an expression for any of them; a linear one takes microseconds. [s]"""
PIECES = (
    *"1 .,-+a_\"'()[]:;/=\t\\#%!*<>$@~&",
    *("1,", "1.", "a ", "1 ", "a1", ", ", "- ", "(a", "a.", "1e", ".1", "\n ", " \n", "Event ", "ab:", "00 ", "0a"),
)
ENDS = ("", "x", "!", "\n", "é", "0", " 1", ",,x", "\n1")


def expressions() -> Iterator[tuple[str, "re.Pattern[Any]", str]]:
    """Every compiled expression of a module, with its name and each way in which it is used."""
    for file in sorted((*(ROOT / "fieldkit").rglob("*.py"), *(ROOT / "parsers").glob("*.py"))):
        text = file.read_text(encoding="utf-8")
        if not USED.search(text):
            continue
        tree, place = ast.parse(text), file.relative_to(ROOT)
        kept = [
            target.id
            for node in tree.body
            if isinstance(node, ast.Assign) and "re.compile(" in ast.unparse(node.value)
            for target in node.targets
            if isinstance(target, ast.Name)
        ]
        module = _module(file) if kept else None
        for name in kept:
            pattern = getattr(module, name)
            ways = [way for way in ASKED if f"{name}.{way}" in text] or ["match", "fullmatch"]
            if isinstance(pattern, re.Pattern):
                yield from ((f"{place}:{name}", pattern, way) for way in ways)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
                first = node.args[0]
                direct = (
                    isinstance(node.func.value, ast.Name) and node.func.value.id == "re" and node.func.attr in ASKED
                )
                if direct and isinstance(first, ast.Constant) and isinstance(first.value, str | bytes):
                    yield f"{place}:{node.lineno}", re.compile(first.value), node.func.attr


def _module(file: Path) -> Any:
    if file.parent.name == "parsers":
        plugins("parsers", "PARSER")  # which mounts the plug-ins
        return importlib.import_module(f"fieldkit.parsers.{file.stem}")
    parts = file.relative_to(ROOT).with_suffix("").parts
    return importlib.import_module(".".join(part for part in parts if part != "__init__"))


EXPRESSIONS = list(expressions())


def test_expressions_are_found() -> None:
    assert len(EXPRESSIONS) > 60


def hostile(length: int) -> Iterator[str]:
    """Texts that repeat one piece and nearly match an expression."""
    for piece in PIECES:
        for start in ("", "1", "a"):
            yield from (start + piece * (length // len(piece)) + end for end in ENDS)


TEXTS = {length: list(hostile(length)) for length in LENGTHS}


@pytest.mark.sampled
@pytest.mark.parametrize(("name", "pattern", "way"), EXPRESSIONS, ids=lambda one: str(one)[:60])
def test_no_expression_takes_long_over_a_long_text(name: str, pattern: "re.Pattern[Any]", way: str) -> None:
    for length, texts in TEXTS.items():
        for text in texts:
            began = time.process_time()
            asked(pattern, way, text)
            elapsed = time.process_time() - began
            assert elapsed < ENOUGH, f"{name}: {elapsed:.2f} s over {length} characters, {text[:5]!r}...{text[-5:]!r}"


def asked(pattern: "re.Pattern[Any]", way: str, text: Any) -> None:
    """Search a text in one of the ways."""
    empty: Any = ""
    if isinstance(pattern.pattern, bytes):
        text, empty = text if isinstance(text, bytes) else text.encode(), b""
    if way == "finditer":
        list(pattern.finditer(text))
    elif way == "sub":
        pattern.sub(empty, text)
    else:
        getattr(pattern, way)(text)


def test_an_expression_is_searched_in_a_long_run_of_digits_in_linear_time() -> None:
    """A cell of 80,000 digits is read in seconds only if no search starts again at each of them."""
    for name, pattern, way in expressions():
        text: Any = b"1" * 12_000 if isinstance(pattern.pattern, bytes) else "1" * 12_000
        began = time.process_time()
        if way == "search":
            pattern.search(text)
        assert time.process_time() - began < 2 * ENOUGH, name


BOUNDED = ("cli/docs.py", "planning/check.py", "tables/xlsx.py:_LITERAL")
"""Expressions for texts of fieldkit's own, and for at most 255 characters."""
SEARCHES = [
    one
    for one in EXPRESSIONS
    if one[2] in ("search", "finditer", "findall", "sub", "split") and not any(place in one[0] for place in BOUNDED)
]
LONG, PER_CHARACTER = 20_000, 1.5e-6
"""Length of a text [characters], and how long a search may take for each of them [s]: 32 MB then take a minute at most.
A bounded repetition that starts again at every match of what precedes it takes longer than that."""


@pytest.mark.sampled
@pytest.mark.parametrize(("name", "pattern", "way"), SEARCHES, ids=lambda one: str(one)[:60])
@given(data=st.data())
@settings(
    max_examples=4,
    derandomize=True,
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)
def test_no_search_takes_long_over_beginnings_of_what_it_finds(
    name: str, pattern: "re.Pattern[Any]", way: str, data: st.DataObject
) -> None:
    """A tag that is opened again and again but never closed, a label without its value."""
    found: Any = data.draw(st.from_regex(pattern))
    for end in {len(found) // 4, len(found) // 2, 3 * len(found) // 4, len(found) - 1} - {0, -1}:
        text = found[:end] * (LONG // end)
        began = time.process_time()
        asked(pattern, way, text)
        elapsed = time.process_time() - began
        assert elapsed < PER_CHARACTER * LONG, f"{name}: {elapsed:.2f} s over {found[:end]!r} again and again"
