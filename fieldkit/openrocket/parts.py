"""The parts of a design: sizes, and masses from geometry and material, with overrides taking precedence.

Lengths are in m, masses in kg, densities in kg/m^3 (bulk), kg/m^2 (surface) and kg/m (line), as in the files.
Source: the elements of OpenRocket's saved designs, https://openrocket.readthedocs.io.
"""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

AIRFRAME = ("nosecone", "bodytube", "transition")
"""Parts that are placed one after another along the body."""
ASSEMBLIES = ("stage", "podset", "parallelstage")
"""Parts that consist of an airframe of their own."""
MOST_COPIES = 999
"""Largest number of tubes in a cluster, or of pods in a set. [1]"""
SECTIONS = {"square": 1.0, "rounded": 0.99, "airfoil": 0.85}
"""Volume of a fin over its area times its thickness, by cross section. Source: OpenRocket's `FinSet`. [1]"""
SHAPE_PARAMETERS = {"ogive": (1.0, 1.0), "power": (0.5, 1.0), "parabolic": (1.0, 1.0), "haack": (0.0, 1 / 3)}
"""Default and largest shape parameter of a profile; the smallest is 0. Source: OpenRocket's `Transition.Shape`. [1]"""
CENTERED_CLUSTERS = ("3-star", "4-star", "5-star", "6-star")
"""Clusters with a tube in the center of a ring of as many as the name says. Source: OpenRocket's
`ClusterConfiguration`."""
PER_MASS = "by 0.5 to 1.2% for each percent of the mass"
"""How much a wrong mass moves an apogee: `fieldkit simulate` of a fast rocket (F24-4W, 322 g, 66 mm) and of a slow one
(A8-3, 40 g, 25 mm), with a Cd of 0.6 and a tenth of the mass missing."""
PER_AREA = "by 0.2 to 0.4% for each percent of the frontal area"
"""How much a missing frontal area moves an apogee: the same two flights, with a tenth of the Cd missing."""
PER_CD = PER_AREA.replace("the frontal area", "Cd")
"""How much a wrong Cd moves an apogee, which depends on its product with the area."""
PER_LIFT = "by at most a tenth of the length for each tenth of the rocket's lift or mass"
"""How much a part that is missing moves the static margin: the centers are means over the parts weighted by lift and by
mass, so a part with a tenth of all moves one of them by a tenth of its distance from it."""
COMPARE = (
    f"compare mass, length and margin with what it shows; with a wrong mass apogees are off either way, {PER_MASS}"
)
"""What to do about a reader that was tried on no file of its program."""
LEAST_NUMBER, MOST_NUMBER = 1e-9, 1e9
"""No size, density, pressure or angle of a rocket is outside, in the units of any of the programs; products of a few
numbers between them never overflow. [1]"""
STEPS = 200
"""Number of slices of a nose cone or transition in the numerical integration of its volume. [1]"""


@dataclass(frozen=True, slots=True)
class Size:
    """A part of the airframe: its length and the radius at either end. [m]"""

    length: float
    fore: float
    aft: float


def number(part: "Element", name: str, otherwise: float = 0.0) -> float:
    """A number of a part in SI, the one after `auto` if the file includes one; `otherwise` if it is missing, not a
    number, or absurdly large."""
    text = (part.findtext(name) or "").split()
    return usable_number(text[-1], otherwise) if text else otherwise


def usable_number(text: str, otherwise: float = 0.0) -> float:
    """The number in a text, which may have a decimal comma; 0 if it is absurdly small, `otherwise` if it is absurdly
    large or not a number. [any unit]"""
    try:
        value = float(text.replace(",", ".") if text.count(",") == 1 and "." not in text else text)
    except ValueError:
        return otherwise
    if abs(value) < LEAST_NUMBER:
        return 0.0
    return value if abs(value) <= MOST_NUMBER else otherwise


SIZES = {
    "nosecone": ("length", "aftradius"),
    "bodytube": ("length", "radius"),
    "transition": ("length", "foreradius", "aftradius"),
    "trapezoidfinset": ("rootchord", "height"),
    "ellipticalfinset": ("rootchord", "height"),
}
"""What a part needs for its drag and lift, by kind."""


