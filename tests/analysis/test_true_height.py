"""The true height of a barometric apogee: as by the air that it was made with, or with an error that covers it."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis import measure, true_apogee
from fieldkit.analysis.records import Figure, Recorded
from fieldkit.analysis.true_height import MEASURED_AIR, SATELLITES, SENSOR_AIR, STANDARD_AIR
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import (
    GAS_CONSTANT,
    GRAVITY,
    LAPSE,
    height_pressure,
    pressure_height,
)
from tests.analysis.recordings import SMALL, Logger, fly, log

HOT, ELEVATION = 308.15, 1400.0
"""A day in the desert. [K], [m]"""


def shown(height: float) -> tuple[float, float]:
    """What an altimeter shows at a true height on that day [m], and the pressure on its pad [Pa]."""
    pad = float(height_pressure(np.array([ELEVATION]))[0])
    pressure = pad * (1 - LAPSE * height / HOT) ** (GRAVITY / (GAS_CONSTANT * LAPSE))
    low, high = pressure_height(np.array([pad, pressure]))
    return float(high - low), pad


def recorded(value: float) -> Recorded:
    return Recorded(figures={"apogee": Figure(value, 2.0, "barometric altitude")})


@pytest.mark.parametrize("height", [300.0, 3000.0])
def test_the_temperature_of_the_flight_gives_the_true_height(height: float) -> None:
    value, pad = shown(height)
    clock = Series(np.arange(3.0), pressure=np.full(3, pad))
    found = true_apogee(recorded(value), [clock], HOT, None)
    assert found is not None
    assert value < 0.92 * height
    assert found.value == pytest.approx(height, rel=1e-3)
    assert found.source == MEASURED_AIR
    by_elevation = true_apogee(recorded(value), [Series(np.arange(3.0))], HOT, ELEVATION)
    assert by_elevation is not None
    assert by_elevation.value == pytest.approx(height, rel=1e-3)


def test_without_a_temperature_the_error_covers_hot_days() -> None:
    value, pad = shown(1000.0)
    clock = Series(np.arange(3.0), pressure=np.full(3, pad))
    found = true_apogee(recorded(value), [clock], None, None)
    assert found is not None
    assert (found.value, found.source) == (pytest.approx(value), STANDARD_AIR)
    assert 0.035 * value < found.sd < 0.05 * value
    assert abs(found.value - 1000.0) < 3 * found.sd


def test_the_altimeters_own_temperature_is_used_as_far_as_it_shows_that_of_the_air() -> None:
    value, pad = shown(1000.0)
    clock = Series(np.arange(3.0), pressure=np.full(3, pad), temperature=np.full(3, HOT + 6.0))
    found = true_apogee(recorded(value), [clock], None, None)
    unknown = true_apogee(recorded(value), [replace(clock, temperature=None)], None, None)
    assert found is not None
    assert unknown is not None
    assert found.source == SENSOR_AIR
    assert abs(found.value - 1000.0) < found.sd < unknown.sd


def test_satellites_beside_the_barometer_show_it() -> None:
    [series] = log(fly(SMALL), Logger(), np.random.default_rng(3))
    assert series.altitude is not None
    sky = Series(series.time[::4], gps_altitude_msl=series.altitude[::4] * 1.06 + 250.0)
    found = measure([series, sky])
    true = true_apogee(found, [series, sky], None, None)
    assert true is not None
    assert true.source == SATELLITES
    assert abs(true.value - 1.06 * found.figures["apogee"].value) < 2 * true.sd < 0.05 * true.value


def test_apogees_by_other_sensors_have_none() -> None:
    by_satellites = Recorded(figures={"apogee": Figure(300.0, 2.0, "GPS altitude")})
    assert true_apogee(by_satellites, [], None, None) is None
    assert true_apogee(Recorded(), [], None, None) is None


@pytest.mark.parametrize("name", ["pressure", "temperature"])
@pytest.mark.parametrize("broken", [0.0, -40.0, 1e7])
def test_air_that_no_pad_has_is_not_used(name: str, broken: float) -> None:
    value, pad = shown(1000.0)
    clock = Series(np.arange(3.0), pressure=np.full(3, pad), temperature=np.full(3, HOT))
    found = true_apogee(recorded(value), [replace(clock, **{name: np.full(3, broken)})], None, ELEVATION)
    assert found == true_apogee(recorded(value), [replace(clock, **{name: None})], None, ELEVATION)
