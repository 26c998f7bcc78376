"""Writing reports: HTML and PDF as one file, PNG as one file per page, Markdown with its pictures next to it."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from fieldkit.errors import BadValue
from fieldkit.files import write_all
from fieldkit.presentation.report.book import FlightReport, table
from fieldkit.presentation.report.card import Card
from fieldkit.presentation.report.html import embedded, rendered
from fieldkit.presentation.report.loop.pictures import svg
from fieldkit.presentation.report.paper import FOOT_LINE, ON_THE_LOOPS_PAGE, heading, headline, pages, remarks
from fieldkit.presentation.report.pictures import (
    FORECAST_MARGINS,
    LOG_MARGINS,
    forecast,
    forecasts_and_apogees,
    log,
    picture,
)
from fieldkit.presentation.report.style import bound, drawn, styled
from fieldkit.progress import ReportProgress, no_op
from fieldkit.safe_text import as_markdown

SUFFIXES = (".html", ".htm", ".pdf", ".png", ".md")
NUMBERS = (3, 4, 5, 6, 7)
"""Numeric columns of the table of flights."""
PICTURE_WIDTH = 7.2
"""Width of pictures on a page. [inch]"""
T = TypeVar("T")


def check_report(path: Path) -> None:
    """Raise BadValue for a file name with an unsupported suffix."""
    if path.suffix.lower() not in SUFFIXES:
        raise BadValue(f"report: found {path.name!r}, expected a name that ends in {', '.join(SUFFIXES)}")


def write_report(
    book: FlightReport, path: Path, on_progress: ReportProgress = no_op, *, force: bool = False
) -> list[Path]:
    """Write a report in the format of its file name, and nothing if `check_target` rejects one of its files; returns
    their paths.

    Raises BadValue for another suffix, FieldkitError if a file cannot be written, or exists and `force` is False.
    """
    check_report(path)
    files = dict(_files(book, path, on_progress))
    write_all(files, force=force)
    return list(files)


def _files(book: FlightReport, path: Path, on_progress: ReportProgress) -> Iterator[tuple[Path, bytes]]:
    kind = path.suffix.lower()
    if kind == ".md":
        yield from _markdown(book, path, on_progress)
    elif kind in (".html", ".htm"):
        yield path, rendered("book.html", content(book, on_progress)).encode()
    else:
        with styled():
            sheets = list(pages(book))
            if kind == ".pdf":
                yield path, bound(_with_progress(sheets, on_progress))
            for number, sheet in enumerate(_with_progress(sheets, on_progress) if kind == ".png" else [], start=1):
                name = path if len(sheets) == 1 else path.with_stem(f"{path.stem}-{number}")
                yield name, drawn(sheet, "png")


def _with_progress(pages: Sequence[T], on_progress: ReportProgress) -> Iterator[T]:
    """The pages in order, each reported before it is drawn."""
    for number, page in enumerate(pages):
        on_progress(f"page {number + 1} of {len(pages)}", number / len(pages))
        yield page


def content(book: FlightReport, on_progress: ReportProgress = no_op) -> dict[str, Any]:
    """Everything that the page shows, as text and pictures."""
    headers, rows = table(book)
    return {
        "title": book.title,
        "subtitle": book.subtitle,
        "summary": book.summary,
        "figures": book.figures,
        "overview": embedded(_overview(book, "svg")) if book.summary else "",
        "headers": headers,
        "rows": rows,
        "numbers": NUMBERS,
        "findings": book.findings,
        "loops": [
            {"rocket": one.rocket, "pictures": [embedded(svg(name, one, book.system)) for name in ON_THE_LOOPS_PAGE]}
            for one in book.loops
        ],
        "cards": [_card(card) for card in _with_progress(book.cards, on_progress)],
        "foot": FOOT_LINE,
    }


def _card(card: Card) -> dict[str, Any]:
    title, subtitle = heading(card)
    return {
        "title": title,
        "subtitle": subtitle,
        "figures": headline(card),
        "forecast": embedded(_forecast(card, "svg")),
        "log": embedded(_log(card, "svg")),
        "columns": [("Readouts", card.readouts), ("Setup and conditions", card.circumstances)],
        "remarks": remarks(card),
    }


def _forecast(card: Card, kind: str) -> bytes:
    return picture(partial(forecast, card=card), (PICTURE_WIDTH, 2.2), kind, FORECAST_MARGINS)


def _log(card: Card, kind: str) -> bytes:
    return picture(partial(log, card=card), (PICTURE_WIDTH, 3.1), kind, LOG_MARGINS)


def _overview(book: FlightReport, kind: str) -> bytes:
    return picture(
        partial(forecasts_and_apogees, cards=book.cards), (PICTURE_WIDTH, 1.0 + 0.26 * len(book.cards)), kind
    )


def _markdown(book: FlightReport, path: Path, on_progress: ReportProgress) -> Iterator[tuple[Path, bytes]]:
    """The report as Markdown, with its pictures as PNG files named after it."""
    lines: list[str] = []

    def beside(name: str, content: bytes, alt: str) -> tuple[Path, bytes]:
        file = path.with_name(f"{path.stem}-{name}.png")
        lines.extend([f"![{alt}](<{file.name}>)", ""])
        return file, content

    if book.summary:
        headers, rows = table(book)
        lines += [f"# {as_markdown(book.title)}", "", as_markdown(book.subtitle), ""]
        lines += [", ".join(f"{as_markdown(value)} {what}" for value, what in book.figures) + ".", ""]
        yield beside("flights", _overview(book, "png"), "Forecast and flown")
        lines += [*_grid(headers, rows), ""]
        lines += [piece for one in book.findings for piece in (as_markdown(one), "")]
    for number, card in enumerate(_with_progress(book.cards, on_progress), start=1):
        title, subtitle = heading(card)
        lines += [f"{'##' if book.summary else '#'} {as_markdown(title)}", "", as_markdown(subtitle), ""]
        lines += [", ".join(f"{as_markdown(value)} ({what})" for value, what in headline(card)) + ".", ""]
        yield beside(f"{number}-forecast", _forecast(card, "png"), "Forecast")
        plot_title = "The log" if card.trace else "Flights of this rocket so far"
        yield beside(f"{number}-log", _log(card, "png"), plot_title)
        for name, figures in (("Readouts", card.readouts), ("Setup and conditions", card.circumstances)):
            if figures:
                lines += [*_grid((name, ""), figures), ""]
        lines += [piece for one in remarks(card) for piece in (as_markdown(one), "")]
    yield path, ("\n".join([*lines, FOOT_LINE]) + "\n").encode()


def _grid(headers: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    yield "| " + " | ".join(as_markdown(one) for one in headers) + " |"
    yield "|" + "---|" * len(headers)
    for row in rows:
        yield "| " + " | ".join(as_markdown(one) for one in row) + " |"
