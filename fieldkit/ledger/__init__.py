"""The ledger: flights, logs, model versions and predictions, and a journal with which every change can be undone.

It uses SQLAlchemy Core instead of the ORM: records are frozen dataclasses without identity to track, and importing only
Core saves about 0.1 s per command.
"""

from fieldkit.importing.incoming import Arrival
from fieldkit.ledger.journal import Change
from fieldkit.ledger.ledger import Ledger
from fieldkit.ledger.records import (
    Added,
    Conflict,
    FlightSummary,
    NewPrediction,
    Past,
    Renewal,
    StoredPrediction,
    Version,
)

__all__ = [
    "Added",
    "Arrival",
    "Change",
    "Conflict",
    "FlightSummary",
    "Ledger",
    "NewPrediction",
    "Past",
    "Renewal",
    "StoredPrediction",
    "Version",
]
