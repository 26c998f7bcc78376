"""Drag and thrust of each flight, and why some flights have none."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from fieldkit.errors import FieldkitError, ImpossibleFlight, UnknownMotor
from fieldkit.flight import Flight
from fieldkit.flight.plausibility import implausible
from fieldkit.flight.short_name import flight_label
from fieldkit.inference.network.ensemble import load
from fieldkit.inference.network.field_ensemble import infer_field
from fieldkit.inference.network.posterior import infer_paper
from fieldkit.messages import marked, message
from fieldkit.motors import Catalogue, Found

FlightEnsemble = Literal["field", "paper"]
"""The ensembles to choose from."""


@dataclass(frozen=True, slots=True)
class Inferred:
    """Cd and thrust scale of one flight, mean and standard deviation [1], and the ensemble they come from.

    `warnings` are the reasons to doubt them.
    """

    flight: Flight
    cd: float
    cd_sd: float
    alpha: float
    alpha_sd: float
    model: str
    warnings: tuple[str, ...] = ()

    def json(self) -> dict[str, Any]:
        """The keys of the contract, and the warnings."""
        figures = {name: getattr(self, name) for name in ("cd", "cd_sd", "alpha", "alpha_sd", "model")}
        about = {"flight_id": self.flight.flight_id, "rocket": self.flight.rocket}
        return {**about, **figures, "warnings": list(self.warnings)}


@dataclass(frozen=True, slots=True)
class Inferences:
    """The results in the order of the flights, and a line for each flight that was left out."""

    inferred: tuple[Inferred, ...]
    left_out: tuple[str, ...]


def infer(flights: Sequence[Flight], motors: Catalogue, model: FlightEnsemble = "field") -> Inferences:
    """Cd and alpha of every flight that an ensemble can process. Raises DamagedModel."""
    return _paper(flights, motors) if model == "paper" else _field(flights, motors)


def _known(flights: Sequence[Flight], motors: Catalogue) -> tuple[list[tuple[Flight, Found]], list[str]]:
    """Flights that the ensemble can process, with their motors, and a line for each other flight."""
    known, left_out = list[tuple[Flight, Found]](), list[str]()
    for flight in flights:
        try:
            known.append((flight, _flyable(flight, motors)))
        except FieldkitError as error:
            left_out.append(message(f"{flight_label(flight.flight_id)}: {marked(error)}"))
    return known, left_out


def known_flights(flights: Sequence[Flight], motors: Catalogue) -> list[tuple[Flight, Found]]:
    """The flights that the field ensemble can process, each with its motor."""
    return _known(flights, motors)[0]


def _field(flights: Sequence[Flight], motors: Catalogue) -> Inferences:
    known, left_out = _known(flights, motors)
    if not known:
        return Inferences((), tuple(left_out))
    found = infer_field([flight for flight, _ in known], [motor for _, motor in known])
    inferred = [
        Inferred(
            flight,
            float(found.cd[row]),
            float(found.cd_sd[row]),
            float(found.alpha[row]),
            float(found.alpha_sd[row]),
            found.model,
            found.warnings[row],
        )
        for row, (flight, _) in enumerate(known)
    ]
    return Inferences(tuple(inferred), tuple(left_out))


def _flyable(flight: Flight, motors: Catalogue) -> Found:
    """The motor of a flight with everything that inference needs."""
    if flight.dry_mass is None:
        raise ImpossibleFlight("no dry mass, expected the rocket's mass without its motor")
    if not flight.readouts():
        raise ImpossibleFlight("no readout, expected at least the apogee")
    if not flight.motor:
        raise UnknownMotor("no motor named")
    found = motors.resolve(flight.motor)
    if reason := implausible(flight, found.motor):
        raise ImpossibleFlight(reason)
    return found


def _doubted(flight: Flight, motors: Catalogue) -> str | None:
    """Why no rocket can have made this flight; None if it is possible or the motor is unknown."""
    try:
        return implausible(flight, motors.resolve(flight.motor).motor)
    except FieldkitError:
        return None


def _paper(flights: Sequence[Flight], motors: Catalogue) -> Inferences:
    ensemble = load("paper")
    inferred, left_out = [], []
    for flight in flights:
        try:
            found = infer_paper([flight], ensemble)
        except FieldkitError as error:
            left_out.append(message(marked(error)))
            continue
        if reason := _doubted(flight, motors):
            left_out.append(message(f"{flight_label(flight.flight_id)}: {marked(reason)}"))
            continue
        cd, cd_sd, alpha, alpha_sd = (float(x[0]) for x in (found.cd, found.cd_sd, found.alpha, found.alpha_sd))
        inferred.append(Inferred(flight, cd, cd_sd, alpha, alpha_sd, found.model))
    return Inferences(tuple(inferred), tuple(left_out))
