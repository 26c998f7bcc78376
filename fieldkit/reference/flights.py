"""The paper's twelve flights, its published results, and the thrust curves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldkit.flight import Flight
from fieldkit.importing.read import read
from fieldkit.motors import catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.physics import paper
from fieldkit.physics.flight import apogees
from fieldkit.physics.thrust_steps import Burns, burns
from fieldkit.shapes import Array, Flags, Float, Int

STATED_FIGURES = {
    "cd_mae": 0.088,
    "alpha_mae": 0.071,
    "mae_m": 12.3,
    "rmse_m": 14.0,
    "bias_m": 12.3,
    "openrocket_mae_m": 19.9,
    "openrocket_rmse_m": 23.1,
}
"""Figures from the paper's text."""

CERTIFIED_NAMES = ("Quest E35W", "AeroTech F24W", "AeroTech F39T")
"""The paper's motors, in its order, as certified."""
NOMINAL_CD = 0.52
"""The paper's drag coefficient before any flight. [1]"""


@dataclass(frozen=True, slots=True)
class Reference:
    """Flights of the paper's rocket as arrays, SI units; `published_*` are the paper's results for them."""

    flights: tuple[Flight, ...]
    motor: Int[Any, "flight"]
    dry_mass: Float[Array, "flight"]
    apogee: Float[Array, "flight"]
    valid: Flags
    published_apogee: Float[Array, "flight"]
    published_openrocket: Float[Array, "flight"]
    published_cd: Float[Array, "flight"]
    published_alpha: Float[Array, "flight"]

    def __len__(self) -> int:
        return len(self.flights)

    def part(self, rows: Flags | Int[Any, "row"]) -> "Reference":
        """The selected flights."""
        numbers = np.arange(len(self))[rows]
        arrays = {name: getattr(self, name)[numbers] for name in self.__slots__ if name != "flights"}
        return Reference(flights=tuple(self.flights[number] for number in numbers), **arrays)


def reference() -> Reference:
    """The twelve reference flights."""
    flights = read(REFERENCE_FLIGHTS.read_bytes(), REFERENCE_FLIGHTS.name, lambda name: None).flights

    def column(name: str) -> Array:
        return np.array([float(flight.text(name)) for flight in flights])

    return Reference(
        flights=flights,
        motor=np.array([paper.motor_index(flight.motor) for flight in flights]),
        dry_mass=np.array([flight.number("dry_mass") for flight in flights], float),
        apogee=np.array([flight.number("apogee") for flight in flights], float),
        valid=np.array([flight.clean for flight in flights]),
        published_apogee=column("published_apogee_m"),
        published_openrocket=column("published_openrocket_m"),
        published_cd=column("published_cd"),
        published_alpha=column("published_alpha"),
    )


def normalised() -> Burns:
    """The paper's profile scaled to the total impulse in the paper."""
    scales = [motor.total_impulse / motor.delivered_impulse for motor in paper.MOTORS]
    scaled = [
        replace(motor, peak_thrust=scale * motor.peak_thrust, mean_thrust=scale * motor.mean_thrust)
        for motor, scale in zip(paper.MOTORS, scales, strict=True)
    ]
    return burns(scaled, steps=8, linear_burn=True)


def certified(*, casing: bool = False) -> Burns:
    """The certified thrust curves and propellant masses of the paper's motors, with or without the casing."""
    motors = [catalogue().find(name).motor for name in CERTIFIED_NAMES]
    return burns(motors if casing else [replace(motor, casing_mass=0.0) for motor in motors])


def heights(
    flights: Reference, cd: Float[Array, "flight"], alpha: Float[Array, "flight"], curves: Burns
) -> Float[Array, "flight"]:
    """Apogees in the paper's physics, each flight with a separate Cd and alpha. [m]"""
    return apogees(paper.paper_setup(flights.motor, flights.dry_mass, cd, alpha, curves=curves))


def height_grid(
    flights: Reference, cd: Float[Array, "cd"], alpha: Float[Array, "alpha"], curves: Burns
) -> Float[Array, "flight cd alpha"]:
    """Apogees in the paper's physics, each flight with every Cd and alpha. [m]"""
    motor, mass = flights.motor[:, None, None], flights.dry_mass[:, None, None]
    return apogees(paper.paper_setup(motor, mass, cd[:, None], alpha, curves=curves))


def errors(forecast: Sequence[float] | Float[Array, "flight"], measured: Float[Array, "flight"]) -> dict[str, float]:
    """Mean absolute error, root mean square, bias, and the standard error of the first. [m]"""
    residual = np.asarray(forecast) - measured
    miss = np.abs(residual)
    return {
        "mae_m": float(miss.mean()),
        "rmse_m": float(np.sqrt((residual**2).mean())),
        "bias_m": float(residual.mean()),
        "standard_error_m": float(miss.std(ddof=1) / np.sqrt(len(miss))),
        "n": len(miss),
    }
