"""Words that are shown but not in any text from `tools/strings.py`, so a translator would not find them."""

import re
from functools import cache
from pathlib import Path

from tools.strings import texts

ROOT = Path(__file__).parents[1]
WORD = re.compile(r"(?<![A-Za-z\d])[A-Za-z]{3,}(?![A-Za-z\d])")
"""A word, not a part of an id or of a digest."""
UNITS_AND_KEYS = "hpa inhg mph pgdn pgup tab"
"""Units and names of keys, which are not translated."""


@cache
def known_words() -> frozenset[str]:
    """Words of all texts, and of shipped data: motors, rules, seasons, flights."""
    data = [file for kind in ("toml", "csv", "json") for file in (ROOT / "fieldkit" / "data").rglob(f"*.{kind}")]
    own = " ".join([UNITS_AND_KEYS, *(text for _, _, text in texts())])
    return frozenset(_words(own).union(*(_words(file.read_text(encoding="utf-8")) for file in data)))


def _words(text: str) -> set[str]:
    return {word.lower() for word in WORD.findall(text)}


def unlisted(shown: str, typed: str = "") -> list[str]:
    """Words of what is shown that are neither in a text, nor in shipped data, nor in what the user typed."""
    return sorted(_words(shown) - known_words() - _words(typed))
