"""Drag and thrust of single flights, from the forecast model or from the reference paper's ensemble.

Each flight is used alone, with the message of the user's other rockets: in one linear pass over a history of one
flight. Warnings come from the model's prior for this rocket and motor.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fieldkit.errors import FieldkitError, ImpossibleFlight, NoFlights, UnknownMotor
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.plausibility import implausible
from fieldkit.flight.short_name import flight_label
from fieldkit.forecast.at_once import each_at_once
from fieldkit.inference.history.prior_predictive import InconsistentReadout, inconsistent_readout, without_data
from fieldkit.inference.history.quick_forecast import MODEL
from fieldkit.inference.network.ensemble import load
from fieldkit.inference.network.posterior import infer_paper
from fieldkit.ledger import Ledger
from fieldkit.messages import marked, message, of_column
from fieldkit.motors import Catalogue, Found
from fieldkit.physics.setups import reference_area
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.services.fleet import fleet_priors
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.inference.history.quick_forecast import QuickAnswer
    from fieldkit.model.shared_prior import SharedPrior

InferenceModel = Literal["field", "paper"]
"""The available models: that of forecasts, the reference paper's ensemble."""
FIT_FRACTION = 0.5
"""Fraction of the progress for fitting the other rockets if none is cached. [1]"""
UNINFORMATIVE_SD_RATIO = 0.8
"""If posterior over prior standard deviation is above this, the flight barely constrains the parameter. [1]"""


@dataclass(frozen=True, slots=True)
class Inferred:
    """Cd and thrust scale of one flight, mean and standard deviation [1], and the model they come from.

    Without a diameter there is no Cd. `warnings` are the reasons to doubt them.
    """

    flight: Flight
    cd: float | None
    cd_sd: float | None
    alpha: float
    alpha_sd: float
    model: str
    warnings: tuple[str, ...] = ()

    def json(self) -> dict[str, Any]:
        """The keys of the contract, the warnings, and whether a fit is still to check the figures."""
        figures = {name: getattr(self, name) for name in ("cd", "cd_sd", "alpha", "alpha_sd", "model")}
        about = {"flight_id": self.flight.flight_id, "rocket": self.flight.rocket}
        return {**about, **figures, "provisional": self.model == MODEL, "warnings": list(self.warnings)}


@dataclass(frozen=True, slots=True)
class Inferences:
    """The results in the order of the flights, and a line for each flight that was left out."""

    inferred: tuple[Inferred, ...]
    left_out: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InferredFlights:
    """The inferred flights with their ids, and the reasons for leaving out others."""

    inferred: Sequence[Inferred]
    ids: Sequence[str]
    left_out: Sequence[str]

    def warnings(self) -> Iterator[tuple[str, list[str]]]:
        """Every warning, and its flights."""
        for warning in dict.fromkeys(line for one in self.inferred for line in one.warnings):
            yield warning, [id for id, one in zip(self.ids, self.inferred, strict=True) if warning in one.warnings]


def infer_flights(
    ledger: Ledger,
    motors: Catalogue,
    ids: Sequence[str],
    model: InferenceModel = "field",
    on_progress: ReportProgress = no_op,
) -> InferredFlights:
    """Cd and alpha of flights of a ledger, by default of all. Raises NoFlights, DamagedModel."""
    flights = ledger.flights(ids=ids or None)
    names = {(one.rocket, one.flight_id): id for one, id in zip(flights, ledger.ids(flights), strict=True)}
    if not flights:
        raise NoFlights(f"{ledger.name}: found no flights, expected at least one; import or add flights first")
    found = (
        FlightInference(ledger, motors).infer(flights, on_progress)
        if model == "field"
        else infer_by_paper(flights, motors)
    )
    own = [names[one.flight.rocket, one.flight.flight_id] for one in found.inferred]
    return InferredFlights(found.inferred, own, found.left_out)


