"""Drag and thrust of single flights, from the forecast model or from an ensemble with a separate prior.

Each flight is used alone, with the message of the user's other rockets: the history network gets a history with one
flight. The field ensemble, which uses only the flight, warns about readouts far from its training data.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from fieldkit.errors import NoFlights
from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.forecast.at_once import each_at_once
from fieldkit.inference.network.flights import Inferences, Inferred, infer
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.physics.setups import reference_area
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.services.fleet import fleet_priors
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.inference.network.history import QuickAnswer
    from fieldkit.model.shared_prior import SharedPrior

InferenceModel = Literal["history", "field", "paper"]
"""The available models: the history network, the field ensemble, the reference paper's ensemble."""
FIT_FRACTION = 0.5
"""Fraction of the progress for fitting the other rockets if none is cached. [1]"""


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
    model: InferenceModel = "history",
    on_progress: ReportProgress = no_op,
) -> InferredFlights:
    """Cd and alpha of flights of a ledger, by default of all. Raises NoFlights, DamagedModel."""
    flights = ledger.flights(ids=ids or None)
    names = {(one.rocket, one.flight_id): id for one, id in zip(flights, ledger.ids(flights), strict=True)}
    if not flights:
        raise NoFlights(f"{ledger.name}: found no flights, expected at least one; import or add flights first")
    found = (
        FlightInference(ledger, motors).infer(flights, on_progress)
        if model == "history"
        else infer(flights, motors, model)
    )
    own = [names[one.flight.rocket, one.flight.flight_id] for one in found.inferred]
    return InferredFlights(found.inferred, own, found.left_out)


class FlightInference:
    """Runs the network on flights of a ledger; the message of the other rockets is computed once per rocket."""

    def __init__(self, ledger: Ledger, motors: Catalogue) -> None:
        self._ledger, self._motors = ledger, motors
        self._shared: dict[str, SharedPrior | None] = {}

    def infer(self, flights: Sequence[Flight], on_progress: ReportProgress = no_op) -> Inferences:
        """Cd and alpha of each usable flight; Cd is nan without a diameter. Raises DamagedModel."""
        guarded = infer(flights, self._motors, "field")
        asked = [one.flight for one in guarded.inferred]
        answers = self.answers(asked, on_progress)
        inferred, left_out = [], list(guarded.left_out)
        for one, answer in zip(guarded.inferred, answers, strict=True):
            if np.isfinite([*answer.log_cd, *answer.log_alpha]).all():
                inferred.append(_with_answer(one, answer))
            else:
                left_out.append(f"{flight_label(one.flight.flight_id)}: its readouts are inconsistent")
        return Inferences(tuple(inferred), tuple(left_out))

    def answers(self, flights: Sequence[Flight], on_progress: ReportProgress = no_op) -> "list[QuickAnswer]":
        """The network's answer for each flight alone; `infer` must not leave out any. Raises ImpossibleFlight for a
        flight without a dry mass, BadValue for a recovery figure or rail direction that cannot be read, DamagedModel if
        the hyperprior or the network cannot be read.
        """

        rockets = [name for name in dict.fromkeys(flight.rocket for flight in flights) if name not in self._shared]
        if rockets:
            self._shared |= fleet_priors(self._ledger, self._motors, rockets, part(on_progress, 0.0, FIT_FRACTION))
        shared = [self._shared[flight.rocket] for flight in flights]
        on_progress("inferring", FIT_FRACTION)
        return each_at_once([(flight, self._motors.resolve(flight.motor)) for flight in flights], shared)


def _with_answer(one: Inferred, answer: "QuickAnswer") -> Inferred:
    cd, cd_sd = _log_normal(*answer.log_cd) if one.flight.diameter else (np.nan, np.nan)
    alpha, alpha_sd = _log_normal(*answer.log_alpha)
    return replace(one, cd=cd, cd_sd=cd_sd, alpha=alpha, alpha_sd=alpha_sd, model=answer.model)


def _log_normal(mean: float, sd: float) -> tuple[float, float]:
    """Mean and standard deviation of a log-normal distribution, from those of the logarithm."""
    middle = float(np.exp(mean + sd**2 / 2))
    return middle, middle * float(np.sqrt(np.expm1(sd**2)))


def draws(flight: Flight, answer: "QuickAnswer", count: int) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
    """The network's draws of a flight's drag area [m^2] and thrust factor [1]. Raises ImpossibleFlight for a flight
    without a dry mass.
    """
    sds = np.array([answer.log_cd[1], answer.log_alpha[1]])
    covariance = np.outer(sds, sds) * np.array([[1.0, answer.correlation], [answer.correlation, 1.0]])
    means = (answer.log_cd[0], answer.log_alpha[0])
    log_cd, log_alpha = np.random.default_rng(0).multivariate_normal(means, covariance, count).T
    return np.exp(log_cd) * reference_area([flight])[0], np.exp(log_alpha)
