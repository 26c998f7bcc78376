"""From the samples of a log to what is measured in them: `measure`, and the records it returns."""

from fieldkit.analysis.columns import columns
from fieldkit.analysis.measure import by_device, measure, rises
from fieldkit.analysis.notes import NO_FLIGHT
from fieldkit.analysis.possible import widened_by_contradictions
from fieldkit.analysis.records import Event, Figure, Forces, HeightTrack, MeasuredClimb, Recorded
from fieldkit.analysis.simulated import simulated
from fieldkit.analysis.true_height import true_apogee

__all__ = [
    "NO_FLIGHT",
    "Event",
    "Figure",
    "Forces",
    "HeightTrack",
    "MeasuredClimb",
    "Recorded",
    "by_device",
    "columns",
    "measure",
    "rises",
    "simulated",
    "true_apogee",
    "widened_by_contradictions",
]
