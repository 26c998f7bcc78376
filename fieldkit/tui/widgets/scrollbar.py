"""A scrollbar that leaves a cell free beside text."""

from rich.color import Color
from rich.segment import Segment, Segments
from rich.style import Style
from textual.scrollbar import ScrollBarRender

BACK, BAR = Color.parse("#555555"), Color.parse("bright_magenta")
"""Textual's colors of a bar without any."""


class SpacedBar(ScrollBarRender):
    """A vertical scrollbar whose left cell is blank, if it has two, so that no text touches it."""

    @classmethod
    def render_bar(
        cls,
        size: int = 25,
        virtual_size: float = 50,
        window_size: float = 20,
        position: float = 0,
        thickness: int = 1,
        vertical: bool = True,
        back_color: Color = BACK,
        bar_color: Color = BAR,
    ) -> Segments:
        """The bar, a line for each cell of its height."""
        narrow = thickness - (vertical and thickness > 1)
        bar = super().render_bar(size, virtual_size, window_size, position, narrow, vertical, back_color, bar_color)
        if narrow == thickness:
            return bar
        lines = []
        for part in bar.segments:
            meta = part.style.meta if part.style is not None else {}
            lines += [Segment(" ", Style(bgcolor=back_color, meta=meta)), part, Segment.line()]
        return Segments(lines)
