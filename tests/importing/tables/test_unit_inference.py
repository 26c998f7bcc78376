"""Units that physics determines: a coast decelerates at one g or more, whatever a charge does at its end."""

import numpy as np
import pytest

from fieldkit.importing.tables.unit_inference import height_units_by_free_fall, settle_time_heights
from fieldkit.shapes import Array
from fieldkit.units import FOOT
from tests.analysis.recordings import SMALL, TINY, Logger, Rocket, fly, log

EARLY = Rocket(thrust=75.0, burn=1.2, mass=0.5, area=0.0009, delay=7.0)
"""Its charge fires more than a second before apogee."""


def heights(rocket: Rocket) -> dict[str, Array]:
    (series,) = log(fly(rocket), Logger(start=5.0), np.random.default_rng(1))
    assert series.altitude is not None
    return {"time": series.time, "altitude": series.altitude}


@pytest.mark.parametrize("rocket", [SMALL, TINY, EARLY], ids=["small", "tiny", "early charge"])
def test_meters_are_known_by_the_coast_and_feet_called_meters_are_noticed(rocket: Rocket) -> None:
    meters = heights(rocket)
    feet = {**meters, "altitude": meters["altitude"] / FOOT}
    assert settle_time_heights(meters, {"time": "s"})["altitude"].unit == "m"
    assert [height_units_by_free_fall(meters, unit) for unit in ("m", "ft")] == [("m",), ("m",)]
    assert [height_units_by_free_fall(feet, unit) for unit in ("m", "ft")] == [("ft",), ("ft",)]
    assert settle_time_heights(feet, {"time": "s"})["altitude"].unit == "ft"
