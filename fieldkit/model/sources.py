"""What readouts come from: the samples of sensors, logs, or the display of a device."""

from collections.abc import Collection, Sequence

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.readout import SENSORS, Readout
from fieldkit.model.hyperprior import FROM_LOGS
from fieldkit.shapes import Array, Float

IN_SAMPLES = (*SENSORS, "simulated")
"""Sources of readouts that are measured in samples: those of a sensor, or of a simulation."""


def has_log(flight: Flight) -> bool:
    """Whether a flight has a readout that only the samples of a log provide."""
    return any(flight.number(name) is not None for name in FROM_LOGS)


def measured_by(sources: Collection[str], recorded: Sequence[Readout | None]) -> Float[Array, "flight"]:
    """1 for a flight whose readout comes from one of some sources, otherwise 0. [1]

    A flight without the readout takes the value of the last earlier flight with it, or else of the first flight with
    it, because a rocket usually keeps its altimeter. If no flight has the readout, the value is 0.
    """
    shown = [i for i, one in enumerate(recorded) if one]
    own = np.array([float(one is not None and one.source in sources) for one in recorded])
    if not shown:
        return np.zeros(len(recorded))
    last = np.maximum(np.searchsorted(shown, np.arange(len(recorded)), side="right") - 1, 0)
    return np.asarray(own[np.array(shown)[last]])
