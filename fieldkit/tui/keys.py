"""Esc and the key behind it, which a terminal or a busy machine may hand on together.

Terminals send Alt and a key as Esc and that key. No key of the app goes with Alt, so here they are always two; Textual
would make of Esc and 1 the sign that a Mac types with Option, and both keys would be lost.
"""

from collections.abc import Iterable

from textual._xterm_parser import XTermParser
from textual.events import Key

ESCAPE = "\x1b"
OPENERS = "[]OPX^_\\"
"""What begins, or ends, a longer sequence behind Esc: an arrow, an answer of the terminal."""

EARLY_ENTER = "\n"
"""Enter, as a terminal hands it on that the app had not taken yet when it was pressed."""

_read = XTermParser._sequence_to_key_events


def split_escapes() -> None:
    """Have the parser of every driver read Esc and a key as two keys, and an early Enter as Enter."""
    XTermParser._sequence_to_key_events = _two_keys  # type: ignore[method-assign, assignment]


def _two_keys(parser: XTermParser, sequence: str, alt: bool = False) -> Iterable[Key]:
    """The keys of a sequence; `alt` says that an Esc stood before it."""
    pair = len(sequence) == 2 and sequence[0] == ESCAPE and sequence[1] not in OPENERS
    if alt or pair:
        yield Key("escape", ESCAPE)
    key = sequence[-1] if pair else sequence
    yield from _read(parser, "\r" if key == EARLY_ENTER else key)
