"""The three actions of a launch day, large enough to hit with a finger."""

from collections.abc import Iterable

from textual.containers import Horizontal
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

CHOICES = (
    ("f", "Fly", "choose a motor"),
    ("a", "Add", "add a flight"),
    ("p", "Plan", "rocket and weather"),
)
"""Key, name, and description."""
LONG_CHOICE_WIDTH = 34
"""Width above which a choice shows its description. [cell]"""


class Choice(Static):
    """A key with its name; a click presses it."""

    DEFAULT_CSS = """
    Choice { width: 1fr; height: 3; border: round $border; padding: 0 1; content-align: center middle; }
    Choice:hover { background: $panel; }
    """

    def __init__(self, key: str, name: str, about: str) -> None:
        super().__init__()
        self._key, self._name, self._about = key, name, about

    def render(self) -> Content:
        """Its description is shown if there is room."""
        parts: list[str | tuple[str, str]] = [(f" {self._key} ", "b reverse"), (f" {self._name}", "b")]
        return Content.assemble(*parts, f"  {self._about}" if self.size.width > LONG_CHOICE_WIDTH else "")

    async def on_click(self) -> None:
        """Do what the key does."""
        await self.run_action(f"app.press({self._key!r})")


class Choices(Horizontal):
    """The three choices."""

    DEFAULT_CSS = """
    Choices { height: 3; padding: 0 1; }
    """

    def compose(self) -> Iterable[Widget]:
        """Side by side."""
        for key, name, about in CHOICES:
            yield Choice(key, name, about)
