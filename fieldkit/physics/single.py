"""Simulate one flight, in the units that flyers use."""

from collections.abc import Iterable

import numpy as np

from fieldkit import units
from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import BY_NAME, READOUTS, Flight
from fieldkit.motors import Found
from fieldkit.physics import paper
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.setups import recorded
from fieldkit.physics.state import FlightResult, Setup

ASCENT = ("apogee", "top_speed", "burn_time", "peak_accel", "avg_accel", "coast_to_apogee")
"""The readouts that the paper's physics computes; it ends at apogee."""


def paper_flight(plan: Flight, cd: float, alpha: float) -> dict[str, float]:
    """Simulate one flight in the paper's physics. Returns readouts by column; `cd` and `alpha` are the drag coefficient
    and the thrust factor [1]; `plan` has motor, dry mass and diameter.

    Raises UnknownMotor, and ImpossibleFlight if the motor does not lift the rocket or required values are missing.
    """
    dry_mass, diameter = _body(plan)
    motor = np.array([paper.motor_index(plan.motor)])
    setup = paper.paper_setup(motor, np.array([dry_mass]), np.array([cd]), np.array([alpha]), diameter)
    return at_the_edge(_flown(setup, plan.motor), ASCENT)


def field_flight(plan: Flight, found: Found, cd: float, alpha: float) -> dict[str, float]:
    """Simulate one flight in the field physics. Returns all defined readouts by column, as an altimeter would read
    them, the true apogee above the pad, `true_apogee_m`, and the speeds off the rail and at the ejection.

    `cd` and `alpha` are the drag coefficient and the thrust factor [1]; `plan` has dry mass, diameter and whatever
    conditions are known. The rocket is assumed to turn fully into a recorded wind. Raises ImpossibleFlight if the motor
    does not lift the rocket or required values are missing.
    """
    _, diameter = _body(plan)
    setup = field_setup([plan], [found], np.array([cd * np.pi / 4 * diameter**2]), np.array([alpha]))
    wind = np.nan_to_num(recorded([plan], "wind"), nan=0.0)
    flown = _flown(setup.with_changes(wind=wind), plan.motor)
    shown = at_the_edge(flown, [column.name for column in READOUTS])
    more = {"true_apogee_m": flown.apogee, "rail_speed_mps": flown.rail_speed, "eject_speed_mps": flown.eject_speed}
    values = {name: float(np.reshape(value, -1)[0]) for name, value in more.items()}
    return shown | {name: value for name, value in values.items() if np.isfinite(value)}


def _body(plan: Flight) -> tuple[float, float]:
    """Dry mass [kg] and diameter [m]."""
    if plan.dry_mass is None or plan.diameter is None:
        raise ImpossibleFlight("found no dry mass or no diameter, expected both")
    return plan.dry_mass, plan.diameter


def _flown(setup: Setup, motor: str) -> FlightResult:
    flown = fly(setup)
    if not flown.lift_off.all():
        raise ImpossibleFlight(
            f"{motor} at a thrust factor of {setup.thrust_factor.max():g} does not lift the rocket off the pad"
        )
    return flown


def at_the_edge(flown: FlightResult, names: Iterable[str]) -> dict[str, float]:
    """Readouts of the first draw by column name with its unit (`apogee_m`); readouts that are undefined or not
    simulated are omitted."""
    readouts = flown.readouts()
    found = {BY_NAME[name]: float(readouts[name].reshape(-1)[0]) for name in names if name in readouts}
    return {
        column.header: units.unit(column.quantity, column.unit).from_si(value)
        for column, value in found.items()
        if np.isfinite(value)
    }
