"""The Cd that the stored summary of a simulation implies, if the file has no drag coefficient.

Derivation: the apogee falls strictly with the Cd, so the Cd at which the own simulator reaches the stored apogee, with
the same motor, mass, rod and wind, is a root that bisection finds. OpenRocket's wind is the same at every height, and
so it is here. The thrust curve is the catalog's, which may differ from that of the simulation by a few percent.
"""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.motors import Found, catalogue
from fieldkit.openrocket.parts import copies, everything, number
from fieldkit.openrocket.stored import shown
from fieldkit.physics.single import field_flight
from fieldkit.units import DEGREE

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

LOWEST_CD, HIGHEST_CD = 0.1, 3.0
"""Range of the Cd that is searched. [1]"""
CD_PRECISION = 1e-3
"""Relative precision of the Cd. [1]"""
SAME_AT_ALL_HEIGHTS = 1000.0
"""Height of the wind aloft that is given the speed at the pad. [m]"""
MOST_SUMMARIES = 30
"""Largest number of summaries that are simulated. [1]"""


@dataclass(frozen=True, slots=True)
class ImpliedCd:
    """The Cd that a simulation on a motor implies, on the diameter of the body. [1]"""

    motor: str
    cd: float


@dataclass(frozen=True, slots=True)
class FlownAgain:
    """A stored simulation beside our own with the Cd of the design: apogees [m] as stored, in a wind that is the same
    at every height, as OpenRocket's, and in one that grows with height, as fieldkit's; and the wind at the pad. [m/s]
    """

    name: str
    motor: str
    stored: float
    level_wind: float
    growing_wind: float
    wind: float

    @property
    def difference(self) -> float:
        """Our apogee over the stored one in the same wind, less one. [1]"""
        return self.level_wind / self.stored - 1


def implied_cds(root: "Element", dry_mass: float, diameter: float) -> list[ImpliedCd]:
    """The Cd of each simulation of the current design with an apogee and one motor of the catalog, for a mass without
    motor [kg] and a diameter [m]."""
    found = []
    for _, plan, motor, apogee in _flown(root, dry_mass, diameter):
        with suppress(FieldkitError, ValueError):
            if (cd := _cd(plan, motor, apogee)) is not None:
                found.append(ImpliedCd(f"{motor.motor.maker} {motor.motor.designation}", cd))
    return found


def flown_again(root: "Element", dry_mass: float, diameter: float, cd: float) -> list[FlownAgain]:
    """Each simulation of the current design with an apogee and one motor of the catalog beside our own, for a mass
    without motor [kg], a diameter [m] and a Cd. [1]"""
    found = []
    for name, plan, motor, apogee in _flown(root, dry_mass, diameter):
        with suppress(FieldkitError, ValueError):
            level = field_flight(plan, motor, cd, 1.0)["true_apogee_m"]
            rod = plan.columns.as_recorded(["rail_direction"])
            growing = field_flight(plan.with_changes(extra=rod), motor, cd, 1.0)["true_apogee_m"]
            named = f"{motor.motor.maker} {motor.motor.designation}"
            found.append(FlownAgain(name, named, apogee, level, growing, plan.wind or 0.0))
    return found


def _flown(root: "Element", dry_mass: float, diameter: float) -> Iterator[tuple[str, Flight, Found, float]]:
    """The simulations of the current design with an apogee [m] and one motor of the catalog: name, flight, motor."""
    rocket = root.find("rocket")
    assert rocket is not None
    for simulation in list(root.iterfind("simulations/simulation"))[:MOST_SUMMARIES]:
        data = simulation.find("flightdata")
        if data is None or simulation.get("status") not in ("uptodate", "loaded") or in_several_winds(simulation):
            continue
        with suppress(FieldkitError, ValueError):
            apogee = float(data.get("maxaltitude", "nan"))
            motor = _motor(rocket, simulation.findtext("conditions/configid") or "")
            if motor is not None and math.isfinite(apogee) and apogee > 0:
                yield shown(simulation.findtext("name"))[:60], _plan(simulation, dry_mass, diameter), motor, apogee


