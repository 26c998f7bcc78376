"""Similarity of the beginning of a file to a format, measured by the signs of the format.

A sign is a column name, a label or a phrase, ignoring case and spacing; `|` separates alternative spellings. A sign of
fewer than five characters must be a whole cell or word, because it would otherwise match in any text.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import HEAD, Parser
from fieldkit.importing.tables.text import decode

_MAX_WHOLE_WORD = 5
"""Length below which signs must be whole words. [characters]"""
_LOOKED_AT = 16_384
"""Size of the beginning that is searched for signs. [characters]"""
_SCORE_WITHOUT_SIGNS = 0.5
"""The score of a parser that recognizes a log but defines no signs. [1]"""
_MAX_NEAR_FORMATS, _MIN_SIGN_FRACTION = 3, 0.25
"""Number of similar formats that are reported, and the fraction of its signs that each must have. [1]"""


@dataclass(frozen=True, slots=True)
class Likeness:
    """The signs of a parser that a file contains, and those that it lacks."""

    found: tuple[str, ...]
    missing: tuple[str, ...]

    @property
    def part(self) -> float:
        """Fraction of all signs that are present. [1]"""
        count = len(self.found) + len(self.missing)
        return len(self.found) / count if count else 0.0


@lru_cache(maxsize=4)
def _words(head: bytes) -> tuple[str, frozenset[str]]:
    """The beginning of a file as one line of lower-case text, and its cells and words."""
    try:
        text = decode(head)[:_LOOKED_AT].lower()
    except DamagedLog:
        text = head[:_LOOKED_AT].decode("latin-1").lower()
    text = text.replace('"', "")
    cells = {" ".join(cell.split()) for cell in re.split(r"[,;\t\r\n]", text)}
    return " ".join(text.split()), frozenset(cells | set(re.split(r"[\s,;:]+", text)))


def likeness(parser: Parser, log: bytes) -> Likeness:
    """The signs of a parser that a file contains, as spelled there."""
    text, words = _words(log[:HEAD])
    spelled = [
        (sign, next((one for one in sign.split("|") if _contains_sign(text, words, one.lower())), ""))
        for sign in parser.signs
    ]
    found = tuple(one for _, one in spelled if one)
    return Likeness(found, tuple(sign.partition("|")[0] for sign, one in spelled if not one))


def _contains_sign(text: str, words: frozenset[str], sign: str) -> bool:
    sign = " ".join(sign.replace('"', "").split())
    return sign in words or (len(sign) >= _MAX_WHOLE_WORD and _pattern(sign).search(text) is not None)


@lru_cache(maxsize=512)
def _pattern(sign: str) -> re.Pattern[str]:
    """A pattern for a sign that is not part of a longer word."""
    before, after = (r"(?<!\w)" if sign[0].isalnum() else ""), (r"(?!\w)" if sign[-1].isalnum() else "")
    return re.compile(before + re.escape(sign) + after)


def score(parser: Parser, log: bytes) -> tuple[float, int]:
    """The score of a parser that recognizes a log, and the number of its signs that are present. [1]

    The score rises from 0.5 to 1 with the fraction of its signs that are present; a parser without signs has also
    recognized the log.
    """
    like = likeness(parser, log)
    return _SCORE_WITHOUT_SIGNS + (1 - _SCORE_WITHOUT_SIGNS) * like.part, len(like.found)


def nearest(parsers: Mapping[str, Parser], log: bytes) -> list[tuple[str, Likeness]]:
    """The parsers with the most signs in a file, best first; empty if hardly any match."""
    likes = [(name, likeness(parser, log)) for name, parser in parsers.items() if parser.signs]
    likes = [(name, like) for name, like in likes if like.part >= _MIN_SIGN_FRACTION]
    return sorted(likes, key=lambda item: (-item[1].part, -len(item[1].found)))[:_MAX_NEAR_FORMATS]
