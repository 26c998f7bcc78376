"""From the bytes of a log or a table to flights.

A parser recognizes a log and reads it into `Reading`s, which contain only what the log states. Steps common to all
loggers are here: limits, motor names, IDs, duplicate flights, and rockets described in another file. The records are
imported when one of their names is first used: a command that only lists flights needs none of them.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fieldkit.importing.reading import (
        HEAD,
        MOST_FLIGHTS,
        ColumnChoice,
        ImportedFile,
        Mapped,
        Note,
        Parsed,
        Parser,
        Reading,
        Rejected,
    )

__all__ = [
    "HEAD",
    "MOST_FLIGHTS",
    "ColumnChoice",
    "ImportedFile",
    "Mapped",
    "Note",
    "Parsed",
    "Parser",
    "Reading",
    "Rejected",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("fieldkit.importing.reading"), name)
