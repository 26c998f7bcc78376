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
BAR = re.compile(r"[├←][─●◉◎◆]*[┤→]|[◎◆]")
"""An interval drawn as a bar, or a mark outside of it."""


def runs(cell: str) -> Iterator[tuple[str, str]]:
    """A cell in parts, each with the color of its state, empty for none: all of it after a symbol, or the marks of an
    interval. A flight is good inside its interval and bad outside."""
    first = cell.lstrip()[:1]
    if first in STATES and not set("├┤←→─") & set(cell) and cell.strip() not in ("◎", "◆"):
        yield cell, STATES[first]
        return
    inside = any("◆" in found[0] for found in BAR.finditer(cell) if len(found[0]) > 1)
    drawn = any(len(found[0]) > 1 for found in BAR.finditer(cell))
    for part in re.split("([◎◆])", cell):
        flown = (GOOD if inside else BAD) if drawn else MARKED
        yield part, {"◎": MARKED, "◆": flown}.get(part, "")
