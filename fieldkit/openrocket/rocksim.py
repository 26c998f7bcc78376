"""RockSim designs (`.rkt`) in the terms of an OpenRocket design, so that the same code reads both.

Lengths are in mm, masses in g. RockSim stores the mass that it computed for each part, which is used unless one was
entered, as its center of gravity is; the density is used only without both. A place from the base of the parent counts
toward the nose. The names of the elements are from memory of RockSim 9 files: none was at hand to compare with.
"""

from collections.abc import Callable, Iterable, Iterator
from xml.etree.ElementTree import Element, SubElement

from fieldkit.openrocket.parts import COMPARE, PER_LIFT, PER_MASS, number, without_size

NOSES = ("conical", "ogive", "ellipsoid", "ellipsoid", "haack", "parabolic", "power", "haack")
"""Profiles by their number; RockSim's own parabola is nearest to an ellipsoid."""
LV_HAACK = 7
METHODS = ("top", "absolute", "bottom")
"""What the place of a part is measured from, by its number."""
SECTIONS = ("square", "rounded", "airfoil")
STAGES = ("Stage3Parts", "Stage2Parts", "Stage1Parts")
"""The stages from the top."""
FINS = {0: "trapezoidfinset", 1: "ellipticalfinset", 2: "freeformfinset"}
MM, GRAM = 1e-3, 1e-3


def is_rocksim(root: Element) -> bool:
    """Whether the document is a RockSim design."""
    return root.tag == "RockSimDocument" and root.find("DesignInformation/RocketDesign") is not None


def from_rocksim(root: Element) -> tuple[Element, list[str]]:
    """The design as an OpenRocket one, and notes on what was not read."""
    design = root.find("DesignInformation/RocketDesign")
    assert design is not None
    document = Element("openrocket")
    rocket = SubElement(document, "rocket", program="RockSim")
    SubElement(rocket, "name").text = design.findtext("Name")
    inside, unread = SubElement(rocket, "subcomponents"), dict[str, None]()
    entered = number(design, "UseKnownMass") == 1
    for place, name in enumerate(STAGES):
        parts = design.find(name)
        if parts is None or not len(parts):
            continue
        stage = SubElement(inside, "stage")
        whole = number(design, f"{name[:6]}Mass") * GRAM
        if entered and whole > 0 and place == 0:
            _override(stage, whole, number(design, f"{name[:6]}CG") * MM, below=True)
        _into(SubElement(stage, "subcomponents"), parts, unread)
    notes = ["the motors of a RockSim file are not read; state one with --motor"]
    notes.append(f"not tried on a file of RockSim yet: {COMPARE}")
    notes += without_size(document)
    if unread:
        missing = f"their mass and lift are missing: apogees are too high, {PER_MASS}, and the margin is off either way"
        notes.append(f"not read: {', '.join(unread)}; {missing}, {PER_LIFT}")
    return document, notes


def _into(inside: Element, parts: Iterable[Element], unread: dict[str, None]) -> None:
    """Add the parts in a list of parts; those of a subassembly are attached to what it is attached to."""
    for part in parts:
        if part.tag == "SubAssembly":
            _into(inside, part.findall("AttachedParts/*"), unread)
            continue
        if (made := _part(part)) is None:
            unread[part.tag] = None
            continue
        inside.append(made)
        below = part.find("AttachedParts")
        if below is not None and len(below):
            _into(SubElement(made, "subcomponents"), below, unread)


def _part(part: Element) -> Element | None:
    """A part without what is in it; None for a kind that is not known."""
    maker = PARTS.get(part.tag)
    if maker is None:
        return None
    made = maker(part)
    SubElement(made, "name").text = part.findtext("Name") or part.tag
    known, calculated = (number(part, name) * GRAM for name in ("KnownMass", "CalcMass"))
    entered = number(part, "UseKnownCG") == 1
    if entered or (known > 0 and part.tag == "MassObject"):
        _override(made, known, number(part, "KnownCG") * MM if entered else None, below=False)
    elif calculated > 0:
        _override(made, calculated, None, below=False)
    elif number(part, "DensityType") == 0:
        SubElement(made, "material", density=str(number(part, "Density")))
    method = METHODS[int(number(part, "LocationMode")) % 3]
    at = number(part, "Xb") * MM
    offset = SubElement(made, "axialoffset", method=method)
    offset.text = repr(-at if method == "bottom" else at)
    return made


