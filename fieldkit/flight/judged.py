"""Further columns in which a contest flight is judged: its timers, and its eggs as teams write it, `2 intact`."""

import re
from dataclasses import dataclass

from fieldkit import units
from fieldkit.errors import BadValue, nearest
from fieldkit.safe_text import whole_number

LONGEST_TIMED = 10_000.0
"""A timer that shows more is a typing error. [s]"""

INTACT = ("intact", "whole", "ok", "okay", "uncracked", "unbroken", "undamaged", "good", "fine", "safe", "survived")
"""Words for eggs that are intact."""
CRACKED = ("cracked", "crack", "cracks", "broken", "broke", "damaged", "crushed", "smashed", "split", "leaking", "lost")
"""Words for eggs that are not."""
_NUMBERS = {"one": 1, "both": 2, "two": 2, "three": 3}
_NEGATIONS = ("no", "none", "not", "neither", "zero")
_UNKNOWN = ("", "-", "–", "—", "n/a", "na", "?", "unknown", "null")
_FILLERS = ("egg", "eggs", "x", "all", "of", "the", "a", "any", "was", "were", "is", "are", "still", "each", "other")
_CLAUSES = re.compile(r"[,;/+&]|\band\b|\bbut\b")
_WORD = re.compile(r"\d{1,3}|[^\W\d_]+")
_EXPECTED = "expected intact or cracked, such as 2 intact"


@dataclass(frozen=True, slots=True)
class Eggs:
    """The eggs of a flight: whether all that are named are intact, None if the text only counts them; and how many are,
    None if it does not say. [1]"""

    intact: bool | None
    count: int | None = None


def is_empty(text: str) -> bool:
    """Whether a cell says nothing: empty, `-`, `n/a`."""
    return text.strip().casefold() in _UNKNOWN


def read_timer(text: str) -> float | None:
    """What a watch showed, None if the cell says nothing. Raises BadValue. [s]"""
    if is_empty(text):
        return None
    try:
        time = units.parse(text, "time", "s")
    except BadValue:
        time = 0.0
    if not 0 < time < LONGEST_TIMED:
        raise BadValue(f"found {text[:20]!r}, expected seconds such as 38.42")
    return time


def read_eggs(text: str) -> Eggs | None:
    """The eggs that a text describes; None if it is empty, `-` or `n/a`.

    Raises BadValue for another word, with the spelling that it may mean; beside a crack any word is accepted.
    """
    if is_empty(text):
        return None
    words = _WORD.findall(text.casefold())
    found = [clause for part in _CLAUSES.split(text.casefold()) if (clause := _clause(part)).intact is not None]
    intact = all(clause.intact for clause in found) if found else None
    known = {*INTACT, *CRACKED, *_NUMBERS, *_NEGATIONS, *_FILLERS, "and", "but"}
    unknown = [word for word in words if whole_number(word) is None and word not in known]
    if intact is not False and (unknown or not words):
        near = nearest(unknown[0], (*INTACT, *CRACKED)) if unknown else []
        raise BadValue(f"found {text[:40]!r}" + (f"; did you mean {near[0]}?" if near else f", {_EXPECTED}"))
    counts = [clause.count for clause in found if clause.intact and clause.count is not None]
    return Eggs(intact, sum(counts) if counts else None)


def _clause(text: str) -> Eggs:
    """What one part of a text says; its first number is how many."""
    intact, count, none = None, None, False
    for word in _WORD.findall(text):
        if (number := _NUMBERS.get(word, whole_number(word))) is not None:
            count = number if count is None else count
        elif word in _NEGATIONS:
            none = True
        elif word in INTACT:
            intact = not none
        elif word in CRACKED:
            intact, count = none or count == 0, None
    return Eggs(intact, count)


def condition_of_eggs(text: str) -> str:
    """A text that says whether the eggs are intact, or an empty one, unchanged. Raises BadValue."""
    eggs = read_eggs(text)
    if eggs is not None and eggs.intact is None:
        raise BadValue(f"found {text[:40]!r}, {_EXPECTED}")
    return text
