"""The latest flights as the app lists them, and a quick look at them while the engine is imported."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fieldkit.flight import Flight
from fieldkit.ledger.first_rows import first_rows

if TYPE_CHECKING:
    from fieldkit.services.saved_forecasts import SavedForecast

MAX_LISTED_FLIGHTS = 50


@dataclass(frozen=True, slots=True)
class ListedFlight:
    """A flight of the ledger with its id, and its saved forecast, if any."""

    id: str
    flight: Flight
    forecast: "SavedForecast | None"
    expected: tuple[float, float, float] | None = None
    """The apogee to expect from the other flights at 5, 50 and 95%, shown for a flight without a saved forecast. [m]"""

    @property
    def interval(self) -> tuple[float, float, float] | None:
        """The saved forecast, or else what the other flights lead to expect. [m]"""
        return self.expected if self.forecast is None else self.forecast.interval

    @property
    def miss(self) -> float | None:
        """Flown minus the middle of `interval`. [m]"""
        if self.forecast is not None and self.forecast.miss is not None:
            return self.forecast.miss
        return None if self.expected is None or self.flight.apogee is None else self.flight.apogee - self.expected[1]


def listed_at_once(where: str | Path | None) -> list[ListedFlight]:
    """The latest flights of a ledger, newest first, without their forecasts; empty if they take longer to read."""
    return [ListedFlight(id, flight, None) for id, flight in first_rows(where, MAX_LISTED_FLIGHTS)]
