"""The table of finals as one printed card, a picture or a page, large enough to read in bright sun."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from textwrap import fill

from matplotlib.figure import Figure

from fieldkit.errors import BadValue
from fieldkit.presentation.finals_text import FINALS_NOTES, finals_headers

LINE = 110
"""Length of the lines of notes. [character]"""
SUFFIXES = (".png", ".pdf", ".svg")


def check_card(file: Path) -> None:
    """Raise BadValue for a file name without a picture suffix."""
    if file.suffix.lower() not in SUFFIXES:
        raise BadValue(f"{file.name}: found {file.suffix or 'no suffix'!r}, expected one of {', '.join(SUFFIXES)}")


def finals_card(
    heading: Sequence[str],
    rows: Sequence[Sequence[str]],
    suffix: str,
    notes: Sequence[str] = (),
    system: str = "SI",
) -> bytes:
    """The card as a picture, with masses in the units of a system and `notes` at the end."""
    below = "\n".join(fill(line, LINE) for line in [*heading[1:], *FINALS_NOTES, *notes])
    height = 0.8 + 0.32 * len(rows) + 0.15 * len(below.splitlines())
    figure = Figure(figsize=(7.5, height), layout="constrained")
    axes = figure.add_subplot()
    axes.set_axis_off()
    figure.suptitle(heading[0], fontsize=12, fontweight="bold", x=0.02, ha="left")
    headers = list(finals_headers(system))
    table = axes.table(cellText=[list(row) for row in rows], colLabels=headers, loc="center", cellLoc="center")
    table.auto_set_font_size(False)
    table.set_fontsize(11)
    table.scale(1.0, 1.5)
    for (row, _), cell in table.get_celld().items():
        cell.set_linewidth(0.6)
        if row == 0:
            cell.set_text_props(fontweight="bold")
            cell.set_facecolor("0.9")
    figure.supxlabel(below, fontsize=8, x=0.02, ha="left")
    content = BytesIO()
    figure.savefig(content, format=suffix.lstrip("."), dpi=150)
    return content.getvalue()
