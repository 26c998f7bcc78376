"""The pictures of flight cards and of a day, each drawn into a given figure."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.flight.event_names import event_title
from fieldkit.presentation.report.card import Card, CardForecast
from fieldkit.presentation.report.style import (
    AFTER_COLOR,
    BEFORE_COLOR,
    FAINT_COLOR,
    INK_COLOR,
    drawn,
    shortened,
    styled,
)
from fieldkit.quantities import ShownUnits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

Draw = Callable[["Figure | SubFigure"], None]
Margins = tuple[float, float, float, float]
"""Margins of a picture on the left, right, bottom and top. [inch]"""
FORECAST_MARGINS: Margins = (0.2, 0.2, 0.45, 0.24)
"""Margins of `forecast`: half a tick label at both ends of the axis, the height of tick labels with an axis title, and
of a title. [inch]"""
LOG_MARGINS: Margins = (0.85, 0.2, 0.45, 0.24)
"""Margins of `log`, with tick labels of up to six characters on the left. [inch]"""


def forecast(figure: "Figure | SubFigure", card: Card) -> None:
    """Draw the density of the forecast apogee with its 90% interval, and the flown apogee."""
    panel = figure.subplots()
    panel.set_title("Forecast and flown")
    shown = ShownUnits(card.system)
    panel.set_xlabel(f"apogee [{shown.length_unit}]")
    panel.set_yticks([])
    panel.spines["left"].set_visible(False)
    panel.grid(axis="y", visible=False)
    if card.forecast is not None:
        _hill(panel, card.forecast, shown)
    if card.flight.apogee is not None:
        flown = card.flight.apogee / shown.length_factor
        panel.axvline(flown, color=BEFORE_COLOR, linewidth=2.2)
        panel.annotate(
            f"flown {shown.length(card.flight.apogee, 1)}", (flown, 1.0), (5, -2),
            xycoords=("data", "axes fraction"), va="top", textcoords="offset points", color=BEFORE_COLOR,
            weight="bold", fontsize=9,
        )  # fmt: skip
    panel.margins(x=0.14)


def _hill(panel: "Axes", forecast: CardForecast, shown: ShownUnits) -> None:
    """Draw the density of the draws, from a normal kernel in the logarithm, hatched between 5 and 95%."""
    draws = forecast.draws[forecast.draws > 0] / shown.length_factor
    if len(draws) < 3 or np.ptp(draws) == 0:
        return
    logs = np.log(draws)
    width = 1.06 * logs.std() * len(logs) ** -0.2  # Silverman, 1986
    grid = np.linspace(logs.min() - 2 * width, logs.max() + 2 * width, 240)
    density = np.exp(-0.5 * ((grid[:, None] - logs) / width) ** 2).sum(axis=1) / np.exp(grid)
    height, place = density / density.max(), np.exp(grid)
    low, middle, high = (end / shown.length_factor for end in forecast.interval)
    panel.plot(place, height, color=AFTER_COLOR, linewidth=1.6)
    inside = (place >= low) & (place <= high)
    panel.fill_between(place[inside], height[inside], color=AFTER_COLOR, alpha=0.22, linewidth=0)
    panel.plot([middle, middle], [0, np.interp(middle, place, height)], color=AFTER_COLOR, linewidth=1.4)
    for end, side in ((low, "right"), (high, "left")):
        panel.annotate(
            f"{end:.0f} {shown.length_unit}", (end, np.interp(end, place, height)), (-4 if side == "right" else 4, 5),
            textcoords="offset points", ha=side, fontsize=8, color=AFTER_COLOR,
        )  # fmt: skip
    panel.set_ylim(0, 1.25)


def log(figure: "Figure | SubFigure", card: Card) -> None:
    """Draw height and speed against time, with a line at each event; without a log, the `record` of the rocket."""
    trace = card.trace
    if trace is None:
        record(figure, card)
        return
    tall, low = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1)) if trace.speed is not None else (
        figure.subplots(), None,
    )  # fmt: skip
    shown = ShownUnits(card.system)
    tall.plot(trace.time, trace.height / shown.length_factor, color=AFTER_COLOR, linewidth=1.4)
    tall.set_ylabel(f"height [{shown.length_unit}]")
    tall.set_title(f"The log: {shortened(trace.device, 40)}")
    if low is not None and trace.speed is not None:
        low.plot(trace.time, trace.speed / shown.speed_factor, color=INK_COLOR, linewidth=1.1)
        low.axhline(0, color=FAINT_COLOR, linewidth=0.8)
        low.set_ylabel(f"speed [{shown.speed_unit}]")
    bottom = tall if low is None else low
    bottom.set_xlabel("time [s]")
    step, last = 0, -np.inf
    span = float(trace.time[-1] - trace.time[0]) or 1.0
    for name, time in sorted(trace.events.items(), key=lambda one: one[1]):
        for panel in (tall, low):
            if panel is not None:
                panel.axvline(time, color=FAINT_COLOR, linewidth=0.9, linestyle=(0, (4, 2)))
        step = step + 1 if time - last < 0.09 * span else 0
        last = time
        tall.annotate(
            f" {event_title(name)} {time:.2f} s", (time, 0.98 - 0.08 * step), xycoords=("data", "axes fraction"),
            va="top", fontsize=7.5, color=INK_COLOR,
        )  # fmt: skip
    tall.margins(y=0.22)


def record(figure: "Figure | SubFigure", card: Card) -> None:
    """Draw every apogee of the rocket in the order flown, with this flight filled in."""
    panel = figure.subplots()
    shown = ShownUnits(card.system)
    place, record = np.arange(1, len(card.record) + 1), card.record / shown.length_factor
    panel.plot(place[card.clean], record[card.clean], "o", color=FAINT_COLOR, markersize=5, mfc="white", label="normal")
    tagged = ~card.clean
    if tagged.any():
        panel.plot(
            place[tagged], record[tagged], "x", color=FAINT_COLOR, markersize=6, label="tagged: not used in the model"
        )
    if card.place >= 0:
        panel.plot(place[card.place], record[card.place], "o", color=BEFORE_COLOR, markersize=8, label="this flight")
    panel.set_title("Flights of this rocket so far")
    panel.set_xlabel("flight, in the order flown")
    panel.set_ylabel(f"apogee [{shown.length_unit}]")
    panel.margins(x=0.05, y=0.25)
    panel.locator_params(axis="x", integer=True)
    panel.legend(loc="best", ncols=3, fontsize=8)


def forecasts_and_apogees(figure: "Figure | SubFigure", cards: Sequence[Card]) -> None:
    """Draw the forecast interval of each flight, dashed if it was computed later, and its apogee, hollow if the flight
    is not clean."""
    panel, shown = figure.subplots(), ShownUnits(cards[0].system if cards else "SI")
    names = []
    for row, card in enumerate(cards):
        names.append(shortened(f"{card.id}  {card.flight.motor}", 30))
        if card.forecast is not None:
            low, middle, high = (end / shown.length_factor for end in card.forecast.interval)
            bar = "-" if card.forecast.kept else (0, (2, 1.2))
            panel.plot([low, high], [row, row], color=AFTER_COLOR, linewidth=4, alpha=0.45, linestyle=bar)
            panel.plot(middle, row, "|", color=AFTER_COLOR, markersize=11, mew=2)
        if card.flight.apogee is not None:
            face = BEFORE_COLOR if card.flight.clean else "white"
            panel.plot(card.flight.apogee / shown.length_factor, row, "o", color=BEFORE_COLOR, mfc=face, markersize=6)
    panel.set_yticks(range(len(cards)), names)
    panel.set_ylim(len(cards) - 0.4, -0.6)
    unit = shown.length_unit
    panel.set_xlabel(f"apogee [{unit}]: bars are 90% intervals (dashed: computed later), dots are flown apogees")
    panel.grid(axis="y", visible=False)
    panel.margins(x=0.06)


def picture(draw: Draw, size: tuple[float, float], kind: str, margins: Margins | None = None) -> bytes:
    """One picture as a file of one kind; `size`, width and height, and `margins` are in inches.

    Without `margins` they are fitted to the words, which takes twice as long as the drawing.
    """
    from matplotlib.figure import Figure  # takes 0.3 s to import

    with styled():
        figure = Figure(figsize=size, layout="constrained" if margins is None else None)
        draw(figure)
        if margins is not None:
            fit(figure, margins)
        return drawn(figure, kind)


def fit(figure: "Figure", margins: Margins) -> None:
    """Let the panels of a figure fill it up to these margins."""
    (left, right, bottom, top), (width, height) = margins, figure.get_size_inches()
    figure.subplots_adjust(
        left=left / width, right=1 - right / width, bottom=bottom / height, top=1 - top / height, hspace=0.08
    )
