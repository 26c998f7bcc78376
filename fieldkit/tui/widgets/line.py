"""An input line."""

from typing import Any

from textual.widgets import Input


class Line(Input):
    """An input in which a question mark opens the help, unless it `takes_marks`."""

    DEFAULT_CSS = """
    Line:ansi > .input--selection { text-style: reverse; }
    """

    def __init__(self, text: str = "", *, takes_marks: bool = True, **rest: Any) -> None:
        super().__init__(text, select_on_focus=True, validate_on=(), **rest)
        self.takes_marks = takes_marks
        self.cursor_blink = False

    def on_blur(self) -> None:
        """Show the beginning of a text longer than the line."""
        self.scroll_to(0, animate=False, immediate=True)

    def check_consume_key(self, key: str, character: str | None = None) -> bool:
        """Whether a key is a character here; Textual finds no character for the key `slash`."""
        character = "/" if key == "slash" else character
        asks = character == "?" and not self.takes_marks
        return super().check_consume_key(key, character) and not asks
