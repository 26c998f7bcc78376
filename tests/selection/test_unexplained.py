"""Unexplained patterns in words."""

import pytest

from fieldkit.selection import unexplained

pytestmark = pytest.mark.fast


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("every 2 flights, as F1", "that are every second one, as F1"),
        ("every 3 flights, as F1", "that are every third one, as F1"),
        ("every flight from F5 on", "from F5 on"),
        ("the site mead", "from mead"),
        ("the day 2026-05-02", "on 2026-05-02"),
        ("igniter Estes", "with igniter Estes"),
        ("motor batch bought last year", "with motor batch bought last year"),
        ("launch rod of the club", "with launch rod of the club"),
    ],
)
def test_the_flights_of_a_pattern_are_described(place: str, words: str) -> None:
    assert unexplained._pattern_words(place) == words
