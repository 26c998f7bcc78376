"""Keys as a terminal sends them: none that the app is bound to is lost where several come together."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual._xterm_parser import XTermParser
from textual.events import Key

from fieldkit.tui.keys import pressed

pytestmark = pytest.mark.fast

NAMES = {"\x1b": "escape", "\r": "enter", "\n": "enter", "\x1b[A": "up", "\x1b[B": "down"}
NAMES |= {letter: letter for letter in "0123456789acuqT"}


def keys(sent: str, *, typed: bool = False) -> list[str]:
    """The keys that the app sees of what came in one piece."""
    parser = XTermParser()
    events = [*parser.feed(sent), *parser.feed("")]
    return [key.key for event in events if isinstance(event, Key) for key in pressed(event, typed=typed)]


@given(st.lists(st.sampled_from(sorted(NAMES)), min_size=1, max_size=12))
def test_keys_that_come_together_are_the_keys_that_were_pressed(sent: list[str]) -> None:
    assert keys("".join(sent)) == [NAMES[one] for one in sent]


@pytest.mark.parametrize(("sent", "key"), [("\x1b[1;3D", "alt+left"), ("\x1bOP", "f1"), ("\x1b[Z", "shift+tab")])
def test_longer_sequences_stay_whole(sent: str, key: str) -> None:
    assert keys(sent) == [key]


@pytest.mark.parametrize("letter", "£§ºª")
def test_a_letter_that_a_line_takes_is_no_digit(letter: str) -> None:
    (key,) = keys(letter, typed=True)
    assert key not in ("escape", *"0123456789")
