"""Columns of a position in space: the third axis is the height, and points up or, as in aircraft, down.

Autopilots write north, east and down (`pos_n`, `PE`, `down [m]`) or x, y and z; which way the third axis points is seen
in the flight.
"""

from collections.abc import Mapping

import numpy as np

from fieldkit.importing.tables.headings import Heading, unit_named
from fieldkit.shapes import Array, Float
from fieldkit.units import is_unit

_BESIDE_AXIS = frozenset({"pos", "position", "p", "loc", "local", "ned", "enu", "state", "m", "ft"})
"""Words beside the name of an axis."""
_POSITION = frozenset({"pos", "position"})
"""Words of a position."""
_OTHER_AXES = (({"x"}, {"y"}), ({"n", "north"}, {"e", "east"}))
"""Names of the other two axes."""
_THIRD_AXES = (frozenset({"z"}), frozenset({"d", "down", "u", "up"}))
"""Names of the third axis beside each of these pairs."""
_START, _BELOW = 11, 3.0
"""Number of first samples that show where a position starts, and how many times farther than above it a flight goes
below it if its axis points down. [1]"""


def _axis(head: Heading) -> str:
    """The axis of a position that a header names, or ""; `Z (g)` is that of an accelerometer."""
    if is_unit(head.unit) and not unit_named("length", head.unit):
        return ""
    words = [word for word in head.words if word not in _BESIDE_AXIS]
    if len(words) != 1:
        return ""
    return words[0][1] if len(words[0]) == 2 and words[0][0] == "p" else words[0]


def third_axis(heads: Mapping[int, Heading]) -> int | None:
    """The column of the third axis of a position whose other two axes are columns too, or of the only axis of one that
    says which way it points, `posD`; None if there is none."""
    axes = {axis: place for place, head in heads.items() if (axis := _axis(head))}
    for (first, second), third in zip(_OTHER_AXES, _THIRD_AXES, strict=True):
        found = axes.keys() & third
        if axes.keys() & first and axes.keys() & second and len(found) == 1:
            return axes[found.pop()]
    named = {place for axis, place in axes.items() if axis in _THIRD_AXES[1] and set(heads[place].words) & _POSITION}
    return named.pop() if len(named) == 1 else None


def is_elevation(head: Heading) -> bool:
    """Whether a header is that of the height of a track for maps: `elevation`, `ele`, or the `hMSL` of a receiver."""
    words = tuple(word for word in head.words if word not in _BESIDE_AXIS)
    return words in (("elevation",), ("ele",), ("elev",), ("h", "msl"))


def points_down(head: Heading, position: Float[Array, "row"]) -> bool:
    """Whether a column is the third axis of a position, in any unit, and goes down in the flight. [m, ft]"""
    there = position[np.isfinite(position)]
    if not there.size or not any(_axis(head) in names for names in _THIRD_AXES):
        return False
    start = float(np.median(there[:_START]))
    return start - float(there.min()) > _BELOW * max(float(there.max()) - start, 0.0)


def falls_in_a_climb(speed: Float[Array, "row"], height: Float[Array, "row"]) -> bool:
    """Whether a vertical speed is positive downward: its sum falls while the height rises to its top, in any
    units. [m/s, m]"""
    there = np.isfinite(speed) & np.isfinite(height)
    if not there.any():
        return False
    top = int(np.argmax(height[there])) + 1
    path = np.cumsum(speed[there][:top])
    return bool(path.size > _START and -path[-1] > _BELOW * float(path.max(initial=0.0)) and path[-1] < 0)
