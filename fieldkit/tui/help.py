"""The help of a screen."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Help:
    """The help of a screen: its purpose, each field by name in plain words, and the equivalent commands (`twin`)."""

    about: str
    fields: tuple[tuple[str, str], ...] = ()
    twin: tuple[str, ...] = ()


NO_FLIGHTS = """No flights yet.

0 Home    describe a rocket or load the demo rocket
2 Add     type in what the altimeter shows
3 Import  read a log or a table of flights
7 Capture read a logger over its cable"""
"""The text of a page before anything has flown."""
