"""Importing files into the ledger, and reading its files again."""

from fieldkit.services.imports.add_files import Receipt, bring_in, take_in
from fieldkit.services.imports.gather import Gathered, ReadAs, gather, read_as, read_file
from fieldkit.services.imports.remeasure import Remeasured, StoredFiles, remeasured, stored_files
from fieldkit.services.imports.view import FileView, FlightView

__all__ = [
    "FileView",
    "FlightView",
    "Gathered",
    "ReadAs",
    "Receipt",
    "Remeasured",
    "StoredFiles",
    "bring_in",
    "gather",
    "read_as",
    "read_file",
    "remeasured",
    "stored_files",
    "take_in",
]
