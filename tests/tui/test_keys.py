"""Keys as a terminal sends them: no bound key is lost if several arrive together."""

import pytest
from textual._xterm_parser import XTermParser
from textual.events import Key

from fieldkit.tui.keys import pressed

pytestmark = pytest.mark.fast

NAMES = {"\x1b": "escape", "\x1b[A": "up", "\x1b[B": "down"}
NAMES |= {letter: letter for letter in "0123456789acuqT"}


def keys(sent: str, *, typed: bool = False) -> list[str]:
    """The keys that the app receives from one chunk of input."""
    parser = XTermParser()
    events = [*parser.feed(sent), *parser.feed("")]
    return [key.key for event in events if isinstance(event, Key) for key in pressed(event, typed=typed)]


@pytest.mark.parametrize("first", NAMES)
@pytest.mark.parametrize("second", NAMES)
def test_two_keys_that_arrive_together_are_read_as_pressed(first: str, second: str) -> None:
    assert keys(first + second) == [NAMES[first], NAMES[second]]


@pytest.mark.parametrize("sent", ["\r", "\n", "a\r1", "\x1b[A\n"])
def test_enter_is_read_after_any_key(sent: str) -> None:
    assert "enter" in keys(sent)


@pytest.mark.parametrize(("sent", "key"), [("\x1b[1;3D", "alt+left"), ("\x1bOP", "f1"), ("\x1b[Z", "shift+tab")])
def test_longer_sequences_are_not_split(sent: str, key: str) -> None:
    assert keys(sent) == [key]


@pytest.mark.parametrize("letter", "£§ºª")
def test_a_letter_typed_into_an_input_is_not_a_digit(letter: str) -> None:
    (key,) = keys(letter, typed=True)
    assert key not in ("escape", *"0123456789")
