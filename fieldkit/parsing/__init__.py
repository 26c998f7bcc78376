"""From the bytes of a log or a table to flights.

A parser says whether it recognises a log and reads it into `Reading`s: what the log states, nothing
derived. What holds for every logger alike happens once, here: bounds, motor names, identities, flights
that come twice, rockets that are described in another file.
"""

from fieldkit.parsing.flights import CheckMotor, derived_id
from fieldkit.parsing.opening import read, read_kept, read_plans, read_recordings, read_together
from fieldkit.parsing.recognition import claims, parsers, recognise
from fieldkit.reading import HEAD, Choice, Found, Intake, Mapped, Note, Parser, Reading, Rejected

__all__ = [
    "HEAD",
    "CheckMotor",
    "Choice",
    "Found",
    "Intake",
    "Mapped",
    "Note",
    "Parser",
    "Reading",
    "Rejected",
    "claims",
    "derived_id",
    "parsers",
    "read",
    "read_kept",
    "read_plans",
    "read_recordings",
    "read_together",
    "recognise",
]
