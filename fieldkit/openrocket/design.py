"""A design as a starting configuration: mass without motor, largest diameter, length, and Cd if available."""

from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from statistics import median
from typing import TYPE_CHECKING

from fieldkit.errors import DamagedLog, FieldkitError
from fieldkit.motors import Motor, catalogue
from fieldkit.openrocket.archive import root_of
from fieldkit.openrocket.balance import Balance, balance
from fieldkit.openrocket.implied import FlownAgain, flown_again, implied_cds, in_several_winds
from fieldkit.openrocket.parts import (
    PER_AREA,
    PER_CD,
    PER_MASS,
    airframe,
    children,
    copies,
    everything,
    mass,
    number,
    override,
    sizes,
)
from fieldkit.openrocket.rasaero import from_rasaero, is_rasaero
from fieldkit.openrocket.rocksim import from_rocksim, is_rocksim
from fieldkit.openrocket.stored import Simulation, reference_diameter, shown, simulations
from fieldkit.quantities import counted
from fieldkit.rocket import Configuration

if TYPE_CHECKING:
    from collections.abc import Iterator
    from xml.etree.ElementTree import Element

PLAUSIBLE_RANGES = {"dry_mass": (0.005, 50.0), "diameter": (0.005, 0.6), "length": (0.05, 10.0), "cd": (0.1, 3.0)}
"""Ranges of values; one outside its range is left out with a warning. [kg, m, m, 1]"""
MASS_ROUNDING = 0.0011
"""Largest rounding error of the difference of two stored masses with three decimals each. [kg]"""
REPORTED_CD_DIFFERENCE = 0.05
"""Cd values of simulations that differ by more than this are reported. [1]"""
MOST_PARTS = 1000
"""Largest number of parts in a row along the body. [1]"""
MOST_MOTORS = 1000
"""Largest number of motors in all configurations of a design; more are left out. [1]"""


@dataclass(frozen=True, slots=True)
class DesignMotor:
    """A motor of one of a design's configurations, as named in the file; `count` is the number in its mount,
    times the pods or boosters that have such a mount."""

    configuration: str
    maker: str
    designation: str
    delay: str
    count: int = 1

    def found(self) -> Motor | None:
        """The motor of the catalog that it names; None if there is none."""
        with suppress(FieldkitError):
            return catalogue().resolve(f"{self.maker} {self.designation}").motor
        return None


@dataclass(frozen=True, slots=True)
class Design:
    """The data of a design in SI units; None if missing.

    `mass_by` and `cd_by` are the sources of mass and Cd, `notes` are warnings. `cd` refers to the area of `diameter`; a
    simulation's Cd to that of its own `reference`.
    """

    name: str
    dry_mass: float | None
    mass_by: str
    diameter: float | None
    length: float | None
    cd: float | None
    cd_by: str
    motors: tuple[DesignMotor, ...]
    notes: tuple[str, ...]
    simulations: tuple[Simulation, ...] = ()
    balance: Balance | None = None
    flown_again: tuple[FlownAgain, ...] = ()

    def margin(self, motor: Motor) -> float | None:
        """The static margin on the pad with a loaded motor, from the parts of the design; None if they do not show it.
        [1]"""
        if self.balance is None or not self.diameter:
            return None
        cg = self.balance.cg(motor.loaded_mass, motor.length, self.dry_mass)
        return None if cg is None else (self.balance.cp - cg) / self.diameter

    def start(self, rocket: str, config: str, source: str) -> Configuration:
        """The design as the starting configuration of a rocket, from the file `source`; the centers of gravity and of
        pressure are those of the first simulation of the current design that has them within the rocket, or else those
        of its parts with the first of its motors that is known."""
        one = next((one for one in self.simulations if one.fresh and self._holds(one)), None)
        known = Configuration(rocket, config, self.dry_mass, self.diameter, self.length, self.cd, source)
        motor = next((found for one in self.motors if one.count == 1 and (found := one.found())), None)
        end = self.balance.mount_end if self.balance is not None else None
        if one is not None:
            dry = self._dry_cg(one.cg, motor, end)
            return replace(known, cg=one.cg, cp=one.cp, dry_cg=dry, mount_end=None if dry is None else end)
        if self.balance is None:
            return known
        known = replace(known, dry_cg=self.balance.dry_cg, mount_end=end, cp=self.balance.cp)
        if motor is None:
            return known
        return replace(known, cg=self.balance.cg(motor.loaded_mass, motor.length, self.dry_mass))

    def _dry_cg(self, cg: float | None, motor: Motor | None, mount_end: float | None) -> float | None:
        """The center of gravity without a motor, from the simulated one with the first motor of the design; None if the
        motor, its mount or the mass is not known. [m]"""
        if cg is None or motor is None or mount_end is None or not self.dry_mass:
            return None
        moment = cg * (self.dry_mass + motor.loaded_mass) - motor.loaded_mass * (mount_end - motor.length / 2)
        return moment / self.dry_mass

    def _holds(self, one: Simulation) -> bool:
        """Whether the centers of gravity and of pressure of a simulation are known and within the rocket."""
        return self.length is not None and all(x is not None and 0 < x < self.length for x in (one.cg, one.cp))


