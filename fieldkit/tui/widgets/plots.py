"""Plots in the colors of the app, by textual-plotext."""

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from operator import itemgetter
from typing import Any

import numpy as np
from rich.style import Style
from rich.text import Text
from textual.app import RenderResult
from textual.color import Color
from textual.content import Content
from textual.widget import Widget
from textual_plotext import PlotextPlot

from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Bool, Flags, Float

MAX_CELLS = 1000
"""Columns and lines of the largest plot, more than any terminal has. [cell]"""
POINT = 200
"""Points of a drawn density."""
MIN_DENSITY_FRACTION = 0.02
"""Fraction of a density's height below which nothing is drawn. [1]"""


@dataclass(frozen=True, slots=True)
class Ink:
    """Colors of a plot for plotext, RGB or "default" for the terminal's, and its size in cells."""

    width: int
    height: int
    paper: Any
    text: Any
    line: Any
    mark: Any
    dim: Any


PlotDrawing = Callable[[Any, Ink], Text | Content | None]
"""A function that draws with plotext in some colors, or returns a drawing."""


class Plot(PlotextPlot):
    """A plot that is redrawn when its size or its colors change, with the last function given to `show`."""

    DEFAULT_CSS = """
    Plot { height: 1fr; background: $surface; }
    """

    def __init__(self, **rest: Any) -> None:
        super().__init__(**rest)
        self._draw: PlotDrawing | None = None

    def show(self, draw: PlotDrawing | None) -> None:
        """Set the drawing function, called with plotext and the colors, which draws with plotext or returns a drawing;
        None clears the plot."""
        self._draw = draw
        self.refresh()

    def render(self) -> RenderResult:
        """The plot as text in the current size."""
        width, height = self.size
        if self._draw is None or width < 12 or height < 4:
            return ""
        plt, ink = self.plt, self._ink()
        with _any_terminal_size():
            plt.clear_figure()
        plt.theme("clear")
        for colour in (plt.canvas_color, plt.axes_color):
            colour(ink.paper)
        plt.ticks_color(ink.text)
        drawn = self._draw(plt, ink)
        plt.plotsize(width, height)
        return drawn or Text.from_ansi(plt.build())

    def _ink(self) -> Ink:
        names = self.app.theme_variables
        if self.app.current_theme.ansi:
            return Ink(*self.size, *["default"] * 5)
        inks = ("surface", "foreground", "primary", "accent", "border-blurred")
        return Ink(*self.size, *(Color.parse(names[name]).rgb for name in inks))


def draw_in(parent: Widget, draw: PlotDrawing | None, title: str = "", name: str | None = None) -> None:
    """Draw in the plot of a widget, or in that with a name, which is added when there first is something to draw; None
    hides it."""
    plot = next((one for one in parent.query(Plot) if name in (None, one.id)), None)
    if plot is None:
        if draw is None:
            return
        plot = Plot(id=name)
        parent.mount(plot)
    plot.display = draw is not None
    plot.border_title = Content(printable(title))
    plot.show(draw)


@contextmanager
def _any_terminal_size() -> Iterator[None]:
    """Let plots be larger than the terminal is now. plotext reads it from the environment when a plot is made, and
    never draws larger, even after the terminal has grown or if the app is served to a browser."""
    before = {name: os.environ.get(name) for name in ("COLUMNS", "LINES")}
    os.environ.update(dict.fromkeys(before, str(MAX_CELLS)))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


TICK_WIDTH = 12
"""Minimum distance of round values below a density. [cell]"""
FRAME = 3
"""Lines of a plot for its frame and the labels below it. [cell]"""
AXIS = 8
"""Maximum number of columns to the left of the axis."""


def below_line(values: Float[Array, "column"], span: float, ink: Ink) -> Float[Array, "column"]:
    """Values half a cell nearer to zero, to fill the cells below a line over a `span` without those beside it."""
    half = span / max(1, ink.height - FRAME) / 2
    return np.sign(values) * np.maximum(np.abs(values) - half, 0.0)


def filled_columns(below: Float[Array, "column"], span: float, ink: Ink) -> Bool[Flags, "column"]:
    """The columns to fill below a line over a `span`: those more than a line of the plot from zero, in runs that are
    somewhere more than two lines from it. Shallower runs would be fragments."""
    line = span / max(1, ink.height - FRAME)
    filled = np.abs(below) > line
    edges = np.flatnonzero(np.diff(filled, prepend=False, append=False))
    for start, end in edges.reshape(-1, 2):
        filled[start:end] = np.abs(below[start:end]).max() > 2 * line
    return filled


