"""The quality of forecasts as a picture: PITs, coverage, and rivals."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.errors import BadValue
from fieldkit.files import write
from fieldkit.forecast.evaluation.comparison import ScoreReport
from fieldkit.forecast.evaluation.rivals import LABELS
from fieldkit.presentation.report.style import AFTER_COLOR, BEFORE_COLOR, FAINT_COLOR, INK_COLOR, drawn, styled
from fieldkit.quantities import counted
from fieldkit.scoring.proper_scores import BINS, calibration, pit
from fieldkit.services.scores import LedgerScores

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

SUFFIXES = (".png", ".svg", ".pdf")
CURVE = tuple(float(level) for level in np.linspace(0.1, 0.95, 18))
"""Nominal coverages at which the reliability curve is drawn. [1]"""


def check_picture(path: Path) -> None:
    """Raise BadValue for a file name without a picture suffix."""
    if path.suffix.lower() not in SUFFIXES:
        raise BadValue(f"--out: found {path.name!r}, expected a name that ends in {', '.join(SUFFIXES)}")


def write_picture(found: LedgerScores, path: Path, *, force: bool = False) -> None:
    """Draw each available report as a row of three pictures, to a file of the type of its suffix.

    Raises BadValue for another suffix, FieldkitError if the file cannot be written, or exists and `force` is False.
    """
    from matplotlib.figure import Figure  # takes 0.3 s to import

    check_picture(path)
    reports = {"saved forecasts": found.saved, "replayed forward in time": found.later, "first flights": found.first}
    there = {title: report for title, report in reports.items() if report and report.rows}
    with styled():
        figure = Figure(figsize=(8.27, 3.1 * len(there)), layout="constrained")
        parts = figure.subfigures(len(there), 1, squeeze=False)[:, 0]
        for part, (title, report) in zip(parts, there.items(), strict=True):
            part.suptitle(
                f"{title}: {counted(len(report.rows), 'flight')}", fontsize=11, weight="bold", x=0.02, ha="left"
            )
            draw(part, report)
        write(path, drawn(figure, path.suffix.lower()[1:]), force=force)


def draw(figure: "Figure | SubFigure", report: ScoreReport) -> None:
    """Draw the three pictures of one report."""
    place, held, rivals = figure.subplots(1, 3, width_ratios=(1, 1, 1.15))
    _pits(place, report)
    _reliability(held, report)
    _rivals(rivals, report)


def _pits(panel: "Axes", report: ScoreReport) -> None:
    found = report.calibration
    even = sum(found.counts) / BINS
    panel.axhspan(*found.expected, color=FAINT_COLOR, alpha=0.18, linewidth=0, label="by chance")
    panel.axhline(even, color=INK_COLOR, linewidth=1)
    panel.bar((np.arange(BINS) + 0.5) / BINS, found.counts, width=0.9 / BINS, color=AFTER_COLOR)
    panel.set_title("where flights fell in their forecasts")
    panel.set_xlabel("fraction of the forecast below the flight")
    panel.set_ylabel("flights")
    panel.set_xlim(0, 1)
    panel.locator_params(axis="y", integer=True)
    panel.legend(loc="upper right", fontsize=7)


def _reliability(panel: "Axes", report: ScoreReport) -> None:
    pits = [pit(row.draws, row.flown) for row in report.rows]
    curve = calibration(pits, CURVE).intervals
    low, high = np.array([one.expected for one in curve]).T
    panel.fill_between(CURVE, low, high, color=FAINT_COLOR, alpha=0.18, linewidth=0)
    panel.plot([0, 1], [0, 1], color=INK_COLOR, linewidth=1)
    panel.plot(CURVE, [one.held for one in curve], "o-", color=AFTER_COLOR, markersize=3.5, linewidth=1.5)
    panel.set_title("interval coverage")
    panel.set_xlabel("nominal coverage")
    panel.set_ylabel("observed coverage")
    panel.set_xlim(0, 1)
    panel.set_ylim(0, 1.02)


def _rivals(panel: "Axes", report: ScoreReport) -> None:
    rows = range(len(report.against))
    for row, one in zip(rows, report.against, strict=True):
        low, high = (100 * end for end in one.error.interval)
        colour = {"better": AFTER_COLOR, "worse": BEFORE_COLOR}.get(one.verdict, FAINT_COLOR)
        panel.plot([low, high], [row, row], color=colour, linewidth=4, alpha=0.5, solid_capstyle="butt")
        panel.plot(100 * one.error.less, row, "o", color=colour, markersize=6)
        panel.annotate(
            one.verdict, (100 * one.error.less, row), (0, 8), textcoords="offset points", ha="center", fontsize=8
        )
    panel.axvline(0, color=INK_COLOR, linewidth=1)
    panel.set_yticks(list(rows), [LABELS[one.rival] for one in report.against])
    panel.set_ylim(len(report.against) - 0.5, -0.6)
    panel.margins(x=0.15)
    panel.set_title("against rivals")
    panel.set_xlabel("reduction of mean error [% of apogee]")
    panel.grid(axis="y", visible=False)
