"""A design as a starting configuration: mass without motor, largest diameter, length, and Cd where it is told."""

import math
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.openrocket.archive import root_of
from fieldkit.openrocket.parts import airframe, children, everything, mass, number, sizes
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

PLAUSIBLE = {"dry_mass": (0.005, 50.0), "diameter": (0.005, 0.6), "length": (0.05, 10.0), "cd": (0.1, 3.0)}
"""What is taken from a file without a doubt. [kg, m, m, 1]"""
USED = ("time", "mass", "motor mass", "drag coefficient", "reference area", "total velocity", "vertical velocity")
"""Columns of a stored simulation that are read."""
MOST_COLUMNS = 500
"""Columns of a stored simulation: OpenRocket has some sixty, and a few for every plug-in. [1]"""
MOST_PARTS = 1000
"""Parts that follow each other along the body. [1]"""
MOST_MOTORS = 1000
"""Motors in all configurations of a design. [1]"""
LONGEST_NAME = 80
"""Of what is taken from the file as text. [characters]"""


@dataclass(frozen=True, slots=True)
class Motor:
    """A motor of one of a design's configurations, as the file names it."""

    configuration: str
    maker: str
    designation: str
    delay: str


@dataclass(frozen=True, slots=True)
class Design:
    """What a design says; None where it does not. `mass_by` and `cd_by` say where from, `notes` doubts. SI."""

    name: str
    dry_mass: float | None
    mass_by: str
    diameter: float | None
    length: float | None
    cd: float | None
    cd_by: str
    motors: tuple[Motor, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Stored:
    """What a simulation kept in the file says: mass without motor, and Cd on the reference area it used."""

    name: str
    fresh: bool
    dry_mass: float | None
    cd: float | None
    area: float | None


def read_design(content: bytes, source: str) -> Design:
    """The design in an `.ork` file. Raises DamagedLog that names it where it is damaged, or is no design."""
    root = root_of(content, source)
    try:
        return _design(root, source)
    except RecursionError as error:
        raise DamagedLog("found parts inside of parts without end, expected a rocket", source=source) from error


def _design(root: "Element", source: str) -> Design:
    rocket = root.find("rocket")
    assert rocket is not None
    stages = [part for part in children(rocket) if part.tag == "stage"]
    parts = [part for stage in stages for part in airframe(stage)]
    if not parts:
        raise DamagedLog("found no nose cone, tube or transition, expected a rocket", source=source)
    if len(parts) > MOST_PARTS:
        raise DamagedLog(f"found {len(parts)} parts along the body, expected at most {MOST_PARTS}", source=source)
    body = sizes(parts)
    diameter = 2 * max(max(one.fore, one.aft) for one in body)
    stored = [one for one in map(_stored, root.iterfind("simulations/simulation")) if one is not None]
    notes: list[str] = []
    weight, mass_by = _mass(rocket, stages, stored, notes)
    cd, cd_by = _drag(rocket, stages, stored, diameter, notes)
    if len(stages) > 1:
        notes.append(f"it has {len(stages)} stages, which are taken together: a flight in stages is not predicted")
    if any(part.tag in ("podset", "parallelstage") for part in everything(rocket)):
        notes.append("pods and boosters beside the body count for mass and not for the diameter")
    figures = {"dry_mass": weight, "diameter": diameter, "length": sum(one.length for one in body), "cd": cd}
    known = {name: _plausible(name, value, notes) for name, value in figures.items()}
    return Design(
        _text(rocket.findtext("name")),
        known["dry_mass"],
        mass_by,
        known["diameter"],
        known["length"],
        known["cd"],
        cd_by,
        tuple(_motors(rocket)),
        tuple(notes),
    )


def _plausible(name: str, value: float | None, notes: list[str]) -> float | None:
    low, high = PLAUSIBLE[name]
    if value is None or low <= value <= high:
        return value
    notes.append(f"{name.replace('_', ' ')}: found {value:.4g}, expected {low:g} to {high:g}; it is left out")
    return None


def _mass(
    rocket: "Element", stages: "list[Element]", stored: list[Stored], notes: list[str]
) -> tuple[float | None, str]:
    """By a stored simulation of the design as it is, else by the sum of its parts."""
    unknown: list[str] = []
    override = rocket.findtext("overridemass")
    total = number(rocket, "overridemass") if override else sum(mass(stage, None, unknown) for stage in stages)
    fresh = next((one for one in stored if one.fresh and one.dry_mass), None)
    if fresh is not None and fresh.dry_mass is not None:
        if abs(total / fresh.dry_mass - 1) > 0.1:
            notes.append(f"its parts add up to {total * 1e3:.0f} g by their geometry")
        return fresh.dry_mass, f"the simulation {fresh.name}, less its motor"
    if unknown:
        notes.append(f"the mass of {', '.join(map(_text, unknown[:5]))} is not known and left out")
    return total or None, "the sum of its parts"


def _drag(
    rocket: "Element", stages: "list[Element]", stored: list[Stored], diameter: float, notes: list[str]
) -> tuple[float | None, str]:
    """By an override of the whole, else by a stored simulation; on the area of the largest diameter."""
    for part in (rocket, *stages):
        if part.findtext("overridecd") is not None and len(stages) == 1:
            return number(part, "overridecd"), "its override"
    one = next((one for one in sorted(stored, key=lambda one: not one.fresh) if one.cd), None)
    if one is None or one.cd is None:
        notes.append("no Cd: no simulation with a drag coefficient is stored in the file; run one and save it")
        return None, ""
    if not one.fresh:
        notes.append(f"the simulation {one.name} is older than the design")
    area = math.pi / 4 * diameter**2
    return one.cd * (one.area / area if one.area and area else 1.0), f"the coast of the simulation {one.name}"


def _motors(rocket: "Element") -> "list[Motor]":
    names = {one.get("configid", ""): one.findtext("name") or "" for one in rocket.iterfind("motorconfiguration")}
    return [
        Motor(
            _text(names.get(one.get("configid", ""), "")),
            _text(one.findtext("manufacturer")),
            _text(one.findtext("designation")),
            _text(one.findtext("delay")),
        )
        for one in islice(rocket.iter("motor"), MOST_MOTORS)
    ]


def _text(text: str | None) -> str:
    """What a file calls something, as it is shown."""
    return printable((text or "")[: 4 * LONGEST_NAME].strip())[:LONGEST_NAME]


def _stored(simulation: "Element") -> Stored | None:
    """What a simulation kept of its flight, None where it kept none. Its first branch is that of the whole rocket."""
    branch = simulation.find("flightdata/databranch")
    if branch is None:
        return None
    titles = [title.strip().lower() for title in (branch.get("types") or "").split(",", MOST_COLUMNS)[:MOST_COLUMNS]]
    places = {title: place for place, title in enumerate(titles) if title in USED}
    rows = [_row(point.text or "", list(places.values())) for point in branch.iterfind("datapoint")]
    if len(rows) < 5:
        return None
    values = dict(zip(places, np.array(rows).T, strict=True))
    events = {one.get("type", ""): one.get("time", "") for one in branch.iterfind("event")}
    weight, motor = values.get("mass"), values.get("motor mass")
    dry = float(weight[0] - motor[0]) if weight is not None and motor is not None else math.nan
    area = values.get("reference area")
    return Stored(
        _text(simulation.findtext("name")),
        simulation.get("status") in ("uptodate", "loaded"),
        dry if math.isfinite(dry) and dry > 0 else None,
        _coast_cd(values, events),
        float(np.nanmedian(area)) if area is not None else None,
    )


def _row(text: str, places: list[int]) -> list[float]:
    """The numbers at these places of a sample; what is no number is nan."""
    cells = text.split(",", MOST_COLUMNS)
    return [_float(cells[place]) if place < len(cells) else math.nan for place in places]


def _float(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _coast_cd(values: dict[str, Float[Array, "row"]], events: dict[str, str]) -> float | None:
    """Mean Cd from burnout to apogee, weighted by speed squared: what of it slows the rocket. [1]"""
    time, cd = values.get("time"), values.get("drag coefficient")
    speed = values.get("total velocity", values.get("vertical velocity"))
    if time is None or cd is None or speed is None:
        return None
    start, end = (_moment(events.get(name, "")) for name in ("burnout", "apogee"))
    start = start if start is not None else float(time[int(np.nanargmax(np.nan_to_num(speed)))])
    coast = (time > start) & (time < (end if end is not None else np.inf)) & np.isfinite(cd) & np.isfinite(speed)
    weight = speed[coast] ** 2
    return float((cd[coast] * weight).sum() / weight.sum()) if weight.sum() > 0 else None


def _moment(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
