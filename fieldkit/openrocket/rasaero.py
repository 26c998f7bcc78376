"""RASAero designs (`.CDX1`) in the terms of an OpenRocket design, so that the same code reads both.

Lengths are in inches, weights in pounds; of the launch site and the results, heights and the rod in feet, the wind in
mph. A file has the outline of the rocket and no masses of its parts, but a simulation states its launch weight and the
center of gravity with its motor. Without its motor, which ends where the rocket does and balances in its middle, the
rocket has the mass m = M - m_motor and its center at (M x - m_motor x_motor) / m. Its Cd grows with speed and is not in
the file: the stored apogees imply one, as in `implied`. A fin's place is that of its leading edge ahead of the aft end
of its tube. The names of the elements are from memory of RASAero II files: none was at hand to compare with.
"""

import math
import re
from collections.abc import Callable
from contextlib import suppress
from xml.etree.ElementTree import Element, SubElement

from fieldkit.errors import FieldkitError
from fieldkit.motors import Motor, catalogue
from fieldkit.openrocket.parts import COMPARE, PER_LIFT, number, without_size
from fieldkit.units import FOOT, INCH, POUND, UNITS

SHAPES = {
    "conical": ("conical", None),
    "tangent ogive": ("ogive", 1.0),
    "von karman ogive": ("haack", 0.0),
    "power law": ("power", None),
    "lv-haack": ("haack", 1 / 3),
    "parabolic": ("parabolic", 1.0),
    "elliptical": ("ellipsoid", None),
}
"""Profile and shape parameter of a nose by its name; that of a power law is in the file."""
SITE = (
    ("launchaltitude", "Altitude", FOOT),
    ("launchrodlength", "RodLength", FOOT),
    ("launchrodangle", "RodAngle", 1.0),
    ("windaverage", "WindSpeed", UNITS["speed"]["mph"].to_si(1.0)),
)
"""Conditions of the launch site as OpenRocket and as RASAero name them, and the unit of the latter."""
MAKERS = {"AT": "AeroTech", "CTI": "Cesaroni", "ES": "Estes", "LR": "Loki", "AMW": "Animal Motor Works", "QU": "Quest"}
"""Abbreviations of makers in the name of a motor: `K550W  (AT)`."""
_MOTOR = re.compile(r"(?P<name>[^()]{1,40})(?:\((?P<maker>[^()]{1,20})\))?\s{0,9}")


def is_rasaero(root: Element) -> bool:
    """Whether the document is a RASAero design."""
    return root.tag == "RASAeroDocument" and root.find("RocketDesign") is not None


def from_rasaero(root: Element, source: str) -> tuple[Element, list[str]]:
    """The design as an OpenRocket one, and notes on what was not read; a rocket is named after its file."""
    outline = root.find("RocketDesign")
    assert outline is not None
    document = Element("openrocket")
    rocket = SubElement(document, "rocket", program="RASAero")
    SubElement(rocket, "name").text = source.rpartition("/")[2].rpartition(".")[0] or source
    inside = SubElement(rocket, "subcomponents")
    stage = SubElement(inside, "stage")
    body = SubElement(stage, "subcomponents")
    unread: dict[str, None] = {}
    for part in outline:
        if part.tag == "Booster":
            SubElement(inside, "stage")
        elif (maker := PARTS.get(part.tag)) is not None:
            body.append(maker(part))
            _boat_tail(body, part)
        elif part.find("PartType") is not None:
            unread[part.tag] = None
    lift = f"their lift is missing: the margin is too small without fins, too large without a part in front, {PER_LIFT}"
    notes = [f"not read: {', '.join(unread)}; {lift}"] if unread else []
    engines = [
        (one, text)
        for one in root.iterfind("SimulationList/Simulation")
        if (text := (one.findtext("SustainerEngine") or "").strip())
    ]
    tubes = [one for one in body if one.tag == "bodytube"]
    if tubes:
        mount = SubElement(tubes[-1], "motormount")
        site, results = root.find("LaunchSite"), SubElement(document, "simulations")
        for one, text in engines[:100]:
            results.append(_simulation(one, text, site, str(len(mount))))
            named = _MOTOR.fullmatch(text)
            motor = SubElement(mount, "motor", configid=str(len(mount)))
            SubElement(motor, "designation").text = named["name"] if named else text
            SubElement(motor, "manufacturer").text = MAKERS.get(named["maker"] or "", named["maker"]) if named else ""
    length = sum(number(one, "length") for one in body)
    notes.append(f"not tried on a file of RASAero yet: {COMPARE}")
    return document, [*notes, *without_size(document), *_weigh(stage, engines, length)]