def read_design(content: bytes, source: str) -> Design:
    """Read the design in a `.ork`, `.rkt` or `.CDX1` file. Raises DamagedLog that names the file if it is damaged or
    not a design."""
    root, notes = _in_openrocket_terms(root_of(content, source), source)
    try:
        return _design(root, source, notes)
    except RecursionError as error:
        raise DamagedLog("found parts nested too deeply, expected a rocket", source=source) from error


def _in_openrocket_terms(root: "Element", source: str) -> "tuple[Element, list[str]]":
    """A design of any program as an OpenRocket one, with notes on what was not read. Raises DamagedLog for others."""
    if is_rocksim(root):
        return from_rocksim(root)
    if is_rasaero(root):
        return from_rasaero(root, source)
    if root.tag != "openrocket" or root.find("rocket") is None:
        found = f"found <{root.tag[:40]}>, expected a design of OpenRocket, RockSim or RASAero"
        raise DamagedLog(found, source=source)
    return root, []


def _design(root: "Element", source: str, notes: list[str]) -> Design:
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
    stored = simulations(root)
    weight, mass_by = _mass(rocket, stages, stored, notes)
    cd, cd_by = _drag(rocket, stages, stored, diameter, notes)
    if cd is None and weight and len(stages) == 1:
        cd, cd_by = _implied(root, weight, diameter, notes)
    if left_out := sum(map(in_several_winds, root.iterfind("simulations/simulation"))):
        notes.append(f"{counted(left_out, 'simulation')} in winds stated for several heights: not flown again here")
    if len(stages) > 1:
        notes.append(f"it has {len(stages)} stages, treated as one: staged flights are not forecast")
    if any(part.tag in ("podset", "parallelstage") for part in everything(rocket)):
        notes.append(
            "pods and boosters count for mass but not for diameter: without a Cd of the design, apogees are too high, "
            f"{PER_AREA}"
        )
    figures = {"dry_mass": weight, "diameter": diameter, "length": sum(one.length for one in body), "cd": cd}
    known = {name: _plausible(name, value, notes) for name, value in figures.items()}
    return Design(
        shown(rocket.findtext("name")),
        known["dry_mass"],
        mass_by,
        known["diameter"],
        known["length"],
        known["cd"],
        cd_by,
        tuple(_motors(rocket)),
        tuple(notes),
        tuple(stored),
        balance(stages, diameter),
        tuple(flown_again(root, weight, diameter, cd)) if weight and cd and len(stages) == 1 else (),
    )


def _plausible(name: str, value: float | None, notes: list[str]) -> float | None:
    """A value within its range; otherwise None, with a note."""
    low, high = PLAUSIBLE_RANGES[name]
    if value is None or low <= value <= high:
        return value
    notes.append(f"{name.replace('_', ' ')}: found {value:.4g}, expected {low:g} to {high:g}; it is left out")
    return None


def _mass(
    rocket: "Element", stages: "list[Element]", stored: list[Simulation], notes: list[str]
) -> tuple[float | None, str]:
    """Mass [kg] and its source: a stored simulation of the current design, otherwise the mass entered for the rocket,
    or the sum of its parts.

    A stored mass has three decimals in kg: if the other mass agrees within rounding, that is used.
    """
    unknown: list[str] = []
    whole, _ = override(rocket)
    total = whole if whole is not None else sum(mass(stage, None, unknown) for stage in stages)
    by_scale = rocket.get("program") != "RASAero"  # there, the stated mass is that of a simulation less its motor
    if by_scale and any(below for part in (rocket, *stages) for own, below in [override(part)] if own is not None):
        notes.append(
            "mass as weighed; subtract the empty motor case if it was in the rocket, "
            f"else apogees are too low, {PER_MASS}"
        )
    fresh = next((one for one in stored if one.fresh and one.dry_mass), None)
    if fresh is not None and fresh.dry_mass is not None and abs(total - fresh.dry_mass) > MASS_ROUNDING:
        if abs(total / fresh.dry_mass - 1) > 0.1:
            notes.append(f"the masses of its parts add up to {total / fresh.dry_mass:.0%} of the simulated mass")
        return fresh.dry_mass, f"the simulation {fresh.name}, less its motor"
    if unknown and fresh is None:
        notes.append(
            f"the mass of {', '.join(map(shown, unknown[:5]))} is unknown and left out: "
            f"apogees are too high, {PER_MASS}"
        )
    entered = whole is not None or all(own is not None and below for own, below in map(override, stages))
    return total or None, "the mass entered for it" if entered else "the sum of its parts"


