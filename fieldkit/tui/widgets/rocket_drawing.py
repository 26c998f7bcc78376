"""A rocket from the side in solid cells, nose to the right, to scale if its dimensions are known."""

from math import sqrt

SKETCHED_FINENESS = 12.0
"""Assumed ratio of length to diameter if the length is unknown, typical of model rockets. [1]"""
NOSE_CALIBERS, FIN_CALIBERS, SPAN_CALIBERS = 3.0, 1.3, 0.9
"""Lengths of a sketched nose, fin root and fin span, in diameters. [1]"""
MIN_RADIUS = 1.0
"""Minimum half height of the drawn body. [pixel]"""
POINT = 0.51
"""Half height of the tip of the nose: one pixel on each side of the axis. [pixel]"""
CELLS = {(False, False): " ", (True, False): "▀", (False, True): "▄", (True, True): "█"}
"""Characters with two pixels above each other."""


def drawing(length: float | None, diameter: float, width: int) -> list[str]:
    """The lines of a drawing of a rocket with a length and a diameter [m], `width` cells wide. A pixel is one cell wide
    and half a cell high, which is about square."""
    calibers = length / diameter if length else SKETCHED_FINENESS
    radius = max(MIN_RADIUS, width / calibers / 2)
    pixel = 2 * radius
    span = SPAN_CALIBERS * pixel
    half = round(radius + span)
    heights = [_half_height(x, width, radius, pixel, span) for x in range(width)]
    rows = range(-half - half % 2, half + half % 2, 2)
    return [
        line for y in rows if (line := "".join(CELLS[_inside(y, top), _inside(y + 1, top)] for top in heights).rstrip())
    ]


def _inside(y: int, top: float) -> bool:
    """Whether the middle of a pixel lies within a half height about the axis."""
    return abs(y + 0.5) < top


def _half_height(x: int, width: int, radius: float, pixel: float, span: float) -> float:
    """Half height of a rocket at a distance from its tail: body, elliptic nose, swept fins. [pixel]"""
    nose, fins = min(NOSE_CALIBERS * pixel, width / 2), min(FIN_CALIBERS * pixel, width / 3)
    from_tip = width - x - 0.5
    body = radius * sqrt(max(0.0, 1 - (1 - from_tip / nose) ** 2)) if from_tip < nose else radius
    fin = radius + span * (1 - (x + 0.5) / fins) ** 0.7 if x + 0.5 < fins else 0.0
    return max(body, fin, POINT)


def centers(cg: float, cp: float, width: int) -> str:
    """A line below a drawing with marks at the centers of gravity and of pressure, at fractions of the length from the
    tip [1]: `CP ▲    ▲ CG`."""
    places = sorted((round((1 - at) * (width - 1)), name) for at, name in ((cg, "CG"), (cp, "CP")))
    (left, behind), (right, ahead) = places
    between = "▲ " if left == right else "▲" + " " * (right - left - 1) + "▲ "
    return f"{f'{behind} ':>{left}}{between}{ahead}"


def caption(length: float | None) -> str:
    """The note below a drawing that is not to scale; empty if the length [m] is known."""
    return "" if length else "a sketch: import its .ork file for its length"