def _simulation(one: Element, name: str, site: Element | None, motor: str) -> Element:
    """The summary of a simulation on the motor of that id, from the launch site of the file."""
    made = Element("simulation", status="uptodate")
    SubElement(made, "name").text = name
    conditions = SubElement(made, "conditions")
    SubElement(conditions, "configid").text = motor
    if site is not None:
        for ours, theirs, unit in SITE:
            SubElement(conditions, ours).text = repr(number(site, theirs) * unit)
    SubElement(made, "flightdata", maxaltitude=repr(number(one, "MaxAltitude") * FOOT))
    return made


def _weigh(stage: Element, engines: list[tuple[Element, str]], length: float) -> list[str]:
    """Enter the mass and center of the rocket without its motor, from the first simulation whose motor is known;
    returns notes on it."""
    for one, text in engines:
        weight, cg = number(one, "SustainerLaunchWt") * POUND, number(one, "SustainerCG") * INCH
        motor = _found(text)
        if motor is None or weight <= motor.loaded_mass:
            continue
        dry = weight - motor.loaded_mass
        SubElement(stage, "overridemass").text = repr(dry)
        SubElement(stage, "overridesubcomponentsmass").text = "true"
        if cg > 0:
            center = (weight * cg - motor.loaded_mass * (length - motor.length / 2)) / dry
            SubElement(stage, "overridecg").text = repr(center)
        return [f"mass is the launch weight of its simulation on {text} less that of the motor in the catalog"]
    return ["its simulations state no launch weight with a known motor: weigh the rocket and state --dry-mass"]


def _found(text: str) -> Motor | None:
    """The motor of the catalog with this name."""
    named = _MOTOR.fullmatch(text)
    if named is None:
        return None
    with suppress(FieldkitError):
        return catalogue().resolve(f"{MAKERS.get(named['maker'] or '', '')} {named['name']}".strip()).motor
    return None


def _inches(part: Element, name: str) -> str:
    return repr(number(part, name) * INCH)


def _nose(part: Element) -> Element:
    made = Element("nosecone")
    shape, parameter = SHAPES.get((part.findtext("Shape") or "").strip().casefold(), SHAPES["conical"])
    SubElement(made, "length").text = _inches(part, "Length")
    SubElement(made, "aftradius").text = repr(number(part, "Diameter") * INCH / 2)
    SubElement(made, "shape").text = shape
    if shape == "power" or parameter is not None:
        SubElement(made, "shapeparameter").text = repr(number(part, "PowerLaw") if parameter is None else parameter)
    return made


def _tube(part: Element) -> Element:
    made = Element("bodytube")
    SubElement(made, "length").text = _inches(part, "Length")
    SubElement(made, "radius").text = repr(number(part, "Diameter") * INCH / 2)
    fins = [one for one in part if one.tag == "Fin" and number(one, "Count") > 0]
    if fins:
        inside = SubElement(made, "subcomponents")
        for fin in fins:
            inside.append(_fins(fin))
    return made


def _fins(fin: Element) -> Element:
    made = Element("trapezoidfinset")
    SubElement(made, "fincount").text = repr(number(fin, "Count"))
    names = {"rootchord": "Chord", "tipchord": "TipChord", "height": "Span", "sweeplength": "SweepDistance"}
    for name, theirs in names.items():
        SubElement(made, name).text = _inches(fin, theirs)
    offset = SubElement(made, "axialoffset", method="bottom")
    offset.text = repr((number(fin, "Chord") - number(fin, "Location")) * INCH)
    return made


def _transition(part: Element) -> Element:
    made = Element("transition")
    SubElement(made, "length").text = _inches(part, "Length")
    SubElement(made, "foreradius").text = repr(number(part, "Diameter") * INCH / 2)
    SubElement(made, "aftradius").text = repr(number(part, "RearDiameter") * INCH / 2)
    return made


def _boat_tail(body: Element, tube: Element) -> None:
    """Add the boat tail that a tube may state."""
    length, aft = number(tube, "BoattailLength"), number(tube, "BoattailRearDiameter")
    if tube.tag == "BodyTube" and length > 0 and aft > 0 and math.isfinite(length):
        made = SubElement(body, "transition")
        SubElement(made, "length").text = repr(length * INCH)
        SubElement(made, "foreradius").text = repr(number(tube, "Diameter") * INCH / 2)
        SubElement(made, "aftradius").text = repr(aft * INCH / 2)


PARTS: dict[str, Callable[[Element], Element]] = {
    "NoseCone": _nose,
    "BodyTube": _tube,
    "Transition": _transition,
    "BoatTail": _transition,
}
"""What each kind of part becomes; a booster is a stage of its own, and a fin can is not read."""
