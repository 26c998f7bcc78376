"""Drag and thrust of the paper's rocket from its ensemble."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.errors import ImpossibleFlight, UnknownMotor
from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.inference.network.ensemble import load
from fieldkit.messages import amount, message
from fieldkit.model.features import paper_features
from fieldkit.physics import paper
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble


@dataclass(frozen=True, slots=True)
class Posterior:
    """Cd and thrust scale of flights, mean and standard deviation, one entry per flight; all [1]."""

    cd: Float[Array, "flight"]
    cd_sd: Float[Array, "flight"]
    alpha: Float[Array, "flight"]
    alpha_sd: Float[Array, "flight"]
    model: str


def infer_paper(flights: Sequence[Flight], ensemble: "Ensemble | None" = None) -> Posterior:
    """Cd and alpha of flights of the paper's rocket from the apogee alone, by default with the shipped ensemble.

    The standard deviation is over the members, as in the paper: it measures their disagreement, not the distance from
    the truth. Raises UnknownMotor for a motor the paper does not have, ImpossibleFlight for another rocket and for a
    flight without an apogee, DamagedModel if the ensemble cannot be loaded.
    """
    ensemble = ensemble or load("paper")
    motor = np.array([_motor_index(flight) for flight in flights], dtype=np.int64)
    dry_mass = np.array([paper_dry_mass(flight) for flight in flights])
    apogee = np.array([_apogee(flight) for flight in flights])
    mean, spread = ensemble(paper_features(apogee, motor, dry_mass))
    return Posterior(mean[:, 0], spread[:, 0], mean[:, 1], spread[:, 1], ensemble.name)


def _motor_index(flight: Flight) -> int:
    try:
        return paper.motor_index(flight.motor)
    except UnknownMotor as error:
        raise UnknownMotor(f"{flight_label(flight.flight_id)}: {error}") from None


def paper_dry_mass(flight: Flight) -> float:
    """Dry mass of a flight of the paper's rocket, as weighed or by its configuration. [kg]

    Raises ImpossibleFlight without a mass, and for one other than the two that the ensemble was trained with.
    """
    masses = paper.DRY_MASS
    found = masses.get(flight.config.strip().upper()) if flight.dry_mass is None else flight.dry_mass
    for mass in masses.values():
        if found is not None and abs(found - mass) < 5e-4:
            return found
    known = " or ".join(f"a mass of {amount(mass, 'g')} ({config})" for config, mass in masses.items())
    shown = "no dry mass" if found is None else f"a mass of {amount(found, 'g')}"
    expected = f"expected that of the paper's own rocket: {known}"
    raise ImpossibleFlight(message(f"{flight_label(flight.flight_id)}: found {shown}, {expected}"))


def _apogee(flight: Flight) -> float:
    if flight.apogee is None:
        raise ImpossibleFlight(f"{flight_label(flight.flight_id)}: no apogee, which inference needs")
    return flight.apogee
