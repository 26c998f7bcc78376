"""The range card: a plan on one page for the check-in, with its safety checks and a map of its landing."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.flight.site import Site
from fieldkit.planning.check import ADVICE_NOTE, SafetyCheck, worst_first
from fieldkit.planning.landing import ELLIPSE_LEVEL, Landing
from fieldkit.presentation.report.style import drawn, without_markup
from fieldkit.quantities import ShownUnits
from fieldkit.safe_text import printable
from fieldkit.units import UNITS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINE = 108
"""Length of the lines of safety checks. [character]"""
NOTE_LINE, NOTE_INDENT = 60, 12
"""Length of the lines of the forecast, and the indent of those that continue one, below its text. [character]"""
TITLE_LINE, TITLE_ROW = 60, 0.02
"""Length of the lines of the title [character], and their height as a fraction of the page's height. [1]"""
FONT = 7.5
"""Size of the text; safety checks that would not fit on the page are smaller. [pt]"""
LEAST_FONT = 3.0
"""Smallest text of the safety checks, which no plan reaches. [pt]"""
CHECKS_TOP, ROW, FOOT_OF_PAGE = 0.62, 0.0113, 0.02
"""Highest position of the safety checks below the map, height of a line of text, and bottom margin, as fractions of the
page's height. [1]"""
SHOWN_LANDINGS = 200
"""Number of points on the map. [1]"""


@without_markup()
def range_card(
    words: Sequence[str], lines: Sequence[SafetyCheck], found: Landing, site: Site, suffix: str, system: str = "SI"
) -> bytes:
    """The card as a picture of a page, in the units of a system."""
    from matplotlib.figure import Figure  # takes 40 MB of the app's memory

    figure = Figure(figsize=(8.27, 11.69))
    title = fill(printable(words[0]), TITLE_LINE)
    top = 0.935 - TITLE_ROW * title.count("\n")
    figure.text(0.06, 0.965, title, fontsize=14, fontweight="bold", va="top")
    notes_below = "\n".join(_wrapped(line, NOTE_LINE, NOTE_INDENT) for line in words[1:])
    figure.text(0.06, top, notes_below, fontsize=FONT, va="top", family="monospace")
    below = min(CHECKS_TOP, top - ROW * (notes_below.count("\n") + 2))
    figure.text(0.06, below, "Safety lines", fontsize=11, fontweight="bold", va="top")
    texts = [*(line.words(system) for line in worst_first(lines)), "", ADVICE_NOTE]
    safety, size = fitted(texts, (below - 2 * ROW - FOOT_OF_PAGE) / ROW)
    figure.text(0.06, below - 2 * ROW, safety, fontsize=size, va="top", family="monospace")
    _map(figure, found, site, ShownUnits(system).length_unit)
    return drawn(figure, suffix.lstrip("."), dpi=130)


def fitted(texts: Sequence[str], rows: float) -> tuple[str, float]:
    """Texts wrapped to the width of the page, and the largest size at which they fill at most a number of rows of
    `FONT` [pt]: smaller letters leave room for longer lines."""
    for size in np.arange(FONT, LEAST_FONT, -0.25):
        wrapped = "\n".join(_wrapped(text, int(LINE * FONT / size), 4) for text in texts)
        if (wrapped.count("\n") + 1) * size <= rows * FONT:
            break
    return wrapped, float(size)


def _wrapped(text: str, width: int, indent: int) -> str:
    return fill(printable(text), width, subsequent_indent=" " * indent, drop_whitespace=True)


def _map(figure: "Figure", found: Landing, site: Site, unit: str) -> None:
    """Draw pad, landings, ellipse and field, with the wind blowing up the page; empty if the wind is unknown."""
    if found.wind is None:
        figure.text(0.79, 0.78, "No map: the wind was not given", fontsize=9, ha="center")
        return
    axes = figure.add_axes((0.63, 0.66, 0.32, 0.24))
    scale = 1 / UNITS["length"][unit].to_si(1.0)
    some = slice(SHOWN_LANDINGS)
    axes.scatter(scale * found.across[some], scale * found.along[some], s=3, color="0.5", linewidths=0)
    outline = scale * found.ellipse().outline()
    axes.plot(outline[:, 1], outline[:, 0], color="black", linewidth=1.2, label=f"{ELLIPSE_LEVEL:.0%} of landings")
    axes.plot(0, 0, marker="^", color="black", linestyle="none", label="pad")
    if site.size is not None:
        turn = np.linspace(0, 2 * np.pi, 90)
        half = scale * site.size / 2
        axes.plot(half * np.cos(turn), half * np.sin(turn), color="black", linestyle=":", linewidth=1, label="field")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"right of the wind [{unit}]", fontsize=7)
    axes.set_ylabel(f"downwind [{unit}]", fontsize=7)
    axes.tick_params(labelsize=6)
    axes.legend(fontsize=6, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
