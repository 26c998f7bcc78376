"""Records that a ledger returns besides flights."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

from fieldkit.flight import Flight
from fieldkit.importing.incoming import IncomingFlight, Original


@dataclass(frozen=True, slots=True)
class FlightSummary:
    """A flight in a list: its id, its date, its apogee. [m]"""

    id: str
    day: date | None
    rocket: str
    config: str
    motor: str
    apogee: float | None
    tags: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Contents:
    """What is in a ledger: numbers of flights, of their rockets and of flights with a log, and the first and last day
    flown, None without a dated flight."""

    flights: int
    rockets: int
    days: tuple[date, date] | None
    with_log: int


@dataclass(frozen=True, slots=True)
class Conflict:
    """A flight that was not added, and the reason, in one line."""

    incoming: IncomingFlight
    error: str


@dataclass(frozen=True, slots=True)
class Added:
    """The result of adding flights to a ledger; `new` are their ids."""

    new: tuple[str, ...] = ()
    duplicates: int = 0
    conflicts: tuple[Conflict, ...] = ()


@dataclass(frozen=True, slots=True)
class Renewal:
    """An update of a flight whose files were read again: its content then and now, its content as imported if it was
    edited since, and additional files. Fields that were changed in the ledger in the meantime stay as they are."""

    id: str
    was: Flight
    flight: Flight
    entered: Flight | None = None
    others: tuple[Original, ...] = ()


@dataclass(frozen=True, slots=True)
class Version:
    """A saved model version of one rocket; the format of `payload` is up to the caller."""

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
    """A saved prediction; `digest` covers all of its inputs."""

    number: int
    at: datetime
    rocket: str
    flight_id: str
    digest: str
    payload: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Past:
    """A rocket's flights, in order, and the active model's number at that time, 0 for the plain model."""

    flights: tuple[Flight, ...]
    version: int
