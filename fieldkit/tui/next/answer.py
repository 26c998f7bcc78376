"""An answer to a question that a flyer decides by: in words, with what stands beside it and its picture."""

from dataclasses import dataclass
from typing import Any

from fieldkit.tui.next.intervals import Intervals


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer in lines, and what stands below or beside it: the conditions it holds in, and every safety line.

    `title` is of its picture: intervals on one scale, or what `draw` draws and, beside
    it, the `second`.
    """

    words: tuple[str, ...]
    beside: tuple[str, ...] = ()
    title: str = ""
    intervals: Intervals | None = None
    draw: Any = None
    second: Any = None

    @property
    def text(self) -> str:
        """All of it, to be copied."""
        return "\n".join([*self.words, *([""] if self.beside else []), *self.beside])