class FlightInference:
    """Inference from single flights of a ledger; the message of the other rockets is computed once per rocket."""

    def __init__(self, ledger: Ledger, motors: Catalogue) -> None:
        self._ledger, self._motors = ledger, motors
        self._shared: dict[str, SharedPrior | None] = {}

    def infer(self, flights: Sequence[Flight], on_progress: ReportProgress = no_op) -> Inferences:
        """Cd and alpha of each usable flight; Cd is nan without a diameter. Raises DamagedModel."""
        asked, left_out = list[Flight](), list[str]()
        for flight in flights:
            try:
                inferable(flight, self._motors)
            except FieldkitError as error:
                left_out.append(message(f"{flight_label(flight.flight_id)}: {marked(error)}"))
            else:
                asked.append(flight)
        inferred = []
        for flight, answer in zip(asked, self.answers(asked, on_progress), strict=True):
            if np.isfinite([*answer.log_cd, *answer.log_alpha]).all():
                inferred.append(_with_answer(flight, answer))
            else:
                left_out.append(f"{flight_label(flight.flight_id)}: its readouts are inconsistent")
        return Inferences(tuple(inferred), tuple(left_out))

    def answers(self, flights: Sequence[Flight], on_progress: ReportProgress = no_op) -> "list[QuickAnswer]":
        """The answer for each flight alone; `infer` must not leave out any. Raises ImpossibleFlight for a flight
        without a dry mass, DamagedModel if the hyperprior cannot be read."""

        rockets = [name for name in dict.fromkeys(flight.rocket for flight in flights) if name not in self._shared]
        if rockets:
            self._shared |= fleet_priors(self._ledger, self._motors, rockets, part(on_progress, 0.0, FIT_FRACTION))
        shared = [self._shared[flight.rocket] for flight in flights]
        on_progress("inferring", FIT_FRACTION)
        return each_at_once([(flight, self._motors.resolve(flight.motor)) for flight in flights], shared)


def inferable(flight: Flight, motors: Catalogue) -> Found:
    """The motor of a flight that has what inference needs. Raises ImpossibleFlight or UnknownMotor for another one."""
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


def infer_by_paper(flights: Sequence[Flight], motors: Catalogue) -> Inferences:
    """Cd and alpha of each flight by the reference paper's ensemble. Raises DamagedModel."""
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


def _doubted(flight: Flight, motors: Catalogue) -> str | None:
    """Why no rocket can have made this flight; None if it is possible or the motor is unknown."""
    try:
        return implausible(flight, motors.resolve(flight.motor).motor)
    except FieldkitError:
        return None


def _with_answer(flight: Flight, answer: "QuickAnswer") -> Inferred:
    cd, cd_sd = _log_normal(*answer.log_cd) if flight.diameter else (None, None)
    alpha, alpha_sd = _log_normal(*answer.log_alpha)
    return Inferred(flight, cd, cd_sd, alpha, alpha_sd, MODEL, warnings(flight, answer))


def warnings(flight: Flight, answer: "QuickAnswer") -> tuple[str, ...]:
    """The reasons to doubt the answer for a single flight: an inconsistent readout, and what the flight does
    not constrain."""
    lines = []
    linear = answer.linear
    if found := inconsistent_readout(linear):
        lines.append(_inconsistent(found))
    seen = answer.data.seen[0]
    if seen[0] and seen.sum() == 1:
        lines.append(
            "apogee alone cannot separate drag from thrust: the thrust factor is mostly that of the motor's certificate"
        )
    if answer.log_cd[1] > UNINFORMATIVE_SD_RATIO * without_data(linear).cd_sd[answer.plan]:
        lines.append("this flight barely constrains drag")
    if flight.diameter is None:
        lines.append("no diameter: only the drag area is inferred, and no Cd")
    return tuple(lines)


def _inconsistent(found: InconsistentReadout) -> str:
    column, others = BY_NAME[found.name], "" if found.alone else " and the rest of the flight"
    value, usual = of_column(column, found.value, digits=3), of_column(column, found.low, found.high, 3)
    what = f"{column.title.lower()} of {value} is inconsistent with the motor, the mass{others}"
    return message(f"{what}, expected {usual}")


def _log_normal(mean: float, sd: float) -> tuple[float, float]:
    """Mean and standard deviation of a log-normal distribution, from those of the logarithm."""
    middle = float(np.exp(mean + sd**2 / 2))
    return middle, middle * float(np.sqrt(np.expm1(sd**2)))


def draws(flight: Flight, answer: "QuickAnswer", count: int) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
    """Draws of a flight's drag area [m^2] and thrust factor [1]. Raises ImpossibleFlight for a flight
    without a dry mass.
    """
    sds = np.array([answer.log_cd[1], answer.log_alpha[1]])
    covariance = np.outer(sds, sds) * np.array([[1.0, answer.correlation], [answer.correlation, 1.0]])
    means = (answer.log_cd[0], answer.log_alpha[0])
    log_cd, log_alpha = np.random.default_rng(0).multivariate_normal(means, covariance, count).T
    return np.exp(log_cd) * reference_area([flight])[0], np.exp(log_alpha)
