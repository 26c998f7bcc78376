"""From the samples of a log to what is measured in them: `measure`, and the records it returns."""

from fieldkit.recording.columns import columns, measured_sd
from fieldkit.recording.measure import measure
from fieldkit.recording.records import Climb, Event, Figure, Forces, Recorded

__all__ = [
    "Climb",
    "Event",
    "Figure",
    "Forces",
    "Recorded",
    "columns",
    "measure",
    "measured_sd",
]
