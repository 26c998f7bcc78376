"""One flight in the units flyers read."""

from collections.abc import Iterable

import numpy as np

from fieldkit import units
from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import BY_NAME
from fieldkit.simulator import paper
from fieldkit.simulator.flight import fly
from fieldkit.simulator.state import Flown

ASCENT = ("apogee", "top_speed", "burn_time", "peak_accel", "avg_accel", "coast_to_apogee")
"""The readouts that the paper's physics reaches: it ends at apogee."""


def paper_flight(motor: str, dry_mass: float, diameter: float, cd: float, alpha: float) -> dict[str, float]:
    """One flight in the paper's physics, from a motor as the paper prints it, dry mass [kg], diameter [m].

    Raises UnknownMotor, and ImpossibleFlight where the motor does not lift the rocket.
    """
    setup = paper.paper_setup(
        np.array([paper.motor_index(motor)]), np.array([dry_mass]), np.array([cd]), np.array([alpha]), diameter
    )
    flown = fly(setup)
    if not flown.lift_off[0]:
        raise ImpossibleFlight(f"{motor} at alpha {alpha:g} does not lift {1e3 * dry_mass:g} g off the pad")
    return at_the_edge(flown, ASCENT)


def at_the_edge(flown: Flown, names: Iterable[str], draw: int = 0) -> dict[str, float]:
    """Readouts of one draw by column, unit and all (`apogee_m`); those that have no value are left out."""
    readouts = flown.readouts()
    found = {BY_NAME[name]: float(readouts[name].reshape(-1)[draw]) for name in names}
    return {
        column.header: units.unit(column.quantity, column.unit).from_si(value)
        for column, value in found.items()
        if np.isfinite(value)
    }
