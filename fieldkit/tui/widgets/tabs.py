"""The names of a page's alternating views, in one line."""

from collections.abc import Sequence
from typing import Any

from textual.content import Content
from textual.widgets import Static


class TabLine(Static):
    """The current view is marked as in the line of pages; a click on another runs an action with its index."""

    DEFAULT_CSS = """
    TabLine { height: 1; padding: 0 1; background: $panel; color: $foreground; text-wrap: nowrap;
        link-style: none; link-color: $foreground; link-background: $panel; }
    """

    def __init__(self, names: Sequence[str], action: str, **rest: Any) -> None:
        super().__init__(**rest)
        self._names, self._action = names, action

    def front(self, number: int) -> None:
        """Mark the view with this index as the current one."""
        marks = (
            f"[b reverse] {name} [/]" if at == number else f"[@click={self._action}({at})] {name} [/]"
            for at, name in enumerate(self._names)
        )
        self.update(Content(" ").join(map(Content.from_markup, marks)))
