"""The forecast without calibration: one simulation with a certified motor and a typical drag coefficient.

It uses nothing learned from flights, so the yardstick stays the same when the model changes.

Derivation: the equations of `fieldkit.physics.flight` at nominal values.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import Flight
from fieldkit.motors import Found
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.setups import reference_area
from fieldkit.shapes import Array, Float

NOMINAL_CD = 0.6
"""Drag coefficient on the frontal area of a typical model rocket (Mandell, Caporaso and Bengen, Topics in Advanced
Model Rocketry, 1973, give 0.4 to 0.8). [1]"""


@dataclass(frozen=True, slots=True)
class Simulated:
    """A flight with its uncalibrated forecast. [m]"""

    flight: Flight
    found: Found
    simulated: float

    @property
    def ratio(self) -> float:
        """Ratio of flown to simulated apogee; nan for a flight without an apogee. [1]"""
        flown = self.flight.apogee
        return flown / self.simulated if flown is not None and self.simulated > 0 else float("nan")


def simulate(flown: Sequence[tuple[Flight, Found]]) -> list[Simulated]:
    """Every flight with the apogee that the altimeter would show at the nominal Cd and certified thrust.

    The area is the body's, or else follows from the flight's dry mass by a rule of thumb. The apogee is 0 m if the
    flight does not leave the pad. Raises ImpossibleFlight for one without a dry mass.
    """
    if not flown:
        return []
    flights, found = [flight for flight, _ in flown], [motor for _, motor in flown]
    shown = fly(field_setup(flights, found, NOMINAL_CD * reference_area(flights, 0))).readouts()["apogee"]
    apogees = np.nan_to_num(shown).tolist()
    return [Simulated(*both, apogee) for both, apogee in zip(flown, apogees, strict=True)]


def uncalibrated(_earlier: Sequence[Simulated], plan: Simulated) -> Float[Array, "draw"]:
    """The simulated apogee as a forecast without spread. [m]"""
    return np.array([plan.simulated])
