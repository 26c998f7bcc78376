"""From the samples of a log to what is measured in them: `measure`, and the records it returns."""

from fieldkit.analysis.columns import columns
from fieldkit.analysis.measure import measure, rises
from fieldkit.analysis.records import Event, Figure, Forces, HeightTrack, MeasuredClimb, Recorded

__all__ = [
    "Event",
    "Figure",
    "Forces",
    "HeightTrack",
    "MeasuredClimb",
    "Recorded",
    "columns",
    "measure",
    "rises",
]
