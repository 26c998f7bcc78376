"""What a simulation kept in a design says: mass without motor, and Cd on the reference area of the design's own body.

The columns of a stored flight have three decimals, so that the reference area in m^2 keeps one digit for most rockets:
it is never read. A stored Cd refers to the reference diameter of the geometry, which is.
Source: OpenRocket's `ReferenceType`, `TextUtil` and `FlightDataBranch`, version 24.12.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.openrocket.parts import airframe, everything, number, sizes
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MIN_COAST_SPEED_FRACTION = 0.3
"""Fraction of the top speed below which Cd says little about the climb: it rises as the rocket slows. [1]"""
LEAST_RADIUS = 0.0005
"""A nose that is thinner does not set the reference. [m]"""
USED_COLUMNS = (
    "time",
    "mass",
    "motor mass",
    "drag coefficient",
    "drag force",
    "air density",
    "total velocity",
    "vertical velocity",
)
"""Columns of a stored simulation that are read."""
MOST_COLUMNS = 500
"""Columns of a stored simulation: OpenRocket has about sixty, and a few more per plug-in. [1]"""
LONGEST_NAME = 80
"""Of what is taken from the file as text. [characters]"""
CD_TOLERANCE = 0.05
"""Largest difference between Cd from the drag force and the stored Cd; sound files differ by 1 to 2%. [1]"""

Columns = dict[str, Float[Array, "row"]]


@dataclass(frozen=True, slots=True)
class Simulation:
    """A simulation in a file: its rocket without motors [kg], its Cd on `reference` [m], and its flight.

    `fresh` says that it is of the design as it is, `default` that it flew the default configuration. None is what
    it did not keep.
    """

    name: str
    fresh: bool
    default: bool
    dry_mass: float | None
    cd: float | None
    reference: float
    apogee: float | None
    top_speed: float | None
    consistent: bool


def simulations(root: "Element") -> list[Simulation]:
    """The simulations with stored flight data, those of the design as it is first, the default configuration before."""
    rocket = root.find("rocket")
    assert rocket is not None
    found = [_read(rocket, one) for one in root.iterfind("simulations/simulation")]
    return sorted((one for one in found if one is not None), key=lambda one: (not one.fresh, not one.default))


def _read(rocket: "Element", simulation: "Element") -> Simulation | None:
    """What a simulation kept, None if it kept nothing. Its first branch is that of the upper stage."""
    data, branch = simulation.find("flightdata"), simulation.find("flightdata/databranch")
    if data is None or branch is None:
        return None
    titles = [title.strip().lower() for title in (branch.get("types") or "").split(",", MOST_COLUMNS)[:MOST_COLUMNS]]
    places = {title: place for place, title in enumerate(titles) if title in USED_COLUMNS}
    rows = [_row(point.text or "", list(places.values())) for point in branch.iterfind("datapoint")]
    if len(rows) < 5:
        return None
    values = dict(zip(places, np.array(rows).T, strict=True))
    configuration = simulation.findtext("conditions/configid") or ""
    coast = _coast(values, branch)
    reference = reference_diameter(rocket, configuration)
    cd = float(np.median(values["drag coefficient"][coast])) if coast.any() else None
    return Simulation(
        shown(simulation.findtext("name"))[:60],
        simulation.get("status") in ("uptodate", "loaded"),
        _default(rocket, configuration),
        _dry_mass(values),
        cd,
        reference,
        _moment(data.get("maxaltitude", "")),
        _moment(data.get("maxvelocity", "")),
        cd is None or _consistent(values, coast, cd, reference),
    )


def shown(text: str | None) -> str:
    """What a file calls something, as it is shown."""
    return printable((text or "")[: 4 * LONGEST_NAME].strip())[:LONGEST_NAME]


def reference_diameter(rocket: "Element", configuration: str = "") -> float:
    """The diameter that OpenRocket's Cd refers to, of the stages that fly in a configuration. [m]

    By `referencetype` that of the widest part of the airframe, pods and boosters included, of the nose, or the
    designer's own.
    """
    kind = (rocket.findtext("referencetype") or "maximum").strip()
    if kind == "custom" and number(rocket, "customreference") > 0:
        return number(rocket, "customreference")
    inactive = _inactive(rocket, configuration)
    holders = [part for part in everything(rocket) if part.tag in ("stage", "parallelstage", "podset")]
    bodies = [size for holder in holders if holder not in inactive for size in sizes(airframe(holder))]
    if kind == "nosecone":
        ends = (end for size in bodies for end in (size.fore, size.aft))
        return 2 * next((end for end in ends if end >= LEAST_RADIUS), 0.0)
    return 2 * max((max(size.fore, size.aft) for size in bodies), default=0.0)


def _inactive(rocket: "Element", configuration: str) -> "list[Element]":
    """The stages that are switched off in a configuration, and all that hangs on them."""
    stages = [part for part in everything(rocket) if part.tag in ("stage", "parallelstage")]
    off = {
        int(stage.get("number", "-1"))
        for one in rocket.iterfind("motorconfiguration")
        if one.get("configid") == configuration
        for stage in one.iterfind("stage")
        if stage.get("active") == "false" and stage.get("number", "").isdigit()
    }
    return [part for number_, stage in enumerate(stages) if number_ in off for part in everything(stage)]


def _default(rocket: "Element", configuration: str) -> bool:
    found = (one for one in rocket.iterfind("motorconfiguration") if one.get("configid") == configuration)
    return any(one.get("default") == "true" for one in found)


def _dry_mass(values: Columns) -> float | None:
    weight, motor = values.get("mass"), values.get("motor mass")
    dry = float(weight[0] - motor[0]) if weight is not None and motor is not None else math.nan
    return dry if math.isfinite(dry) and dry > 0 else None


def _coast(values: Columns, branch: "Element") -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Which rows have a Cd of the coast: from the last burnout to apogee or an earlier parachute, and fast enough."""
    time, cd = values.get("time"), values.get("drag coefficient")
    speed = values.get("total velocity", values.get("vertical velocity"))
    if time is None or cd is None or speed is None or not np.isfinite(speed).any():
        return np.zeros(0, bool)
    apogee = min(_moments(branch, "apogee"), default=math.inf)
    end = min([apogee, *_moments(branch, "recoverydevicedeployment")])
    fastest = float(time[int(np.nanargmax(speed))])
    start = max((moment for moment in _moments(branch, "burnout") if moment <= end), default=fastest)
    fast = speed > MIN_COAST_SPEED_FRACTION * float(np.nanmax(speed))
    return np.asarray((time > start) & (time < end) & np.isfinite(cd) & fast, bool)


def _consistent(
    values: Columns, coast: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], cd: float, reference: float
) -> bool:
    """Whether the drag force on the reference area gives the stored Cd: else the body was another one."""
    force, density = values.get("drag force"), values.get("air density")
    speed = values.get("total velocity")
    if force is None or density is None or speed is None or reference <= 0:
        return True
    by_force = 2 * force[coast] / (density[coast] * speed[coast] ** 2 * np.pi / 4 * reference**2)
    found = float(np.nanmedian(by_force)) if np.isfinite(by_force).any() else cd
    return abs(found / cd - 1) <= CD_TOLERANCE if cd else True


def _moments(branch: "Element", kind: str) -> list[float]:
    """When events of a kind happened. [s]"""
    moments = [_moment(one.get("time", "")) for one in branch.iterfind("event") if one.get("type") == kind]
    return [moment for moment in moments if moment is not None]


def _moment(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _row(text: str, places: list[int]) -> list[float]:
    """The numbers at these places of a sample; what is no number is nan."""
    cells = text.split(",", MOST_COLUMNS)
    return [_float(cells[place]) if place < len(cells) else math.nan for place in places]


def _float(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan
