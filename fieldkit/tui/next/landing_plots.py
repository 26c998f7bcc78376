"""The landing of a plan: draws of its flight from the side, and their landings on the field from above."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from fieldkit.planning.planned_flight import PlannedFlight
from fieldkit.quantities import number, spelled, unit_of
from fieldkit.tui.next.answer import Answer
from fieldkit.tui.widgets import cards

DRAWN_FLIGHTS = 30
"""Number of draws with lines from pad to apogee to landing. [1]"""
DRAWN_LANDINGS = 200
"""Number of draws with a dot at the landing. [1]"""
CIRCLE = 90
"""Points of the outline of a field. [1]"""
CELL_ASPECT = 2.0
"""Aspect ratio of a terminal's cell, height over width. [1]"""


def of_landing(answer: Answer, one: PlannedFlight, size: float | None, system: str) -> Answer:
    """The answer with both pictures; `size` is of the field across. [m]"""
    unit = spelled(unit_of(cards.APOGEE, system))
    field = ", circle the field" if size else ""
    title = (
        f"{DRAWN_FLIGHTS} draws from the side, pad to apogee to landing; and landings from above, wind to the right: "
    )
    title += f"▲ pad, ellipse 90% of them{field} [{unit}]"
    scaled = partial(_scaled, system)
    return replace(
        answer, title=title, draw=partial(_from_the_side, one, scaled), second=partial(_from_above, one, size, scaled)
    )


def _from_the_side(one: PlannedFlight, scaled: Callable[[float], float], plt: Any, ink: Any) -> None:
    """Draw pad, apogee and landing of some draws, joined by straight lines."""
    prediction, down = one.prediction, one.down
    drift = np.broadcast_to(np.nan_to_num(prediction.drift), prediction.apogee.shape)
    for row in range(min(DRAWN_FLIGHTS, len(prediction.apogee))):
        up, end = scaled(float(drift[row])), scaled(float(down.along[row]))
        plt.plot([0.0, up, end], [0.0, scaled(float(prediction.apogee[row])), 0.0], marker="braille", color=ink.line)
    plt.scatter([0.0], [0.0], marker="▲", color=ink.mark)
    plt.xfrequency(5)
    plt.yfrequency(4)


def _from_above(one: PlannedFlight, size: float | None, scaled: Callable[[float], float], plt: Any, ink: Any) -> None:
    """Draw landings, their ellipse and the field around the pad, with equal scales on the screen."""
    down = one.down
    along, across = ([scaled(float(x)) for x in part[:DRAWN_LANDINGS]] for part in (down.along, down.across))
    outline = [[scaled(float(x)) for x in column] for column in down.ellipse().outline().T]
    turn = np.linspace(0, 2 * np.pi, CIRCLE)
    radius = scaled(size / 2) if size else 0.0
    field = [(radius * np.cos(turn)).tolist(), (radius * np.sin(turn)).tolist()]
    plt.scatter(along, across, marker="·", color=ink.text)
    plt.plot(*outline, marker="braille", color=ink.line)
    if size:
        plt.plot(*field, marker="braille", color=ink.mark)
    plt.scatter([0.0], [0.0], marker="▲", color=ink.mark)
    xs, ys = [*along, *outline[0], *field[0], 0.0], [*across, *outline[1], *field[1], 0.0]
    middle = [(min(one) + max(one)) / 2 for one in (xs, ys)]
    half = max((max(xs) - min(xs)) / 2 * ink.height * CELL_ASPECT / ink.width, (max(ys) - min(ys)) / 2) * 1.05
    wide = half * ink.width / (ink.height * CELL_ASPECT)
    plt.xlim(middle[0] - wide, middle[0] + wide)
    plt.ylim(middle[1] - half, middle[1] + half)
    plt.xfrequency(5)
    plt.yfrequency(4)


def _scaled(system: str, height: float) -> float:
    """A length [m] in the units in which apogees are shown."""
    return float(number(cards.APOGEE, abs(height), system)) * (1 if height >= 0 else -1)
