"""The table of finals as one printed card, a picture or a page, large enough to read in bright sun."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from fieldkit.errors import BadValue
from fieldkit.presentation.finals_text import FINALS_NOTES
from fieldkit.presentation.report.style import drawn, without_markup
from fieldkit.safe_text import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH, MARGIN = 7.5, 0.25
"""Width and margin of the card. [inch]"""
TITLE, DAY_ROW, ROW, NOTE_ROW = 0.32, 0.18, 0.29, 0.145
"""Heights of a line of the title, of a line of the day's air, of a row of the table, and of a line of notes. [inch]"""
DAY_LINE, LINE = 95, 110
"""Lengths of the lines of the day's air, and of notes. [character]"""
TITLE_LINE = 60
"""Length of the lines of the title. [character]"""
SUFFIXES = (".png", ".pdf", ".svg")


def check_card(file: Path) -> None:
    """Raise BadValue for a file name without a picture suffix."""
    if file.suffix.lower() not in SUFFIXES:
        raise BadValue(f"{file.name}: found {file.suffix or 'no suffix'!r}, expected one of {', '.join(SUFFIXES)}")


@without_markup()
def finals_card(
    heading: Sequence[str],
    headers: Sequence[str],
    rows: Sequence[Sequence[str]],
    suffix: str,
    notes: Sequence[str] = (),
) -> bytes:
    """The card as a picture, with `notes` at the end."""
    from matplotlib.figure import Figure  # takes 40 MB of the app's memory

    first, *others = map(printable, heading)
    day = [fill(line, DAY_LINE) for line in others]
    below = [fill(printable(line), LINE) for line in [*FINALS_NOTES, *notes]]
    title = fill(first, TITLE_LINE)
    heights = TITLE * _lines([title]), DAY_ROW * _lines(day), ROW * (len(rows) + 1), NOTE_ROW * _lines(below)
    height = sum(heights) + 2 * MARGIN
    figure = Figure(figsize=(WIDTH, height))
    left, top = MARGIN / WIDTH, 1 - MARGIN / height
    figure.text(left, top, title, fontsize=13, fontweight="bold", va="top")
    figure.text(left, top - heights[0] / height, "\n".join(day), fontsize=9.5, va="top")
    bottom = top - sum(heights[:3]) / height
    axes = figure.add_axes((left, bottom, 1 - 2 * left, heights[2] / height))
    axes.set_axis_off()
    _draw_table(axes, headers, rows)
    figure.text(left, bottom - 0.5 * MARGIN / height, "\n".join(below), fontsize=8, va="top")
    return drawn(figure, suffix.lstrip("."))


def _lines(texts: Sequence[str]) -> int:
    """The number of lines of wrapped texts."""
    return sum(text.count("\n") + 1 for text in texts)


def _draw_table(axes: "Axes", headers: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Fill axes with a table, headers bold on gray."""
    from matplotlib.transforms import Bbox

    cells = [list(row) for row in rows]
    table = axes.table(cellText=cells, colLabels=list(headers), bbox=Bbox.unit(), cellLoc="center")
    table.auto_set_font_size(False)
    table.set_fontsize(11)
    for (row, _), cell in table.get_celld().items():
        cell.set_linewidth(0.6)
        if row == 0:
            cell.set_text_props(fontweight="bold")
            cell.set_facecolor("0.9")