def _drag(
    rocket: "Element", stages: "list[Element]", stored: list[Simulation], diameter: float, notes: list[str]
) -> tuple[float | None, str]:
    """Cd from an override of the whole rocket, otherwise from a stored simulation; based on the largest diameter.

    An override of a stage that does not include the parts inside is not used, because OpenRocket adds it to theirs.

    The reference area is computed from the geometry in full precision, because the stored one is rounded to one digit.
    """
    for part in (rocket, *stages):
        whole = (part.findtext("overridesubcomponentscd") or "").strip() == "true"
        if part.findtext("overridecd") is not None and whole and len(stages) == 1:
            return _on(number(part, "overridecd"), reference_diameter(rocket), diameter), "its override"
    notes += [f"the simulation {one.name} tumbles or ends before apogee: left out" for one in stored if one.upset]
    flown = [one for one in stored if one.cd]
    if not flown:
        if program := rocket.get("program"):
            why = f"that of a {program} file is not read; until it flies, it has that of other rockets"
        elif all(one.readable for one in stored):
            why = "no simulation with a drag coefficient is stored in the file; run one and save it"
        else:
            why = "the columns of its simulations are not in English; simulate and save it with OpenRocket in English"
        notes.append(f"no Cd: {why}")
        return None, ""
    one = flown[0]
    if not one.fresh:
        notes.append(
            f"the simulation {one.name} is older than the design: its Cd may be off either way, and apogees {PER_CD}"
        )
    if not one.consistent:
        notes.append(
            f"the drag force of {one.name} does not match its Cd: it was simulated with another diameter, and "
            f"apogees are off either way, {PER_CD}"
        )
    found = [_on(each.cd, each.reference, diameter) for each in flown if each.cd and each.fresh == one.fresh]
    if max(found) > (1 + REPORTED_CD_DIFFERENCE) * min(found):
        notes.append(
            f"its {len(found)} simulations have a Cd from {min(found):.2f} to {max(found):.2f}: with the first, "
            f"apogees are off either way, {PER_CD}"
        )
    return found[0], f"the coast of the simulation {one.name}"


def _implied(root: "Element", weight: float, diameter: float, notes: list[str]) -> tuple[float | None, str]:
    """The median Cd with which the rocket, of a mass [kg] and a diameter [m], reaches the stored apogees; nothing
    without one. [1]"""
    found = implied_cds(root, weight, diameter)
    if not found:
        return None, ""
    notes[:] = [note for note in notes if not note.startswith("no Cd:")]
    each = ", ".join(f"{one.cd:.2f} on {one.motor}" for one in found)
    notes.append(f"the Cd is not stored; the stored apogees imply {each}")
    return median(one.cd for one in found), f"the apogees of {counted(len(found), 'simulation')}"


def _on(cd: float, reference: float, diameter: float) -> float:
    """Convert a Cd from the area of a reference diameter to the area of the body. [1]"""
    return cd * (reference / diameter) ** 2 if reference > 0 and diameter > 0 else cd


def _motors(rocket: "Element") -> "list[DesignMotor]":
    """The motors of all configurations, at most `MOST_MOTORS`."""
    names = {one.get("configid", ""): one.findtext("name") or "" for one in rocket.iterfind("motorconfiguration")}
    held = ((one, count) for mount, count in _mounts(rocket, 1) for one in mount.iterfind("motormount/motor"))
    return [
        DesignMotor(
            shown(names.get(one.get("configid", ""), "")),
            shown(one.findtext("manufacturer")),
            shown(one.findtext("designation")),
            shown(one.findtext("delay")),
            count,
        )
        for one, count in islice(held, MOST_MOTORS)
    ]


def _mounts(part: "Element", times: int) -> "Iterator[tuple[Element, int]]":
    """A part and everything in it, each with the number of motors that it would hold: the tubes of its cluster, times
    those of the clusters, pods or boosters that contain it."""
    times *= copies(part)
    yield part, times
    for one in children(part):
        yield from _mounts(one, times)
