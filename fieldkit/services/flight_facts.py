"""What is computed for one flight: the drag and thrust inferred from its readouts, and its forecast."""

from dataclasses import dataclass

import numpy as np

from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import Flight
from fieldkit.forecast.prediction import model_in_words
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.quantities import area_unit, counted
from fieldkit.services.forecasts import forecast_from_others
from fieldkit.services.inferred import FlightInference, draws, inferable, warnings
from fieldkit.services.one_offs import Comparisons
from fieldkit.services.saved_forecasts import of_flight
from fieldkit.shapes import Array, Float

DRAWS = 4000
"""Number of draws of a posterior for its plot. [1]"""


@dataclass(frozen=True, slots=True)
class DragFacts:
    """A flight's Cd (or drag area, if the diameter is not known) and thrust factor, and doubts about them."""

    drag: Float[Array, "draw"]
    drag_name: str
    thrust: Float[Array, "draw"]
    warnings: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ForecastFacts:
    """The forecast apogee at 5, 50 and 95% [m], with its source and time."""

    low: float
    middle: float
    high: float
    by: str


def drag_facts(flight: Flight, ledger: Ledger, motors: Catalogue, system: str = "SI") -> DragFacts:
    """The posterior from a single flight, an area in the unit of a system. Raises FieldkitError if there is none."""
    inferable(flight, motors)
    (answer,) = FlightInference(ledger, motors).answers([flight])
    area, thrust = draws(flight, answer, DRAWS)
    doubts = warnings(flight, answer)
    if flight.diameter:
        return DragFacts(area / (np.pi / 4 * flight.diameter**2), "Cd", thrust, doubts)
    unit, factor = area_unit(system)
    return DragFacts(area / factor, f"drag area {unit}", thrust, doubts)


def forecast_facts(
    flight: Flight, ledger: Ledger, motors: Catalogue, comparisons: Comparisons, system: str = "SI"
) -> ForecastFacts:
    """The forecast saved before a flight, or else what the other flights lead to expect, as on the other pages; figures
    in the text are in the units of a system. Raises FieldkitError if there is none."""
    kept = of_flight(ledger, motors, flight)
    if kept is not None:
        model = model_in_words(str(kept.made.payload.get("model", "")))
        by = f"forecast of {kept.made.at.astimezone():%Y-%m-%d %H:%M}, {model}"
        return ForecastFacts(
            *kept.interval, "\n".join([by, *(f"stale: {change}" for change in kept.changes_in(system))])
        )
    if not flight.motor:
        raise ImpossibleFlight("the flight has no motor; press e to enter one, such as F24-4W")
    beside = [one for one in comparisons.of(ledger, motors, flight.rocket) if one.flight.flight_id == flight.flight_id]
    if beside and (interval := beside[0].interval) is not None:
        return ForecastFacts(*interval, "none saved; what the other flights lead to expect")
    made = forecast_from_others(ledger, motors, flight)
    others = counted(made.rests_on, "other normal flight")
    return ForecastFacts(*made.apogee_quantiles(), f"none saved; computed from {others}")
