"""What each of any flights says about drag and thrust, and why some say nothing."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight

Model = Literal["paper"]
"""The ensembles that flights can be shown to."""


@dataclass(frozen=True, slots=True)
class Inferred:
    """Cd and thrust scale of one flight, mean and standard deviation [1], and the ensemble that said so."""

    flight: Flight
    cd: float
    cd_sd: float
    alpha: float
    alpha_sd: float
    model: str

    def json(self) -> dict[str, Any]:
        """The keys of the contract."""
        figures = {name: getattr(self, name) for name in ("cd", "cd_sd", "alpha", "alpha_sd", "model")}
        return {"flight_id": self.flight.flight_id, "rocket": self.flight.rocket, **figures}


@dataclass(frozen=True, slots=True)
class Inferences:
    """What was inferred, in the order of the flights, and a line for each flight that was left out."""

    inferred: tuple[Inferred, ...]
    left_out: tuple[str, ...]


def infer(flights: Sequence[Flight], model: Model = "paper") -> Inferences:
    """Cd and alpha of every flight that an ensemble can judge. Raises DamagedModel."""
    judge = _JUDGES[model]()
    inferred, left_out = [], []
    for flight in flights:
        try:
            inferred.append(judge(flight))
        except FieldkitError as error:
            left_out.append(str(error))
    return Inferences(tuple(inferred), tuple(left_out))


def _paper() -> Callable[[Flight], Inferred]:
    from fieldkit.inference.ensemble import load
    from fieldkit.inference.posterior import infer_paper

    ensemble = load("paper")

    def judge(flight: Flight) -> Inferred:
        found = infer_paper([flight], ensemble)
        columns = (found.cd, found.cd_sd, found.alpha, found.alpha_sd)
        cd, cd_sd, alpha, alpha_sd = (float(column[0]) for column in columns)
        return Inferred(flight, cd, cd_sd, alpha, alpha_sd, found.model)

    return judge


_JUDGES: dict[str, Callable[[], Callable[[Flight], Inferred]]] = {"paper": _paper}