def spaced(ticks: Sequence[tuple[float, str]], low: float, high: float, width: int) -> dict[float, str]:
    """Labels below an axis that do not overlap, with priority to the first ones. plotext drops overlapping labels at
    random.
    """
    column = (width - AXIS) / max(high - low, 1e-9)
    kept: dict[float, str] = {}
    for place, text in ticks:
        room = ((len(text) + len(other)) / 2 + 2 for other in kept.values())
        if all(abs(place - other) * column >= least for other, least in zip(kept, room, strict=True)):
            kept[place] = text
    return kept


def label_flights(plt: Any, ink: Ink, ids: Sequence[str], here: int | None = None) -> None:
    """Label the flights of a plot, one at each whole number from 0, with as many of their ids as fit: first that of the
    one `here`, then the last one and the first ones."""
    last = len(ids) - 1
    order = dict.fromkeys([*([] if here is None else [here]), last, *range(last)])
    labels = spaced([(float(place), printable(ids[place])) for place in order], 0.0, float(last), ink.width)
    plt.xticks(list(labels), list(labels.values()))
    plt.xlim(-0.5, last + 0.5)


def round_ticks(low: float, high: float, most: int) -> list[float]:
    """At most `most` round values between two values: multiples of 1, 2 or 5 times a power of ten."""
    span = high - low
    if span <= 0 or most < 2:
        return [low]
    steps = (factor * 10.0 ** (math.floor(math.log10(span)) + power) for power in (-1, 0, 1) for factor in (1, 2, 5))
    for step in steps:
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        if last - first < most:
            return [round(step * n, 12) for n in range(first, last + 1)]
    return [low]