def without_size(document: "Element") -> list[str]:
    """A note on the parts of another program's design whose sizes are missing or no numbers; none if all have them."""
    missing = [
        f"{name_of(part)} ({name})"
        for part in document.iter()
        for name in SIZES.get(part.tag, ())
        if number(part, name) <= 0
    ]
    if not missing:
        return []
    more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
    return [
        f"no size, taken as zero: {', '.join(missing[:5])}{more}; with less length, mass and frontal area, "
        f"apogees are too high, {PER_AREA} and {PER_MASS.removeprefix('by ')}, and the margin is off either way, "
        f"{PER_LIFT}"
    ]


def children(part: "Element") -> "list[Element]":
    """The parts attached to or contained in a part."""
    inside = part.find("subcomponents")
    return [] if inside is None else list(inside)


def name_of(part: "Element") -> str:
    """The designer's name for a part."""
    return (part.findtext("name") or part.tag).strip()


def airframe(stage: "Element") -> "list[Element]":
    """The parts of a stage along the body, in order."""
    return [part for part in children(stage) if part.tag in AIRFRAME]


def sizes(parts: "list[Element]") -> list[Size]:
    """Lengths and radii; an `auto` radius without a stored value is that of the nearest other part with one."""
    ends = [list(_ends(part)) for part in parts]
    flat = [radius for pair in ends for radius in pair]
    for place, radius in enumerate(flat):
        if radius is None:
            near = sorted((abs(x - place), r) for x, r in enumerate(flat) if r is not None and x // 2 != place // 2)
            ends[place // 2][place % 2] = near[0][1] if near else 0.0
    return [
        Size(number(part, "length"), fore or 0.0, aft or 0.0) for part, (fore, aft) in zip(parts, ends, strict=True)
    ]


def _ends(part: "Element") -> tuple[float | None, float | None]:
    """The radius at either end; None if it is automatic and not stored. [m]"""
    if part.tag == "bodytube":
        radius = _radius(part, "radius")
        return radius, radius
    if part.tag == "nosecone":
        tip = _radius(part, "foreradius") if (part.findtext("isflipped") or "") == "true" else 0.0
        return (tip, 0.0) if tip else (0.0, _radius(part, "aftradius"))
    return _radius(part, "foreradius"), _radius(part, "aftradius")


def _radius(part: "Element", name: str) -> float | None:
    """A radius; None if it is automatic and not stored."""
    value = number(part, name, -1.0)
    return value if value >= 0 else None


def mass(part: "Element", size: Size | None, unknown: list[str]) -> float:
    """Mass of a part and everything in it. [kg]

    `size` is that of a part of the airframe, None for others. The names of parts with unknown mass are added to
    `unknown`.
    """
    own, below = override(part)
    if own is not None and below:
        return own
    _fit_inside(part, size)
    inside = sum(mass(one, None, unknown) for one in children(part) if one.tag not in AIRFRAME)
    if part.tag in ASSEMBLIES:
        parts = airframe(part)
        inside += sum(mass(one, of, unknown) for one, of in zip(parts, sizes(parts), strict=True))
    return (own if own is not None else own_mass(part, size, unknown)) + copies(part) * inside


def _fit_inside(part: "Element", size: Size | None) -> None:
    """Fill in the automatic radii of the parts in a tube, which older files do not store: the outer one is the bore of
    the tube, and the inner one of a ring is that of the inner tubes beside it. [m]"""
    outer = max(size.fore, size.aft) if size else _outer_radius(part)
    bore = max(outer - number(part, "thickness"), 0.0)
    tubes = max((_outer_radius(one) for one in children(part) if one.tag == "innertube"), default=0.0)
    for one in children(part):
        for name, radius in (("outerradius", bore), ("innerradius", tubes)):
            found = one.find(name)
            if found is not None and math.isnan(number(one, name, math.nan)):
                found.text = repr(radius)


def copies(part: "Element") -> int:
    """Number of copies of the contents of a part: the tubes of a cluster, or the pods or boosters of a set. [1]"""
    if part.tag in ("podset", "parallelstage"):
        return int(min(max(number(part, "instancecount", 1.0), 1.0), MOST_COPIES))
    cluster = (part.findtext("clusterconfiguration") or "single").strip()
    counted = re.match(r"\d{1,3}", cluster)
    return int(counted[0]) + (cluster in CENTERED_CLUSTERS) if counted else 2 if cluster == "double" else 1


def override(part: "Element") -> tuple[float | None, bool]:
    """The mass that the designer entered, if it is a number [kg], and whether it includes everything inside."""
    entered = number(part, "overridemass", math.nan)
    if math.isnan(entered):
        return None, False
    below = part.findtext("overridesubcomponentsmass") or part.findtext("overridesubcomponents") or "false"
    return entered, below.strip() == "true"


def own_mass(part: "Element", size: Size | None, unknown: list[str]) -> float:
    """Mass of a part without what is in it; 0 if it is unknown. [kg]"""
    volume = VOLUMES.get(part.tag)
    if size is not None:
        return _density(part, "material") * _shell(part, size)
    if volume is not None and (volume is not _tube or _outer_radius(part)):
        return _density(part, "material") * volume(part) * _instances(part)
    if part.tag in OTHER_MASSES:
        return OTHER_MASSES[part.tag](part)
    if part.tag not in MASSLESS_PARTS:
        unknown.append(name_of(part))
    return 0.0


def _density(part: "Element", name: str) -> float:
    """Density of a material of a part, in the unit of its kind; 0 if it is missing."""
    material = part.find(name)
    return usable_number(material.get("density", "0")) if material is not None else 0.0


def _instances(part: "Element") -> float:
    """Number of copies of a part, which files state for fins as `fincount` as well. [1]"""
    named = "fincount" if part.find("fincount") is not None else "instancecount"
    return max(number(part, named, 1.0), 1.0) * copies(part)


def _shell(part: "Element", size: Size) -> float:
    """Volume of the wall of a tube, nose or transition, and of the shoulders of a nose or transition. [m^3]"""
    filled = (part.findtext("thickness") or "").strip() == "filled"
    wall = math.inf if filled else number(part, "thickness")
    outer = outer_profile(part, size)
    slope = np.gradient(outer, size.length / STEPS) if size.length else 0.0 * outer
    inner = np.maximum(outer - wall * np.sqrt(1 + slope**2), 0.0)
    body = float(np.pi * (outer**2 - inner**2).mean() * size.length)
    return body + sum(_ring(part, f"{end}shoulder") for end in ("fore", "aft"))


def outer_profile(part: "Element", size: Size) -> Float[Array, "step"]:
    """Outer radius of a part of the airframe in the middle of each of `STEPS` slices, from its front. [m]"""
    along = (np.arange(STEPS) + 0.5) / STEPS
    thin, wide = sorted((size.fore, size.aft))
    bent = _profile(part, along if size.fore == thin else 1 - along, wide - thin, size.length)
    return np.asarray(thin + (wide - thin) * bent)


def _profile(part: "Element", x: Float[Array, "step"], radius: float, length: float) -> Float[Array, "step"]:
    """Radius profile from the thin end to the wide one, 0 to 1, of a part that widens by `radius` over `length` [m].

    Source: Crowell, The Descriptive Geometry of Nose Cones, 1996.
    """
    shape = (part.findtext("shape") or "conical").strip()
    usual, most = SHAPE_PARAMETERS.get(shape, (0.0, 1.0))
    bent = min(max(number(part, "shapeparameter", usual), 0.0), most)
    if shape == "ellipsoid":
        return np.asarray(np.sqrt(1 - (1 - x) ** 2))
    if shape == "ogive" and min(radius, length, bent) > 0:
        return _ogive(x, radius / max(length, radius), bent)
    if shape == "power":
        return np.asarray(x**bent)
    if shape == "parabolic":
        return np.asarray((2 * x - bent * x**2) / (2 - bent))
    if shape == "haack":
        angle = np.arccos(1 - 2 * x)
        return np.asarray(np.sqrt(np.maximum(angle - np.sin(2 * angle) / 2 + bent * np.sin(angle) ** 3, 0) / np.pi))
    return x


def _ogive(x: Float[Array, "step"], ratio: float, bent: float) -> Float[Array, "step"]:
    """Radius profile of an ogive by the ratio of its radius to its length: tangent to the body for a shape parameter of
    1, nearly a cone toward 0.

    The circle has its center 1 / bent lengths behind the tip and runs through tip and shoulder.
    """
    ahead = 1 / bent
    below = (2 * ahead - 1 - ratio**2) / (2 * ratio)
    return np.asarray((np.sqrt(ahead**2 + below**2 - (ahead - x) ** 2) - below) / ratio)


def _ring(part: "Element", name: str) -> float:
    """Volume of a shoulder and its cap. [m^3]"""
    outer, wall, length = (number(part, f"{name}{what}") for what in ("radius", "thickness", "length"))
    ring = math.pi * (outer**2 - max(outer - wall, 0.0) ** 2) * length
    capped = (part.findtext(f"{name}capped") or "") == "true"
    return ring + (math.pi * max(outer - wall, 0.0) ** 2 * wall if capped else 0.0)


def _outer_radius(part: "Element") -> float:
    """Outer radius of a tube or ring; 0 if it is automatic and not stored. [m]"""
    return number(part, "outerradius") or number(part, "radius")


def _tube(part: "Element") -> float:
    """Volume of a tube, ring, bulkhead, engine block or lug, from its outer radius and its inner radius or, without
    that, its wall. [m^3]"""
    outer = _outer_radius(part)
    wall = number(part, "thickness")
    inner = number(part, "innerradius") if part.find("innerradius") is not None else max(outer - wall, 0.0)
    solid = part.tag == "bulkhead"
    return math.pi * (outer**2 - (0.0 if solid else inner**2)) * number(part, "length")


def _fins(part: "Element") -> float:
    """Volume of one fin with its tab; an airfoil has less than its thickness suggests. [m^3]"""
    section = SECTIONS.get((part.findtext("crosssection") or "").strip(), 1.0)
    tab = number(part, "tabheight") * number(part, "tablength")
    return (section * _planform(part) + tab) * number(part, "thickness")


def _planform(part: "Element") -> float:
    """Area of one fin without its tab. [m^2]"""
    root, tip, height = (number(part, name) for name in ("rootchord", "tipchord", "height"))
    if part.tag == "trapezoidfinset":
        return (root + tip) / 2 * height
    if part.tag == "ellipticalfinset":
        return math.pi / 4 * root * height
    points = fin_points(part)
    return abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, [*points[1:], *points[:1]], strict=True))) / 2


