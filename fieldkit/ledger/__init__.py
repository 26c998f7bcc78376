"""The ledger: flights, logs, model versions and predictions, and a journal with which every change can be undone.

It uses SQLAlchemy Core instead of the ORM: records are frozen dataclasses without identity to track, and importing only
Core saves about 0.1 s per command. Its modules are imported when one of their names is first used, so that the app can
list flights by `first_rows` before that.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fieldkit.importing.incoming import IncomingFlight
    from fieldkit.ledger.journal import Change, UndoStep
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
    "Change",
    "Conflict",
    "FlightSummary",
    "IncomingFlight",
    "Ledger",
    "NewPrediction",
    "Past",
    "Renewal",
    "StoredPrediction",
    "UndoStep",
    "Version",
]
OWNERS = {
    "IncomingFlight": "fieldkit.importing.incoming",
    "Change": "fieldkit.ledger.journal",
    "UndoStep": "fieldkit.ledger.journal",
    "Ledger": "fieldkit.ledger.ledger",
}
"""The modules of names that are not records."""


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(OWNERS.get(name, "fieldkit.ledger.records")), name)
