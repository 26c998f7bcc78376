"""The history network on the paper's flights: each is forecast from all other valid ones."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.motors import catalogue
from fieldkit.reference.flights import Reference, errors


@dataclass(frozen=True, slots=True)
class HistoryForecast:
    """The network's leave-one-out forecast of one flight: apogee at 5, 50 and 95% [m], and the median Cd and alpha
    [1]."""

    flight_id: str
    apogee: tuple[float, float, float]
    cd: float
    alpha: float

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        low, middle, high = self.apogee
        return {
            "flight_id": self.flight_id,
            "apogee_m": {"p05": low, "p50": middle, "p95": high},
            "cd": self.cd,
            "alpha": self.alpha,
        }


def history_forecasts(flights: Reference) -> list[HistoryForecast]:
    """Forecasts of every flight from all other valid flights, in the order flown."""
    flown = [(flight, catalogue().resolve(flight.motor)) for flight in flights.flights]
    found = []
    for row, (flight, motor) in enumerate(flown):
        others = [one for other, one in enumerate(flown) if flights.valid[other] and other != row]
        plan = flight.unflown(sd={}, source={}, tags=())
        forecast = forecast_at_once(others, (plan, motor))
        low, middle, high = (forecast.apogee_at(level) for level in (0.05, 0.5, 0.95))
        cd, alpha = (float(np.exp(mean)) for mean, _ in (forecast.log_cd, forecast.log_alpha))
        found.append(HistoryForecast(flight.flight_id, (low, middle, high), cd, alpha))
    return found


def history_errors(flights: Reference, found: list[HistoryForecast]) -> dict[str, float]:
    """Errors of the medians over the valid flights [m], and the fraction of these in their 90% intervals. [1]"""
    low, middle, high = np.array([one.apogee for one in found])[flights.valid].T
    flown = flights.apogee[flights.valid]
    return {**errors(middle, flown), "coverage90": float(((low <= flown) & (flown <= high)).mean())}