def fin_points(part: "Element") -> list[tuple[float, float]]:
    """The outline of a freeform fin: along the body from the front of its root, and outward. [m]"""
    return [(usable_number(p.get("x", "0")), usable_number(p.get("y", "0"))) for p in part.iterfind("finpoints/point")]


def _parachute(part: "Element") -> float:
    cloth = math.pi / 4 * number(part, "diameter") ** 2 * _density(part, "material")
    return cloth + number(part, "linecount") * number(part, "linelength") * _density(part, "linematerial")


VOLUMES: "dict[str, Callable[[Element], float]]" = {
    **dict.fromkeys(("innertube", "tubecoupler", "centeringring", "bulkhead", "engineblock", "launchlug"), _tube),
    **dict.fromkeys(("trapezoidfinset", "ellipticalfinset", "freeformfinset"), _fins),
    "tubefinset": _tube,
}
"""Parts made of one bulk material, and the volume of one of them. [m^3]"""
OTHER_MASSES: "dict[str, Callable[[Element], float]]" = {
    "masscomponent": lambda part: number(part, "mass"),
    "parachute": _parachute,
    "streamer": lambda part: number(part, "striplength") * number(part, "stripwidth") * _density(part, "material"),
    "shockcord": lambda part: number(part, "cordlength") * _density(part, "material"),
}
"""Parts whose mass is computed in another way. [kg]"""
MASSLESS_PARTS = ("stage", "railbutton", "podset", "parallelstage")
"""Parts without a mass of their own; a rail button weighs only a gram or two."""


def everything(part: "Element") -> "Iterator[Element]":
    """A part and everything in it."""
    yield part
    for one in children(part):
        yield from everything(one)
