"""Data of a simulation stored in a design: mass without motor, and Cd on the reference area of the design's body.

The columns of a stored flight have three decimals, so that the reference area in m^2 has only one significant digit for
most rockets; it is never read. A stored Cd refers to the reference diameter of the geometry, which is read.
Source: OpenRocket's `ReferenceType`, `TextUtil` and `FlightDataBranch`, version 24.12.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.openrocket.parts import airframe, everything, number, sizes, usable_number
from fieldkit.safe_text import printable, whole_number
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MIN_COAST_SPEED_FRACTION = 0.3
"""Fraction of the top speed below which Cd is not typical of the climb: it rises as the rocket slows. [1]"""
LEAST_RADIUS = 0.0005
"""Smallest radius of a nose that sets the reference. [m]"""
USED_COLUMNS = (
    "time",
    "mass",
    "motor mass",
    "drag coefficient",
    "drag force",
    "air density",
    "total velocity",
    "vertical velocity",
    "cg location",
    "cp location",
    "angle of attack",
)
"""Columns of a stored simulation that are read."""
MOST_COLUMNS = 500
"""Largest number of columns of a stored simulation: OpenRocket has about sixty, and a few more per plug-in. [1]"""
LONGEST_NAME = 80
"""Largest length of text taken from the file. [characters]"""
CD_TOLERANCE = 0.05
"""Largest difference between Cd from the drag force and the stored Cd; valid files differ by 1 to 2%. [1]"""

StoredColumns = dict[str, Float[Array, "row"]]


@dataclass(frozen=True, slots=True)
class Simulation:
    """A simulation in a file.

    `dry_mass` is that of its rocket without motors [kg], `cd` its Cd on the diameter `reference` [m]; `apogee` is in m,
    `top_speed` in m/s. `consistent` means that its drag force gives the same Cd on that diameter. `cg` is its center of
    gravity as it leaves the launch rod, `cp` that of pressure at small angles, from the tip of the nose [m]. `fresh`
    means that it belongs to the current design, `default` that it used the default configuration. None means not
    stored; `cd`, `apogee` and `top_speed` are None as well if the rocket tumbled, or the simulation was aborted, before
    apogee (`upset`). `readable` means that the names of its columns are in English, the only language that is read.
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
    cg: float | None = None
    cp: float | None = None
    upset: bool = False
    readable: bool = True


def simulations(root: "Element") -> list[Simulation]:
    """The simulations with stored flight data: those of the current design first, then the default configuration."""
    rocket = root.find("rocket")
    assert rocket is not None
    found = [_read(rocket, one) for one in root.iterfind("simulations/simulation")]
    return sorted((one for one in found if one is not None), key=lambda one: (not one.fresh, not one.default))


def _read(rocket: "Element", simulation: "Element") -> Simulation | None:
    """The stored data of a simulation; None if it has fewer than five rows. Its first branch is that of the upper
    stage."""
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
    upset = _upset(branch)
    cg, cp = _centers(values, branch)
    coast = np.zeros(len(rows), bool) if upset else _coast(values, branch)
    reference = reference_diameter(rocket, configuration)
    cd = float(np.median(values["drag coefficient"][coast])) if coast.any() else None
    return Simulation(
        shown(simulation.findtext("name"))[:60],
        simulation.get("status") in ("uptodate", "loaded"),
        _default(rocket, configuration),
        _dry_mass(values),
        cd,
        reference,
        None if upset else _finite(data.get("maxaltitude", "")),
        None if upset else _finite(data.get("maxvelocity", "")),
        cd is None or _consistent(values, coast, cd, reference),
        cg,
        cp,
        upset,
        "time" in values,
    )


def shown(text: str | None) -> str:
    """A name from the file, made printable and no longer than `LONGEST_NAME`."""
    return printable((text or "")[: 4 * LONGEST_NAME].strip())[:LONGEST_NAME]


