"""A clock that jumps forward between two samples."""

from functools import cache

import numpy as np
import pytest

from fieldkit.flight import Series
from fieldkit.importing import Reading
from fieldkit.importing.jumped_clock import with_even_clock
from fieldkit.importing.read import read
from tests.analysis.recordings import SMALL, Logger, fly, log
from tests.samples import any_motor

flown = cache(fly)


def flight(seed: int = 1) -> Series:
    (series,) = log(flown(SMALL), Logger(start=0.0, wait=5.0, noise=0.4), np.random.default_rng(seed))
    return series


@pytest.mark.parametrize("when", [0.6, 3.0, 6.0, 7.5, 12.0])
@pytest.mark.parametrize("channel", ["altitude", "pressure"])
def test_times_after_a_jump_are_moved_back(when: float, channel: str) -> None:
    logger = Logger(start=0.0, wait=5.0, channel=channel)
    (series,) = log(flown(SMALL), logger, np.random.default_rng(2))
    late = Series(time=series.time + np.where(series.time > when, 3.0, 0.0), **{channel: getattr(series, channel)})
    found, notes = with_even_clock(Reading(series=late, events={"drogue": 11.0 + 3.0 * (when < 11)}))
    np.testing.assert_allclose(found.clocks[0].time, series.time, atol=0.03)
    assert found.events["drogue"] == pytest.approx(11.0, abs=0.03 + 3.0 * (when > 11))
    assert [str(note.text).startswith("the clock jumps by 3.0 s") for note in notes] == [True]


@pytest.mark.parametrize("when", [0.6, 3.0, 6.0, 7.0, 12.0, 60.0])
def test_a_gap_through_which_the_rocket_moved_is_kept(when: float) -> None:
    series = flight()
    heard = (series.time < when) | (series.time > when + 3)
    with_gap = Series(time=series.time[heard], altitude=np.asarray(series.altitude)[heard])
    reading = Reading(series=with_gap)
    assert with_even_clock(reading) == (reading, [])


def test_samples_of_another_sensor_show_that_the_clock_ran_on() -> None:
    series = flight()
    late = Series(time=series.time + np.where(series.time > 3, 3.0, 0.0), altitude=series.altitude)
    felt = Series(time=np.arange(0.0, 20.0, 0.01), felt=np.full(2000, 9.8))
    reading = Reading(series=(late, felt))
    assert with_even_clock(reading) == (reading, [])


def test_the_imported_flight_has_the_right_times() -> None:
    series = flight()
    rows = zip(series.time + np.where(series.time > 4, 3.0, 0.0), np.asarray(series.altitude), strict=True)
    text = "time (s),altitude (m)\n" + "".join(f"{t:.3f},{h:.2f}\n" for t, h in rows)
    found = read(text.encode(), "log.csv", any_motor)
    (recorded,) = found.recorded
    assert recorded is not None
    assert abs(recorded.figures["coast_to_apogee"].value - flown(SMALL).readouts()["coast_to_apogee"]) < 0.6
    assert any("the clock jumps by 3.0 s" in note for note in found.notes)


@pytest.mark.parametrize("when", [0.6, 4.0, 30.0])
def test_a_clock_that_is_set_back_in_the_air_begins_no_flight(when: float) -> None:
    series = flight()
    rows = zip(series.time - np.where(series.time > when, 3.0, 0.0), np.asarray(series.altitude), strict=True)
    text = "time (s),altitude (m)\n" + "".join(f"{t:.3f},{h:.2f}\n" for t, h in rows)
    found = read(text.encode(), "log.csv", any_motor)
    (recorded,) = found.recorded
    assert recorded is not None
    for name in ("coast_to_apogee", "duration"):
        assert abs(recorded.figures[name].value - flown(SMALL).readouts()[name]) < 0.6
    assert any("the clock is set back by 3.0 s" in note for note in found.notes)


def test_a_clock_that_restarts_at_rest_begins_a_flight() -> None:
    series = flight()
    rows = [f"{t:.3f},{h:.2f}\n" for t, h in zip(series.time, np.asarray(series.altitude), strict=True)]
    other = [f"{t:.3f},{0.9 * h:.2f}\n" for t, h in zip(series.time, np.asarray(series.altitude), strict=True)]
    found = read(("time (s),altitude (m)\n" + "".join(rows + other)).encode(), "log.csv", any_motor)
    assert len(found.flights) == 2