def in_several_winds(simulation: "Element") -> bool:
    """Whether a simulation flew in winds stated for several heights, which are not read."""
    return (simulation.findtext("conditions/windmodeltype") or "").casefold().startswith("multi")


def _motor(rocket: "Element", configuration: str) -> Found | None:
    """The only motor of a configuration, with its delay; None for several or none. Raises UnknownMotor."""
    held = [
        (motor, copies(part))
        for part in everything(rocket)
        for motor in part.iterfind("motormount/motor")
        if motor.get("configid", "") == configuration
    ]
    if len(held) != 1 or held[0][1] != 1:
        return None
    motor = held[0][0]
    name = shown(f"{motor.findtext('manufacturer') or ''} {motor.findtext('designation') or ''}")
    delay = (motor.findtext("delay") or "").strip()
    seconds = None if delay in ("", "none") else float(delay)
    return Found(catalogue().resolve(name).motor, seconds)


def _plan(simulation: "Element", dry_mass: float, diameter: float) -> Flight:
    """The flight of a simulation: its rod, angle, wind, site, and temperature and pressure if they are not standard."""
    conditions = simulation.find("conditions")
    assert conditions is not None
    wind = next(_winds(conditions), 0.0)
    aloft = {"wind_aloft_mps": f"{wind:g}", "wind_aloft_height_m": f"{SAME_AT_ALL_HEIGHTS:g}"} if wind else {}
    air = conditions.find("atmosphere")
    stated = air is not None and air.get("model") != "isa"
    return Flight(
        dry_mass=dry_mass,
        diameter=diameter,
        rail_length=number(conditions, "launchrodlength") or None,
        rail_angle=number(conditions, "launchrodangle") * DEGREE or None,
        site_elevation=number(conditions, "launchaltitude") or None,
        temperature=(number(air, "basetemperature") or None) if air is not None and stated else None,
        pressure=(number(air, "basepressure") or None) if air is not None and stated else None,
        wind=wind,
        extra=aloft | _rod_direction(conditions),
    )


def _rod_direction(conditions: "Element") -> dict[str, str]:
    """The direction of a slanted rod that OpenRocket did not turn into the wind, in degrees from upwind; directions of
    the wind are in radians in the file, that of the rod in degrees."""
    if (conditions.findtext("launchintowind") or "true").strip() != "false" or not number(conditions, "launchrodangle"):
        return {}
    average = next((one for one in conditions.iterfind("wind") if one.get("model") == "average"), None)
    blows_from = number(conditions, "winddirection", math.pi / 2)
    if average is not None:
        blows_from = number(average, "direction", blows_from)
    return {"rail_direction": f"{(number(conditions, 'launchroddirection') - blows_from / DEGREE) % 360:.4g}"}


def _winds(conditions: "Element") -> Iterator[float]:
    """The mean wind of a simulation, by the newer and the older element. [m/s]"""
    for model in conditions.iterfind("wind"):
        if model.get("model") == "average":
            yield number(model, "speed")
    if conditions.find("windaverage") is not None:
        yield number(conditions, "windaverage")


def _cd(plan: Flight, motor: Found, apogee: float) -> float | None:
    """The Cd with which a plan reaches an apogee [m]; None if none within the range does. [1]"""

    def height(log_cd: float) -> float:
        return field_flight(plan, motor, math.exp(log_cd), 1.0)["true_apogee_m"]

    low, high = math.log(LOWEST_CD), math.log(HIGHEST_CD)
    if not height(high) < apogee < height(low):
        return None
    while high - low > CD_PRECISION:
        middle = (low + high) / 2
        low, high = (middle, high) if height(middle) > apogee else (low, middle)
    return math.exp((low + high) / 2)
