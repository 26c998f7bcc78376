"""Reports as A4 pages: one card per page, after a summary; color is never the only distinction."""

from collections.abc import Iterator, Sequence
from datetime import datetime, time
from textwrap import wrap
from typing import TYPE_CHECKING

from fieldkit import __version__
from fieldkit.flight.short_name import flight_label
from fieldkit.presentation.report.book import FlightReport, table
from fieldkit.presentation.report.card import Card, CardRows
from fieldkit.presentation.report.loop.pictures import PICTURES
from fieldkit.presentation.report.pictures import forecast, forecasts_and_apogees, log
from fieldkit.presentation.report.style import A4, FAINT_COLOR, GRID_COLOR, INK_COLOR, shortened
from fieldkit.quantities import ShownUnits
from fieldkit.safe_text import printable
from fieldkit.services.findings import Findings

if TYPE_CHECKING:
    from matplotlib.figure import Figure, SubFigure

MARGIN = 0.085
"""Margin on each side of a page, as a fraction of its width. [1]"""
LEFT_EDGE, RIGHT_EDGE = 0.0, 1.0
"""Edges of the text, as fractions of the width between the margins. [1]"""
PER_PAGE = 34
"""Maximum number of flights in the table on one page. [1]"""
FOOT_LINE = f"fieldkit {__version__}. Forecasts are advice: at the field the range safety officer decides."
ON_THE_LOOPS_PAGE = ("residuals", "forward", "ladder")
"""Pictures of the loop that fit on a page of paper."""


def pages(book: FlightReport) -> Iterator["Figure"]:
    """The pages of a report."""
    if book.summary:
        yield from _summary(book)
        for found in book.loops:
            yield _loop(book, found)
    for card in book.cards:
        yield _card(card)


def _page(title: str, subtitle: str, ratios: Sequence[float]) -> tuple["Figure", list["SubFigure"]]:
    """A page with a heading and a footer, and its parts below each other."""
    from matplotlib.figure import Figure  # takes 0.3 s to import
    from matplotlib.gridspec import GridSpec

    page = Figure(figsize=A4, layout="constrained")
    grid = GridSpec(
        len(ratios) + 2, 3, figure=page, height_ratios=[0.085, *ratios, 0.03], width_ratios=[MARGIN, 1, MARGIN]
    )
    parts = [page.add_subfigure(grid[row, 1]) for row in range(len(ratios) + 2)]
    head, foot = parts[0], parts[-1]
    head.text(LEFT_EDGE, 0.52, shortened(title, 44), fontsize=21, weight="bold", va="center")
    head.text(LEFT_EDGE, 0.14, shortened(subtitle, 100), fontsize=10.5, color=FAINT_COLOR, va="center")
    _rule(head, 0.0)
    foot.text(LEFT_EDGE, 0.5, FOOT_LINE, fontsize=7.5, color=FAINT_COLOR, va="center")
    return page, parts[1:-1]


def _rule(part: "SubFigure", height: float, colour: str = INK_COLOR) -> None:
    from matplotlib.lines import Line2D

    part.add_artist(
        Line2D([LEFT_EDGE, RIGHT_EDGE], [height, height], color=colour, linewidth=0.9, transform=part.transSubfigure)
    )


def _card(card: Card) -> "Figure":
    page, (key, panel, drawn, figures, words) = _page(*heading(card), (0.075, 0.2, 0.3, 0.24, 0.09))
    _figures(key, headline(card))
    forecast(panel, card)
    log(drawn, card)
    _columns(figures, (("Readouts", card.readouts), ("Setup and conditions", card.circumstances)))
    _remarks(words, remarks(card))
    return page


def heading(card: Card) -> tuple[str, str]:
    """The flight of a card, and its time and place."""
    flight = card.flight
    when = moment_in_words(flight.date_time) if flight.date_time else "no date"
    build = " ".join(part for part in (flight.rocket, flight.config) if part)
    number = card.id.removeprefix(f"{flight.rocket}/")
    title = f"{build} · {flight_label(number)}" if build else flight_label(number, "Flight")
    return title, " · ".join(filter(None, (when, flight.site)))


def moment_in_words(moment: datetime) -> str:
    """`Friday, May 1, 2026, 10:30`; a date without a time has midnight, which is not shown."""
    day = f"{moment:%A, %B} {moment.day}, {moment.year}"
    return day if moment.time() == time() else f"{day}, {moment:%H:%M}"


def headline(card: Card) -> tuple[tuple[str, str], ...]:
    """The main figures of a card: value and title."""
    shown = ShownUnits(card.system)
    rows = [(shortened(card.flight.motor, 16) or "?", "motor")]
    if card.flight.apogee is not None:
        rows.append((shown.length(card.flight.apogee, 1), "apogee"))
    if card.forecast is not None:
        low, middle, high = card.forecast.interval
        what = "forecast" if card.forecast.kept else "computed later"
        rows.append((shown.length(middle), f"{what}, {shown.lengths(low, high)}"))
        if card.miss is not None:
            inside = low <= (card.flight.apogee or 0) <= high
            rows.append((shown.difference(card.miss), f"miss, {'inside' if inside else 'outside'} 90%"))
    return tuple(rows)