def reference_diameter(rocket: "Element", configuration: str = "") -> float:
    """The diameter that OpenRocket's Cd refers to, for the stages that fly in a configuration. [m]

    Depending on `referencetype` it is that of the widest part of the airframe (pods and boosters included), that of the
    nose, or the designer's own.
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
    """The stages that are disabled in a configuration, and everything attached to them."""
    stages = [part for part in everything(rocket) if part.tag in ("stage", "parallelstage")]
    off = {
        whole_number(stage.get("number", ""))
        for one in rocket.iterfind("motorconfiguration")
        if one.get("configid") == configuration
        for stage in one.iterfind("stage")
        if stage.get("active") == "false"
    }
    return [part for number_, stage in enumerate(stages) if number_ in off for part in everything(stage)]


def _default(rocket: "Element", configuration: str) -> bool:
    """Whether a configuration of motors is the default one."""
    found = (one for one in rocket.iterfind("motorconfiguration") if one.get("configid") == configuration)
    return any(one.get("default") == "true" for one in found)


def _dry_mass(values: StoredColumns) -> float | None:
    """Mass without motors in the first row; None if it is not stored or not positive. [kg]"""
    weight, motor = values.get("mass"), values.get("motor mass")
    dry = float(weight[0] - motor[0]) if weight is not None and motor is not None else math.nan
    return dry if math.isfinite(dry) and dry > 0 else None


def _centers(values: StoredColumns, branch: "Element") -> tuple[float, float] | tuple[None, None]:
    """The center of gravity in the first row off the launch rod, with the motor nearly full, and the center of pressure
    at the smallest angle of attack of the climb, or at its top speed if no angle is stored. [m]

    OpenRocket's center of pressure moves forward with the angle of attack, which is large as a rocket leaves the rod in
    wind; the static margin of guidance is that at small angles.
    """
    time, cg, cp = (values.get(name) for name in ("time", "cg location", "cp location"))
    if time is None or cg is None or cp is None:
        return None, None
    off = min(_moments(branch, "launchrod"), default=0.0)
    end = min(_moments(branch, "apogee"), default=math.inf)
    rows = np.flatnonzero((time >= off) & (time < end) & np.isfinite(cg) & np.isfinite(cp))
    if not rows.size:
        return None, None
    speed = values.get("total velocity", values.get("vertical velocity"))
    angle = values.get("angle of attack")
    fast = rows
    if speed is not None and np.isfinite(speed[rows]).any():
        fast = rows[np.nan_to_num(speed[rows]) >= MIN_COAST_SPEED_FRACTION * np.nanmax(speed[rows])]
    if angle is not None and np.isfinite(angle[fast]).any():
        best = fast[int(np.nanargmin(np.abs(angle[fast])))]
    else:
        best = fast[int(np.argmax(np.nan_to_num(speed[fast])))] if speed is not None else fast[0]
    return float(cg[rows[0]]), float(cp[best])


def _coast(values: StoredColumns, branch: "Element") -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Rows with a Cd of the coast: from the last burnout, or top speed without one, to apogee or an earlier parachute,
    and fast enough."""
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


def _upset(branch: "Element") -> bool:
    """Whether the rocket tumbled or the simulation was aborted before apogee: its flight is not that of the design."""
    ends = [*_moments(branch, "tumble"), *_moments(branch, "simabort")]
    return min(ends, default=math.inf) < min(_moments(branch, "apogee"), default=math.inf)


def _consistent(
    values: StoredColumns, coast: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], cd: float, reference: float
) -> bool:
    """Whether the drag force on the reference area gives the stored Cd, or is not stored; otherwise the body was a
    different one."""
    force, density = values.get("drag force"), values.get("air density")
    speed = values.get("total velocity")
    if force is None or density is None or speed is None or reference <= 0:
        return True
    divisor = density[coast] * speed[coast] ** 2 * np.pi / 4 * reference**2
    by_force = 2 * force[coast] / np.where(divisor > 0, divisor, np.nan)
    found = float(np.nanmedian(by_force)) if np.isfinite(by_force).any() else cd
    return abs(found / cd - 1) <= CD_TOLERANCE if cd else True


def _moments(branch: "Element", kind: str) -> list[float]:
    """Times of the events of a kind. [s]"""
    moments = [_finite(one.get("time", "")) for one in branch.iterfind("event") if one.get("type") == kind]
    return [moment for moment in moments if moment is not None]


def _finite(text: str) -> float | None:
    """The number in a text, None if it is not a usable one."""
    value = usable_number(text, math.nan)
    return None if math.isnan(value) else value


def _row(text: str, places: list[int]) -> list[float]:
    """The numbers at these indices of a sample; text that is not a number becomes nan."""
    cells = text.split(",", MOST_COLUMNS)
    return [usable_number(cells[place], math.nan) if place < len(cells) else math.nan for place in places]
