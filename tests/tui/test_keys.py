"""Keys as a terminal sends them: none is lost where several come together."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual._xterm_parser import XTermParser
from textual.events import Key

from fieldkit.tui.keys import split_escapes

pytestmark = pytest.mark.fast

NAMES = {
    "\x1b": "escape",
    "\r": "enter",
    "\n": "enter",
    "\x1b[A": "up",
    "\x1b[B": "down",
    "\x7f": "backspace",
    ".": "full_stop",
}
NAMES |= {letter: letter for letter in "159abfuqT"}


def keys(sent: str) -> list[str]:
    """The keys that a driver makes of what came in one piece."""
    split_escapes()
    parser = XTermParser()
    found = [*parser.feed(sent), *parser.feed("")]
    return [event.key for event in found if isinstance(event, Key)]


@given(st.lists(st.sampled_from(sorted(NAMES)), min_size=1, max_size=12))
def test_keys_that_come_together_are_the_keys_that_were_pressed(pressed: list[str]) -> None:
    assert keys("".join(pressed)) == [NAMES[one] for one in pressed]


@pytest.mark.parametrize(("sent", "key"), [("\x1b[1;3D", "alt+left"), ("\x1bOP", "f1"), ("\x1b[Z", "shift+tab")])
def test_longer_sequences_stay_whole(sent: str, key: str) -> None:
    assert keys(sent) == [key]
