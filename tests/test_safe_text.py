"""Text for a terminal."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.safe_text import printable

pytestmark = pytest.mark.fast


def test_an_escape_sequence_is_shown_and_not_executed() -> None:
    assert printable("\x1b[31mred\x1b]0;title\x07") == "␛[31mred␛]0;title␇"


def test_a_mark_that_reverses_text_is_shown_as_its_number() -> None:
    assert printable("a\u202etxt.exe\u2066") == "a<U+202E>txt.exe<U+2066>"


def test_ordinary_text_is_unchanged() -> None:
    text = "Würger [bold] ½ µ 日本 👩\u200d🚀 שלום"
    assert printable(text) == text


@given(st.text())
def test_printable_text_is_one_line_without_control_characters_and_stays_unchanged(text: str) -> None:
    shown = printable(text)
    assert len(shown.splitlines()) <= 1
    assert not any(unicodedata.category(c) in ("Cc", "Cs") for c in shown)
    assert printable(shown) == shown
