"""The ledger: flights, logs, model versions and predictions, and a journal with which every change can be undone.

SQLAlchemy Core rather than its ORM: records are frozen dataclasses with no identity to track, and Core alone saves
every command about a tenth of a second of imports.
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
