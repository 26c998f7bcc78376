"""Unexplained patterns in words."""

import pytest

from fieldkit.selection import unexplained
from fieldkit.selection.candidates import Pattern

pytestmark = pytest.mark.fast


@pytest.mark.parametrize(
    ("pattern", "words"),
    [
        (Pattern("repeated", "F1", every=2), "in every second place, F1 among them,"),
        (Pattern("repeated", "F1", every=3), "in every third place, F1 among them,"),
        (Pattern("lasting", "F5"), "from F5 on"),
        (Pattern("site", "mead"), "from mead"),
        (Pattern("day", "2026-05-02"), "on 2026-05-02"),
        (Pattern("text", "igniter", "Estes"), "with igniter Estes"),
        (Pattern("text", "motor batch", "bought last year"), "with motor batch bought last year"),
        (Pattern("text", "launch rod", "of the club"), "with launch rod of the club"),
    ],
)
def test_the_flights_of_a_pattern_are_described(pattern: Pattern, words: str) -> None:
    assert unexplained._pattern_words(pattern) == words
