"""From the bytes of a log or a table to flights.

A parser recognizes a log and reads it into `Reading`s: what the log states, nothing
derived. What is the same for every logger is done once, here: bounds, motor names, identities, duplicate
flights, rockets that are described in another file.
"""

from fieldkit.importing.reading import HEAD, ColumnChoice, Found, Intake, Mapped, Note, Parser, Reading, Rejected

__all__ = ["HEAD", "ColumnChoice", "Found", "Intake", "Mapped", "Note", "Parser", "Reading", "Rejected"]
