"""Timers and eggs of a contest flight, as they are typed and written in tables."""

import pytest

from fieldkit.errors import BadValue
from fieldkit.flight.judged import CRACKED, INTACT, Eggs, condition_of_eggs, read_eggs, read_timer

pytestmark = pytest.mark.fast


@pytest.mark.parametrize(
    ("text", "eggs"),
    [
        ("", None),
        ("n/a", None),
        ("2 intact", Eggs(True, 2)),
        ("2x OK!", Eggs(True, 2)),
        ("1 of 2 intact", Eggs(True, 1)),
        ("3 eggs, 2 intact", Eggs(True, 2)),
        ("1 intact and 1 intact", Eggs(True, 2)),
        ("not cracked", Eggs(True)),
        ("0 cracked", Eggs(True)),
        ("none intact", Eggs(False)),
        ("1 of 2 cracked", Eggs(False)),
        ("hairline crack on the second", Eggs(False)),
        ("2 intact, 1 cracked", Eggs(False, 2)),
        ("2 eggs", Eggs(None)),
    ],
)
def test_a_text_about_eggs_says_whether_they_are_intact_and_how_many(text: str, eggs: Eggs | None) -> None:
    assert read_eggs(text) == eggs


@pytest.mark.parametrize(
    ("text", "means"), [("intakt", "intact"), ("2 itact", "intact"), ("craked", "cracked"), ("Crackd", "cracked")]
)
def test_a_misspelled_condition_is_refused_with_the_right_spelling(text: str, means: str) -> None:
    with pytest.raises(BadValue, match=f"did you mean {means}\\?"):
        read_eggs(text)


@pytest.mark.parametrize("text", ["yes", "?!", "raw", "9" * 5000 + " raw"])
def test_a_text_that_says_nothing_about_eggs_is_refused(text: str) -> None:
    with pytest.raises(BadValue, match="expected intact or cracked, such as 2 intact"):
        read_eggs(text)


def test_every_word_of_a_condition_is_read_alone() -> None:
    assert {read_eggs(word) for word in INTACT} == {Eggs(True)}
    assert {read_eggs(word) for word in CRACKED} == {Eggs(False)}


def test_a_count_of_eggs_without_their_condition_cannot_be_typed() -> None:
    assert condition_of_eggs("2 intact") == "2 intact"
    with pytest.raises(BadValue, match="found '2', expected intact or cracked"):
        condition_of_eggs("2")


def test_what_a_watch_showed_may_have_its_unit_or_a_decimal_comma() -> None:
    assert [read_timer(text) for text in ("38.42", "38,42", "38.42 s", "-")] == [38.42, 38.42, 38.42, None]
    for text in ("0", "38.4.2", "abc", "20000"):
        with pytest.raises(BadValue, match="expected seconds such as"):
            read_timer(text)
