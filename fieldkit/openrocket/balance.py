"""The static margin of a design: center of pressure and of gravity from its parts, with a loaded motor.

Derivation: the normal force of a slender body at a small angle is 2 (A_aft - A_fore) / A_ref per radian, at
(L A_aft - V) / (A_aft - A_fore) behind its front (Barrowman 1967, from slender body theory); a fin has
2 pi s^2 / A_ref / (1 + sqrt(1 + (s^2 / (A cos G))^2)) per radian (Diederich's planform correlation), at the quarter of
its mean aerodynamic chord, times 1 + r / (s + r) for the body it is on; N fins count as N / 2. For a trapezoid this is
Barrowman's formula. All lengths are in m from the tip of the nose. Body lift at large angles, pods, boosters, tube fins
and launch lugs are not included.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.openrocket.parts import (
    Size,
    airframe,
    children,
    fin_points,
    number,
    outer_profile,
    override,
    own_mass,
    sizes,
)
from fieldkit.shapes import Array

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

FINS = ("trapezoidfinset", "ellipticalfinset", "freeformfinset")
STRIPS = 200
"""Strips of a fin along its span. [1]"""
UNMODELED = ("podset", "parallelstage", "tubefinset")
"""Parts whose normal force is not computed; a design with one has no margin from its parts."""


@dataclass(frozen=True, slots=True)
class Balance:
    """Center of pressure at small angles [m], mass without motors [kg] and its center [m], and the aft end of the
    motor mount [m], all from the tip of the nose."""

    cp: float
    dry_mass: float
    dry_cg: float
    mount_end: float | None

    def cg(self, motor_mass: float, motor_length: float, dry_mass: float | None = None) -> float | None:
        """Center of gravity with a loaded motor [kg], [m], whose own is taken at its middle; with the `dry_mass` [kg]
        as weighed if given. None without a motor mount. [m]"""
        if self.mount_end is None:
            return None
        structure = dry_mass or self.dry_mass
        moment = structure * self.dry_cg + motor_mass * (self.mount_end - motor_length / 2)
        return moment / (structure + motor_mass)


def balance(stages: "Sequence[Element]", diameter: float) -> Balance | None:
    """The balance of a rocket with one stage on a reference diameter [m]; None if a part is not modeled, no part has
    mass, or nothing has lift."""
    if len(stages) != 1 or diameter <= 0:
        return None
    parts = airframe(stages[0])
    placed, front = [], 0.0
    for part, size in zip(parts, sizes(parts), strict=True):
        placed.append((part, size, front))
        front += size.length
    if any(one.tag in UNMODELED for part, *_ in placed for one, *_ in _inside(part, 0.0, 0.0)):
        return None
    area = math.pi / 4 * diameter**2
    lifts = [_body_lift(part, size, at, area) for part, size, at in placed]
    lifts += [
        _fin_lift(one, at, size.aft, area)
        for part, size, front in placed
        for one, at, _ in _inside(part, front, size.length)
        if one.tag in FINS
    ]
    total = sum(force for force, _ in lifts)
    weights = [one for part, size, front in placed for one in _weights(part, size, front)]
    parts_mass = sum(own for own, _ in weights)
    whole, below = override(stages[0])
    dry = whole if whole and below else parts_mass
    entered = number(stages[0], "overridecg", math.nan)
    if total <= 0 or dry <= 0 or (parts_mass <= 0 and math.isnan(entered)):
        return None
    cp = sum(force * at for force, at in lifts) / total
    center = sum(own * at for own, at in weights) / parts_mass if math.isnan(entered) else entered
    return Balance(cp, dry, center, _mount_end(placed))


def _body_lift(part: "Element", size: Size, front: float, area: float) -> tuple[float, float]:
    """Normal force per radian [1] of a part of the airframe, and its place. [m]"""
    fore, aft = math.pi * size.fore**2, math.pi * size.aft**2
    if abs(aft - fore) < 1e-9 or size.length <= 0:
        return 0.0, front
    volume = float(np.pi * (outer_profile(part, size) ** 2).mean() * size.length)
    return 2 * (aft - fore) / area, front + (size.length * aft - volume) / (aft - fore)


def _fin_lift(part: "Element", front: float, radius: float, area: float) -> tuple[float, float]:
    """Normal force per radian [1] of a set of fins on a body of a radius [m], and its place. [m]"""
    edge, chord, span = _planform(part)
    planform = float(chord.mean() * span)
    if planform <= 0:
        return 0.0, front
    along = (np.arange(STRIPS) + 0.5) / STRIPS * span
    middle = edge + chord / 2
    slope = float(np.polyfit(along, middle, 1, w=np.sqrt(chord))[0])
    lifting = span**2 / (planform * math.cos(math.atan(slope)))
    force = 2 * math.pi * span**2 / area / (1 + math.sqrt(1 + lifting**2))
    count = max(number(part, "fincount", number(part, "instancecount", 1.0)), 1.0) / 2
    quarter = float((chord * (edge + chord / 4)).sum() / chord.sum())
    # strips of equal width: the mean aerodynamic chord is sum(c^2) / sum(c), and its leading edge sum(c x) / sum(c)
    return count * force * (1 + radius / (span + radius)), front + quarter


def _planform(part: "Element") -> tuple[Array, Array, float]:
    """Leading edge behind the front of the root and chord of each strip of a fin, and its span. [m]"""
    root, span = number(part, "rootchord"), number(part, "height")
    along = (np.arange(STRIPS) + 0.5) / STRIPS
    if part.tag == "trapezoidfinset":
        chord = np.maximum(root + (number(part, "tipchord") - root) * along, 0.0)
        return number(part, "sweeplength") * along, chord, span
    if part.tag == "ellipticalfinset":
        chord = max(root, 0.0) * np.sqrt(1 - along**2)
        return (root - chord) / 2, chord, span
    points = np.array(fin_points(part))
    if len(points) < 3 or points[:, 1].max() <= 0:
        return np.zeros(STRIPS), np.zeros(STRIPS), 0.0
    span = float(points[:, 1].max())
    ends = [_crossings(points, y) for y in along * span]
    return np.array([low for low, _ in ends]), np.array([high - low for low, high in ends]), span


def _crossings(points: Array, y: float) -> tuple[float, float]:
    """The first and the last place at which the outline of a fin crosses a line along the body. [m]"""
    found = []
    for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
        if (a[1] - y) * (b[1] - y) <= 0 and a[1] != b[1]:
            found.append(a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]))
    return (float(min(found)), float(max(found))) if found else (0.0, 0.0)


def _inside(part: "Element", front: float, length: float) -> "Iterator[tuple[Element, float, float]]":
    """Everything in or on a part whose front is at a place and has a length: each with its front and length. [m]"""
    for one in children(part):
        own = _length(one)
        at = front + _offset(one, length, own) if _method(one) != "absolute" else _value(one)
        yield one, at, own
        yield from _inside(one, at, own)


def _length(part: "Element") -> float:
    """Length of a part along the body. [m]"""
    if part.tag in FINS:
        if part.tag == "freeformfinset":
            return max((x for x, _ in fin_points(part)), default=0.0)
        return number(part, "rootchord")
    return number(part, "length") or number(part, "packedlength")


def _method(part: "Element") -> str:
    """How the place of a part is stated: from the top, the middle or the bottom of its parent, or after it."""
    for name, key in (("axialoffset", "method"), ("position", "type")):
        if (found := part.find(name)) is not None:
            return found.get(key, "top")
    return "top"


def _value(part: "Element") -> float:
    return number(part, "axialoffset", number(part, "position"))


def _offset(part: "Element", parent: float, own: float) -> float:
    """Front of a part behind the front of its parent, by the lengths of both. [m]"""
    starts = {"top": 0.0, "middle": (parent - own) / 2, "bottom": parent - own, "after": parent}
    return starts.get(_method(part), 0.0) + _value(part)


def _weights(part: "Element", size: Size, front: float) -> Iterator[tuple[float, float]]:
    """Mass [kg] and place [m] of a part of the airframe and of everything in it. A mass that was entered for both
    together is at the center of the computed ones, unless their center was entered as well."""
    entered, below = override(part)
    center, of_all = _entered_center(part)
    shell = own_mass(part, size, []) if entered is None or below else entered
    every = [(shell, front + (_shell_center(part, size) if center is None else center))]
    for one, at, length in _inside(part, front, size.length):
        own, _ = _entered_center(one)
        every.append((_own(one), at + (length / 2 if own is None else own)))
    total = sum(one for one, _ in every)
    if center is not None and of_all:
        yield (entered if entered is not None and below else total), front + center
    elif entered is not None and below:
        yield entered, sum(one * at for one, at in every) / total if total > 0 else front + size.length / 2
    else:
        yield from every


def _entered_center(part: "Element") -> tuple[float | None, bool]:
    """The center of gravity that the designer entered, behind the front of a part [m], and whether it is also that of
    everything inside."""
    entered = number(part, "overridecg", math.nan)
    if math.isnan(entered):
        return None, False
    below = part.findtext("overridesubcomponentscg") or part.findtext("overridesubcomponents") or "false"
    return entered, below.strip() == "true"


def _own(part: "Element") -> float:
    """Mass of a part without what is in it. [kg]"""
    entered, _ = override(part)
    return own_mass(part, None, []) if entered is None else entered


def _shell_center(part: "Element", size: Size) -> float:
    """Center of a wall of even thickness behind the front of a part. [m]"""
    outer = outer_profile(part, size)
    along = (np.arange(len(outer)) + 0.5) / len(outer) * size.length
    return float((outer * along).sum() / outer.sum()) if outer.sum() > 0 else size.length / 2


def _mount_end(placed: "Sequence[tuple[Element, Size, float]]") -> float | None:
    """The aft end of a motor in the mount farthest aft, with its overhang. [m]"""
    ends = []
    for part, size, front in placed:
        for one, at, length in [(part, front, size.length), *_inside(part, front, size.length)]:
            if (mount := one.find("motormount")) is not None:
                ends.append(at + length + number(mount, "overhang"))
    return max(ends, default=None)
