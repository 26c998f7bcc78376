"""States of figures by their symbols, and the colors of the theme that repeat them: none is told by color alone."""

import re
from collections.abc import Iterator, Mapping

GOOD, CAUTION, BAD, MARKED = "success", "warning", "error", "accent"
"""The colors of a theme for states."""
STATES: Mapping[str, str] = {
    "✓": GOOD,
    "◎": GOOD,
    "!": CAUTION,
    "?": CAUTION,
    "≈": CAUTION,
    "⊘": BAD,
    "✗": BAD,
    "◆": MARKED,
}
"""Symbols with their color: on target or passed, caution or provisional, not possible, flown."""
DRAWN = frozenset(" ◆◎├┤←→─●◉")
"""The signs of which a drawn interval consists."""
BAR = re.compile(r"[├←][─●◉◎◆]*[┤→]")
"""An interval drawn as a bar."""


def runs(cell: str) -> Iterator[tuple[str, str]]:
    """A cell in parts, each with the color of its state, empty for none: all of a text after a symbol, or the marks of
    an interval. A flight is good inside its interval and bad outside."""
    if DRAWN.issuperset(cell):
        found = BAR.search(cell)
        flown = MARKED if found is None else GOOD if "◆" in found[0] else BAD
        for part in re.split("([◎◆])", cell):
            yield part, {"◎": MARKED, "◆": flown}.get(part, "")
    else:
        yield cell, STATES.get(cell.lstrip()[:1], "")
