"""A number three lines high in solid strokes, which can be read in sunlight."""

from typing import Any

from textual.content import Content
from textual.widgets import Static

GLYPHS = {
    "0": ("█▀█", "█ █", "▀▀▀"),
    "1": ("▀█ ", " █ ", "▀▀▀"),
    "2": ("▀▀█", "█▀▀", "▀▀▀"),
    "3": ("▀▀█", " ▀█", "▀▀▀"),
    "4": ("█ █", "▀▀█", "  ▀"),
    "5": ("█▀▀", "▀▀█", "▀▀▀"),
    "6": ("█▀▀", "█▀█", "▀▀▀"),
    "7": ("▀▀█", "  █", "  ▀"),
    "8": ("█▀█", "█▀█", "▀▀▀"),
    "9": ("█▀█", "▀▀█", "▀▀▀"),
    ".": (" ", " ", "▀"),
    ",": (" ", " ", "▀"),
    "-": ("  ", "▀▀", "  "),
    "+": ("   ", "▀█▀", "   "),
    "≈": ("   ", "▄▀▄", "▄▀▄"),
}
"""Strokes as wide as half a line is high: five dots up, three across."""


def large(text: str) -> str:
    """A number in three lines; a character without a large form is on the last line."""
    drawn = [GLYPHS.get(letter, (" ", " ", letter)) for letter in text]
    return "\n".join(" ".join(glyph[line] for glyph in drawn) for line in range(3)) if drawn else ""


class Big(Static):
    """A large number in a widget of fixed size, so that changes need no new layout."""

    DEFAULT_CSS = """
    Big { height: 3; width: auto; color: $accent; text-style: bold; text-wrap: nowrap; text-overflow: clip; }
    """

    def __init__(self, **rest: Any) -> None:
        super().__init__("", **rest)
        self.value = ""

    def show(self, value: str) -> None:
        """Show a number."""
        self.value = value
        self.update(Content(large(value)), layout=self.styles.is_auto_width)
