"""The style of every picture and printed page, and writing them to files.

Colors are those of Okabe and Ito, distinct with color blindness and in gray; names from files are never parsed as
markup.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, filterwarnings

from fieldkit.safe_text import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK_COLOR, FAINT_COLOR, GRID_COLOR = "#1b1f24", "#6b7280", "#e5e7eb"
BEFORE_COLOR, AFTER_COLOR = "#d55e00", "#0072b2"
STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": FAINT_COLOR,
    "axes.labelcolor": INK_COLOR,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GRID_COLOR,
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "text.color": INK_COLOR,
    "xtick.color": INK_COLOR,
    "ytick.color": INK_COLOR,
    "legend.frameon": False,
    "svg.hashsalt": "fieldkit",
    "figure.facecolor": "white",
}
A4 = (8.27, 11.69)
"""Width and height of a page. [inch]"""
METADATA: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": "fieldkit"},
    "png": {"Software": "fieldkit"},
    "pdf": {"Creator": "fieldkit", "Producer": "fieldkit", "CreationDate": None},
}
"""Metadata of files, the same in every run."""


@contextmanager
def styled() -> Iterator[None]:
    """Draw in this style."""
    from matplotlib import rc_context  # takes 0.3 s to import, as everywhere below

    with rc_context({**STYLE}), without_markup():
        yield


@contextmanager
def without_markup() -> Iterator[None]:
    """Draw text from files as it is: a `$` begins no formula, and a character that the font lacks is a box."""
    from matplotlib import rc_context

    with rc_context({"text.parse_math": False}), catch_warnings():
        filterwarnings("ignore", message="Glyph .* missing")
        yield


def drawn(figure: "Figure", kind: str, dpi: int = 150) -> bytes:
    """A figure as a file of one kind: svg (letters as shapes), png or pdf."""
    out = BytesIO()
    figure.savefig(out, format=kind, dpi=dpi, metadata=METADATA[kind])
    return out.getvalue()


def bound(pages: Iterable["Figure"]) -> bytes:
    """Figures as the pages of one PDF."""
    from matplotlib.backends.backend_pdf import PdfPages  # takes 0.08 s more

    out = BytesIO()
    with PdfPages(out, metadata=METADATA["pdf"]) as book:
        for page in pages:
            book.savefig(page)
    return out.getvalue()


def shortened(text: str, most: int = 24) -> str:
    """A name from a file, shortened for a picture."""
    text = printable(text)
    return text if len(text) <= most else text[: most - 1] + "…"
