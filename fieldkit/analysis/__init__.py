"""From the samples of a log to what is measured in them: `measure`, and the records it returns."""

from fieldkit.analysis.columns import columns
from fieldkit.analysis.measure import NO_FLIGHT, measure, rises
from fieldkit.analysis.possible import doubted
from fieldkit.analysis.records import Climb, Event, Figure, Forces, Recorded, Track

__all__ = [
    "NO_FLIGHT",
    "Climb",
    "Event",
    "Figure",
    "Forces",
    "Recorded",
    "Track",
    "columns",
    "doubted",
    "measure",
    "rises",
]
