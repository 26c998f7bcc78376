"""States of figures by their symbols, and the colors of the theme that repeat them: none is shown by color alone."""

import re
from collections.abc import Iterator, Mapping

GOOD_COLOR, CAUTION_COLOR, BAD_COLOR, MARK_COLOR = "success", "warning", "error", "accent"
"""The colors of a theme for states."""
STATES: Mapping[str, str] = {
    "✓": GOOD_COLOR,
    "◎": GOOD_COLOR,
    "!": CAUTION_COLOR,
    "?": CAUTION_COLOR,
    "≈": CAUTION_COLOR,
    "⊘": BAD_COLOR,
    "✗": BAD_COLOR,
    "◆": MARK_COLOR,
}
"""Symbols with their color: on target or passed, caution or provisional, not possible, flown."""
BAR_SIGNS = frozenset(" ◆◎├┤←→─●◉")
"""The signs of which a drawn interval consists."""
BAR = re.compile(r"[├←][─●◉◎◆]*[┤→]")
"""An interval drawn as a bar."""


def runs(cell: str, *, aims: bool = False) -> Iterator[tuple[str, str]]:
    """A cell in parts, each with the color of its state, empty for none: all of a text after a symbol, or the marks of
    an interval. A flight is good inside its interval, and asks for caution outside; a target, which marks are
    if a cell `aims`, is good inside."""
    if BAR_SIGNS.issuperset(cell):
        found = BAR.search(cell)
        flown = MARK_COLOR if found is None else GOOD_COLOR if "◆" in found[0] else CAUTION_COLOR
        met = GOOD_COLOR if aims and found is not None and not {"◎", "◉"}.isdisjoint(found[0]) else MARK_COLOR
        for part in re.split("([◎◉◆])", cell):
            yield part, {"◎": met, "◉": met, "◆": flown}.get(part, "")
    else:
        yield cell, STATES.get(cell.lstrip()[:1], "")
