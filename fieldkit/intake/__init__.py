"""Files into the ledger, and its files read again."""

from fieldkit.intake.again import Remeasured, recordings_of, remeasured
from fieldkit.intake.gather import Gathered, gather, read_file
from fieldkit.intake.take_in import Receipt, bring_in, take_in

__all__ = [
    "Gathered",
    "Receipt",
    "Remeasured",
    "bring_in",
    "gather",
    "read_file",
    "recordings_of",
    "remeasured",
    "take_in",
]