def remarks(card: Card) -> list[str]:
    """The remarks on a flight."""
    lines = []
    if card.forecast is not None:
        lines.append(card.forecast.by[:1].upper() + card.forecast.by[1:] + ".")
        lines += [f"The forecast was stale: {'; '.join(card.forecast.changes)}."] if card.forecast.changes else []
    if card.learned:
        lines.append("From this flight alone: " + ", ".join(f"{name} {value}" for name, value in card.learned) + ".")
    if card.flight.tags:
        unused = "" if card.flight.clean else " Not used in the model."
        lines.append(f"Tags: {', '.join(card.flight.tags)}.{unused}")
    if card.flight.notes:
        lines.append(f"Notes: {card.flight.notes}")
    return [printable(line) for line in lines]


def _figures(part: "SubFigure", rows: Sequence[tuple[str, str]]) -> None:
    """Draw figures in large type next to each other, with their titles below."""
    step = (RIGHT_EDGE - LEFT_EDGE) / max(len(rows), 4)
    for place, (value, what) in enumerate(rows):
        part.text(LEFT_EDGE + step * place, 0.62, value, fontsize=17, weight="bold", va="center")
        part.text(LEFT_EDGE + step * place, 0.18, what, fontsize=8.5, color=FAINT_COLOR, va="center")


def _columns(part: "SubFigure", columns: Sequence[tuple[str, CardRows]]) -> None:
    """Two lists of figures next to each other."""
    most = max((len(rows) for _, rows in columns), default=1)
    step = min(0.085, 0.86 / max(most + 1, 1))
    half = (RIGHT_EDGE - LEFT_EDGE) / 2
    for place, (title, rows) in enumerate(columns):
        left = LEFT_EDGE + place * (half + 0.02)
        right = left + half - 0.02
        part.text(left, 0.96, title, fontsize=10, weight="bold", va="center")
        for number, (name, value) in enumerate(rows, start=1):
            height = 0.96 - number * step
            part.text(left, height, name, fontsize=9, va="center")
            part.text(right, height, value, fontsize=9, va="center", ha="right")


def _remarks(part: "SubFigure", lines: Sequence[str]) -> None:
    """Draw as many sentences as fit."""
    _rule(part, 0.98, GRID_COLOR)
    fitted = [piece for line in lines for piece in wrap(line, 116)]
    if len(fitted) > 6:
        fitted = [*fitted[:5], fitted[5][:112] + " …"]
    for number, line in enumerate(fitted):
        part.text(LEFT_EDGE, 0.82 - 0.16 * number, line, fontsize=8.5, va="center")


def _summary(book: FlightReport) -> Iterator["Figure"]:
    headers, rows = table(book)
    for start in range(0, max(len(rows), 1), PER_PAGE):
        some, cards = rows[start : start + PER_PAGE], book.cards[start : start + PER_PAGE]
        first = start == 0
        tall = min(0.36, 0.06 + 0.021 * len(some))
        sentences = [piece for line in book.findings for piece in wrap(printable(line), 112)][:11] if first else []
        ratios = [0.075 if first else 0.01, tall + 0.02, 0.026 * (len(some) + 1), 0.018 * len(sentences) + 0.02]
        rest = max(0.885 - sum(ratios), 0.001)
        page, (key, picture, grid, words, _) = _page(book.title, book.subtitle, (*ratios, rest))
        if first:
            _figures(key, book.figures)
        forecasts_and_apogees(picture, cards)
        _table(grid, headers, some)
        for number, line in enumerate(sentences):
            words.text(LEFT_EDGE, 1 - (number + 1) / (len(sentences) + 1), line, fontsize=9, va="center")
        yield page


def _table(part: "SubFigure", headers: Sequence[str], rows: Sequence[tuple[str, ...]]) -> None:
    """Draw a table of texts, with numbers right-aligned."""
    places = (0.0, 0.1, 0.27, 0.445, 0.555, 0.675, 0.76, 0.835, 0.85)
    right = (3, 4, 5, 6, 7)
    step = 1 / (len(rows) + 1)
    for number, row in enumerate([tuple(headers), *rows]):
        height = 1 - (number + 0.5) * step
        for column, cell in enumerate(row):
            part.text(
                LEFT_EDGE + places[column] * (RIGHT_EDGE - LEFT_EDGE), height, shortened(cell, 18),
                fontsize=8.2, va="center",
                ha="right" if column in right else "left", weight="bold" if number == 0 else "normal",
            )  # fmt: skip
        _rule(part, height - step / 2, INK_COLOR if number == 0 else GRID_COLOR)


def _loop(book: FlightReport, found: Findings) -> "Figure":
    """The loop's pictures of one rocket."""
    sizes = [PICTURES[name][1][1] for name in ON_THE_LOOPS_PAGE]
    page, parts = _page(f"What the loop finds: {shortened(found.rocket, 20)}", book.title, [s / 12.5 for s in sizes])
    for part, name in zip(parts, ON_THE_LOOPS_PAGE, strict=True):
        PICTURES[name][0](part, found, ShownUnits(book.system))
    return page