def round_axes(plt: Any, ink: Ink, across: tuple[float, float], up: tuple[float, float]) -> None:
    """Limit the axes of a plot to these values, and label round ones."""
    columns, rows = round_ticks(*across, max(3, ink.width // TICK_WIDTH)), round_ticks(*up, max(3, ink.height // 4))
    plt.xlim(*across)
    plt.ylim(*up)
    plt.xticks(columns, [f"{place:g}" for place in columns])
    plt.yticks(rows, [f"{place:g}" for place in rows])


def density(values: Float[Array, "draw"]) -> tuple[list[float], list[float]]:
    """A smooth density of the finite draws (Gaussian kernels, Silverman's rule of thumb, 1986): positions in the unit
    of the values, and heights relative to the highest [1], without those below `MIN_DENSITY_FRACTION`."""
    values = values[np.isfinite(values)]
    spread = min(values.std(), np.subtract(*np.quantile(values, [0.75, 0.25])) / 1.34) or values.std() or 1e-9
    width = 0.9 * spread * len(values) ** -0.2
    low, high = np.quantile(values, [0.002, 0.998])
    at = np.linspace(low - width, high + width, POINT)
    heights = np.exp(-0.5 * ((at[:, None] - values) / width) ** 2).sum(axis=1)
    drawn = heights > MIN_DENSITY_FRACTION * heights.max()
    return at[drawn].tolist(), (heights[drawn] / heights.max()).tolist()


@dataclass(frozen=True, slots=True)
class Marked:
    """A value drawn on the curve of a density: its symbol, and the value."""

    symbol: str
    value: float


def draw_density(
    values: Float[Array, "draw"],
    number: Callable[[float], str],
    *marks: Marked,
    former: Float[Array, "draw"] | None = None,
    ticks: Sequence[float] | None = None,
    unit: float = 1.0,
) -> Callable[[Any, Ink], Text]:
    """Draws a density: filled within its 90% interval, the tails as a dim line, the median as an unbroken line, the
    `marks` on the curve, and the density of `former` draws as an outline. `number` formats the values below it: round
    multiples of the `unit`, or those at the `ticks`, where vertical lines are drawn."""
    curve = density(values)
    before = density(former) if former is not None else ([], [])
    low, middle, high = np.nanquantile(values[np.isfinite(values)], [0.05, 0.5, 0.95]).tolist()
    tails = [y if x < low or x > high else math.nan for x, y in zip(*curve, strict=True)]
    shown = [*curve[0], *before[0], *(mark.value for mark in marks), *(ticks or ())]
    first, last = min(shown), max(shown)

    def draw(_: Any, ink: Ink) -> Text:
        canvas = Canvas(ink, first, last)
        canvas.outline(curve[0], tails, ink.dim)
        canvas.fill(*curve, low, high)
        if before[0]:
            canvas.outline(*before, ink.text)
        for place in ticks or ():
            canvas.line(place, canvas.rows, ink.text)
        canvas.line(middle, canvas.cell(middle, *curve), ink.mark)
        for mark in marks:
            canvas.put(canvas.cell(mark.value, *curve), canvas.column(mark.value), mark.symbol, ink.mark)
        most = max(3, ink.width // TICK_WIDTH)
        below = [unit * one for one in round_ticks(first / unit, last / unit, most)] if ticks is None else ticks
        return canvas.text(spaced([(place, number(place)) for place in below], first, last, ink.width))

    return draw


EIGHTHS = " ▁▂▃▄▅▆▇"
"""Cells filled from below by so many eighths."""
DOTS = ((0x40, 0x04, 0x02, 0x01), (0x80, 0x20, 0x10, 0x08))
"""Bits of the dots of a braille character from bottom to top, in its left and its right half."""
HEADROOM = 1.15
"""Height of a drawing, over that of its highest curve. [1]"""


class Canvas:
    """Cells above an axis from `first` to `last`, to draw curves on whose heights are fractions of the highest one.

    A density takes 2 ms with it. With plotext it takes 19 ms, which every step through the motors would wait for, and
    one curve makes holes in the area below another.
    """

    def __init__(self, ink: Ink, first: float, last: float) -> None:
        self.ink, self.rows = ink, ink.height - 2
        self._first, self._span = first, max(last - first, 1e-9)
        self._cells = [[(" ", Style())] * ink.width for _ in range(self.rows)]

    def column(self, value: float) -> int:
        """The column of a value."""
        return min(int((value - self._first) / self._span * self.ink.width), self.ink.width - 1)

    def cell(self, value: float, at: Sequence[float], heights: Sequence[float]) -> int:
        """The row that the curve has reached at a value, from below."""
        return min(int(np.interp(value, at, heights) * self.rows / HEADROOM), self.rows - 1)

    def put(self, row: int, column: int, character: str, color: Any) -> None:
        """Draw a character over what is there: within a filled cell as a gap of its shape."""
        style = self._cells[row][column][1]
        self._cells[row][column] = character, style if style.reverse else _inked(color)

    def line(self, value: float, rows: int, color: Any) -> None:
        """Draw a vertical line from the axis up to a row."""
        for row in range(rows):
            self.put(row, self.column(value), "│", color)

    def fill(self, at: Sequence[float], heights: Sequence[float], low: float, high: float) -> None:
        """Fill the area below a curve between two values."""
        for column in range(self.column(low), self.column(high) + 1):
            value = self._first + (column + 0.5) / self.ink.width * self._span
            eighths = round(float(np.interp(value, at, heights)) * self.rows / HEADROOM * 8)
            for row in range(eighths // 8):
                self._cells[row][column] = " ", _inked(self.ink.line, True)
            if eighths % 8:
                self._cells[eighths // 8][column] = EIGHTHS[eighths % 8], _inked(self.ink.line)

    def outline(self, at: Sequence[float], heights: Sequence[float], color: Any) -> None:
        """Draw a curve as a line of dots, two across a cell and four up."""
        places = self._first + (np.arange(2 * self.ink.width) + 0.5) / (2 * self.ink.width) * self._span
        dots = np.interp(places, at, heights, left=np.nan, right=np.nan) * self.rows / HEADROOM * 4
        bits: dict[tuple[int, int], int] = {}
        for n in np.flatnonzero(np.isfinite(dots)).tolist():
            top, before = int(dots[n]), int(dots[n - 1]) if n and np.isfinite(dots[n - 1]) else int(dots[n])
            for dot in range(min(top, before + 1), max(top, before - 1) + 1):  # no gap where it is steep
                place = dot // 4, n // 2
                bits[place] = bits.get(place, 0) | DOTS[n % 2][dot % 4]
        for (row, column), found in bits.items():
            if self._cells[row][column][0] not in EIGHTHS[1:]:  # where both curves are about as high
                self.put(row, column, chr(0x2800 + found), color)

    def text(self, labels: Mapping[float, str]) -> Text:
        """The drawing above its axis with labels."""
        axis, below = ["─"] * self.ink.width, [" "] * self.ink.width
        for value, label in labels.items():
            axis[self.column(value)] = "┬"
            start = max(0, min(self.column(value) - len(label) // 2, self.ink.width - len(label)))
            below[start : start + len(label)] = label
        drawn = [
            Text.assemble(*(("".join(sign for sign, _ in run), style) for style, run in groupby(row, itemgetter(1))))
            for row in reversed(self._cells)
        ]
        return Text("\n").join([*drawn, *(Text("".join(row), _inked(self.ink.text)) for row in (axis, below))])


@cache
def _inked(color: Any, filled: bool = False) -> Style:
    """The style of a color of `Ink`, or of a cell filled with it."""
    named = None if color == "default" else f"rgb({color[0]},{color[1]},{color[2]})"
    return Style(color=named, reverse=filled)
