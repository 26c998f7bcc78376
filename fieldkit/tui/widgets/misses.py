"""The misses of a rocket's flights as a trend."""

from collections.abc import Sequence
from typing import Any

from fieldkit.quantities import number
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.plots import Ink, label_flights, round_ticks

MAX_DRAWN = 40
"""Number of latest misses that are drawn. [1]"""


def draw_misses(missed: Sequence[tuple[str, float]], here: str | None, system: str, plt: Any, ink: Ink) -> None:
    """Draw the miss [m] of each flight, by its id in the order flown, as a point around the line of no miss, the flight
    `here` marked, ids below."""
    missed = missed[-MAX_DRAWN:]
    scale = float(number(cards.APOGEE, 1000.0, system)) / 1000.0
    values = [miss * scale for _, miss in missed]
    plt.hline(0.0, color=ink.dim)
    for place, value in enumerate(values):
        plt.plot([place, place], [0.0, value], marker="│", color=ink.dim)
    plt.scatter(list(range(len(values))), values, marker="●", color=ink.line)
    marked = [place for place, (id, _) in enumerate(missed) if id == here]
    if marked:
        plt.scatter(marked, [values[place] for place in marked], marker="◆", color=ink.mark)
    label_flights(plt, ink, [id for id, _ in missed], marked[0] if marked else None)
    at = round_ticks(min(0.0, *values), max(0.0, *values), max(3, ink.height // 3))
    plt.yticks(at, [f"{value:+g}" if value else "0" for value in at])
