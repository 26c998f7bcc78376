"""An answer on the Decide screen: text, details and picture."""

from dataclasses import dataclass
from typing import Any

from fieldkit.tui.next.intervals import Intervals


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer in lines with its details: its conditions and every safety check. `title` is that of its picture:
    intervals on one scale, or the plot by `draw`, with an optional `second` plot next to it; with both, a tall screen
    shows the plot under the title `below`. `large` is its main figure
    in large digits, with up to three lines `about` it."""

    words: tuple[str, ...]
    beside: tuple[str, ...] = ()
    title: str = ""
    intervals: Intervals | None = None
    below: str = ""
    draw: Any = None
    second: Any = None
    large: str = ""
    about: tuple[str, ...] = ()
    folded: tuple[str, ...] = ()
    """The details with only the failed safety checks, and how many others there are; empty if nothing is left out."""

    @property
    def text(self) -> str:
        """The whole answer as text, for copying."""
        return "\n".join([*self.words, *([""] if self.beside else []), *self.beside])
