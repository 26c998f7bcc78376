"""From the bytes of a log or a table to flights.

A parser recognizes a log and reads it into `Reading`s, which contain only what the log states. Steps common to all
loggers are here: limits, motor names, IDs, duplicate flights, and rockets described in another file.
"""

from fieldkit.importing.reading import HEAD, ColumnChoice, Found, Intake, Mapped, Note, Parser, Reading, Rejected

__all__ = ["HEAD", "ColumnChoice", "Found", "Intake", "Mapped", "Note", "Parser", "Reading", "Rejected"]