def _override(part: Element, mass: float, cg: float | None, *, below: bool) -> None:
    SubElement(part, "overridemass").text = repr(mass)
    SubElement(part, "overridesubcomponentsmass").text = "true" if below else "false"
    if cg:
        SubElement(part, "overridecg").text = repr(cg)


def _sized(tag: str, **figures: float) -> Element:
    made = Element(tag)
    for name, value in figures.items():
        SubElement(made, name).text = repr(value)
    return made


def _nose(part: Element) -> Element:
    made = _shaped("nosecone", part)
    SubElement(made, "aftradius").text = repr(number(part, "BaseDia") * MM / 2)
    return made


def _transition(part: Element) -> Element:
    made = _shaped("transition", part)
    for name, theirs in (("foreradius", "FrontDia"), ("aftradius", "RearDia")):
        SubElement(made, name).text = repr(number(part, theirs) * MM / 2)
    return made


def _shaped(tag: str, part: Element) -> Element:
    code = int(number(part, "ShapeCode"))
    shape = NOSES[code] if 0 <= code < len(NOSES) else NOSES[0]
    made = _sized(tag, length=number(part, "Len") * MM, thickness=number(part, "WallThickness") * MM)
    SubElement(made, "shape").text = shape
    if shape in ("power", "parabolic", "haack"):
        parameter = 1 / 3 if code == LV_HAACK else 0.0 if shape == "haack" else number(part, "ShapeParameter")
        SubElement(made, "shapeparameter").text = repr(parameter)
    return made


def _tube(part: Element) -> Element:
    outer, inner = number(part, "OD") * MM / 2, number(part, "ID") * MM / 2
    inside = number(part, "IsInsideTube") == 1
    name = "innertube" if inside else "bodytube"
    made = _sized(name, length=number(part, "Len") * MM, thickness=max(outer - inner, 0.0))
    SubElement(made, "outerradius" if inside else "radius").text = repr(outer)
    if number(part, "IsMotorMount") == 1:
        made.append(mount := Element("motormount"))
        SubElement(mount, "overhang").text = repr(number(part, "EngineOverhang") * MM)
    return made


def _ring(part: Element) -> Element:
    return _sized(
        "centeringring",
        length=number(part, "Len") * MM,
        outerradius=number(part, "OD") * MM / 2,
        innerradius=number(part, "ID") * MM / 2,
    )


def _fins(part: Element) -> Element:
    shape = FINS.get(int(number(part, "ShapeCode")), FINS[0]) if part.tag == "FinSet" else FINS[2]
    made = _sized(
        shape,
        fincount=max(number(part, "FinCount"), 1.0),
        thickness=number(part, "Thickness") * MM,
        rootchord=number(part, "RootChord") * MM,
        tipchord=number(part, "TipChord") * MM,
        sweeplength=number(part, "SweepDistance") * MM,
        height=number(part, "SemiSpan") * MM,
    )
    code = int(number(part, "TipShapeCode"))
    SubElement(made, "crosssection").text = SECTIONS[code] if 0 <= code < len(SECTIONS) else SECTIONS[0]
    if shape == FINS[2]:
        points = SubElement(made, "finpoints")
        for x, y in _points(part.findtext("PointList") or ""):
            SubElement(points, "point", x=repr(x), y=repr(y))
    return made


def _points(text: str) -> Iterator[tuple[float, float]]:
    """The outline of a fin from the front of its root, in m; pairs that are not two numbers are left out."""
    found = []
    for pair in text.split("|")[:1000]:
        try:
            x, y = map(float, pair.split(","))
        except ValueError:
            continue
        found.append((x * MM, y * MM))
    yield from found if not found or found[0][0] <= found[-1][0] else reversed(found)


PARTS: dict[str, Callable[[Element], Element]] = {
    "NoseCone": _nose,
    "Transition": _transition,
    "BodyTube": _tube,
    "FinSet": _fins,
    "CustomFinSet": _fins,
    "Ring": _ring,
    "TubeFinSet": lambda part: Element("tubefinset"),
    "ExternalPod": lambda part: Element("podset"),
    "LaunchLug": lambda part: _sized("launchlug", length=number(part, "Len") * MM),
    "MassObject": lambda part: _sized("masscomponent", packedlength=number(part, "Len") * MM),
    "Parachute": lambda part: Element("parachute"),
    "Streamer": lambda part: Element("streamer"),
}
"""What each kind of part becomes."""
