"""What a ledger hands out besides flights."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

from fieldkit.flight import Flight
from fieldkit.importing.incoming import Arrival, Original


@dataclass(frozen=True, slots=True)
class FlightSummary:
    """What a list shows of a flight: the id that names it, its day, its apogee. [m]"""

    id: str
    day: date | None
    rocket: str
    config: str
    motor: str
    apogee: float | None
    tags: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Conflict:
    """A flight that was not added, and the reason, in one line."""

    arrival: Arrival
    error: str


@dataclass(frozen=True, slots=True)
class Added:
    """The result of adding flights to a ledger; `new` are their ids."""

    new: tuple[str, ...] = ()
    duplicates: int = 0
    conflicts: tuple[Conflict, ...] = ()


@dataclass(frozen=True, slots=True)
class Renewal:
    """A flight whose files are read again: its new content, its content as imported if it was edited since, more
    files."""

    id: str
    flight: Flight
    entered: Flight | None = None
    others: tuple[Original, ...] = ()


@dataclass(frozen=True, slots=True)
class Version:
    """A saved model version of one rocket; `payload` belongs to the caller that made it."""

    rocket: str
    number: int
    at: datetime
    payload: Mapping[str, Any]
    active: bool


@dataclass(frozen=True, slots=True)
class NewPrediction:
    """A prediction to save, as in `StoredPrediction`."""

    payload: Mapping[str, Any]
    digest: str
    rocket: str
    flight_id: str


@dataclass(frozen=True, slots=True)
class StoredPrediction:
    """A prediction as it was made; `digest` is of everything it was made from."""

    number: int
    at: datetime
    rocket: str
    flight_id: str
    digest: str
    payload: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Past:
    """A rocket's flights, in order, and the number of the model in use at a time, 0 for the plain one."""

    flights: tuple[Flight, ...]
    version: int
