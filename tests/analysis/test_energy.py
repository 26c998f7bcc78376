"""A top speed agrees with the climb after burnout, whatever sensors measured it."""

from dataclasses import replace

import numpy as np
import pytest

from bench.recorders.flights import draw
from bench.recorders.judge import read
from bench.recorders.models import Recorder
from bench.recorders.record import written
from fieldkit.analysis.possible import by_energy, speed_of_coast
from fieldkit.analysis.records import Figure
from fieldkit.physics.standard_atmosphere import GRAVITY


def coast(speed: float, drag: float) -> tuple[float, float]:
    """Rise [m] and duration [s] of a coast with drag in proportion to v², `drag` times the weight at its start."""
    height = time = 0.0
    now = speed
    while now > 0:
        now -= GRAVITY * (1 + drag * (now / speed) ** 2) * 1e-4
        height, time = height + now * 1e-4, time + 1e-4
    return height, time


@pytest.mark.parametrize("drag", [0.1, 0.5, 1.5, 3.0])
@pytest.mark.parametrize("speed", [30.0, 90.0, 200.0])
def test_rise_and_duration_of_a_coast_give_its_speed(speed: float, drag: float) -> None:
    rise, lasts = coast(speed, drag)
    found = speed_of_coast(rise, Figure(lasts, 0.0, "baro"))
    assert found is not None
    assert found.value == pytest.approx(speed, rel=0.003)


def test_an_early_charge_gives_no_speed() -> None:
    assert speed_of_coast(120.0, Figure(2.5, 0.05, "baro")) is None


def figures(speed: float, sd: float, *, source: str) -> dict[str, Figure]:
    """The figures of a flight that reaches 60 m/s at 20 m and coasts to 190 m, with another top speed."""
    rise, lasts = coast(60.0, 0.15)
    known = {"top_speed": (speed, sd), "burn_time": (0.7, 0.05), "avg_accel": (speed / 0.7, sd / 0.7)}
    known |= {"apogee": (20 + rise, 0.3), "coast_to_apogee": (lasts, 0.05)}
    return {name: Figure(*one, source) for name, one in known.items()}


@pytest.mark.parametrize("source", ["pressure", "GPS altitude", "barometric altitude and acceleration", "acceleration"])
@pytest.mark.parametrize("speed", [39.0, 90.0])
def test_a_top_speed_that_does_not_fit_the_climb_is_not_reported_for_any_sensor(speed: float, source: str) -> None:
    kept, (why,) = by_energy(figures(speed, 3.0, source=source), 20.0)
    assert kept.keys() == {"apogee", "coast_to_apogee"}
    assert "do not fit the climb after burnout" in why


def test_a_top_speed_below_what_the_climb_needs_is_bounded_by_it() -> None:
    """A normal distribution as wide as it is short, weighted by the speed of the coast and truncated at the bound, by a
    million draws."""
    before = figures(50.0, 6.0, source="pressure")
    after, notes = by_energy(before, 20.0)
    rng = np.random.default_rng(1)
    rise = before["apogee"].value - 20.0
    least = np.sqrt(2 * GRAVITY * rise)
    least_sd = GRAVITY * 50.0 * 0.05 / least
    coasts = speed_of_coast(rise, before["coast_to_apogee"])
    assert coasts is not None
    short = max((least - 50.0) / np.hypot(6.0, least_sd), (coasts.value - 50.0) / np.hypot(6.0, coasts.sd))
    draws = rng.normal(50.0, 6.0 * max(1.0, short), 1_000_000)
    kept = draws[draws > least + rng.normal(0, least_sd, draws.size)]
    weight = np.exp(-(((kept - coasts.value) / coasts.sd) ** 2) / 2)
    mean = np.average(kept, weights=weight)
    assert after["top_speed"].value == pytest.approx(mean, abs=0.1)
    assert after["top_speed"].sd == pytest.approx(np.sqrt(np.average((kept - mean) ** 2, weights=weight)), rel=0.03)
    assert after["avg_accel"].value == pytest.approx(after["top_speed"].value / 0.7)
    assert "at least 5" in notes[0]


def test_a_top_speed_that_fits_is_unchanged() -> None:
    before = figures(60.0, 0.4, source="pressure")
    after, notes = by_energy(before, 20.0)
    assert not notes
    assert after["top_speed"].value == pytest.approx(60.0, abs=0.05)


SENSORS = {
    "barometer": Recorder(),
    "pressure": Recorder(column="pressure_pa", resolution=1),
    "slow barometer": Recorder(baro=2),
    "satellites": Recorder(baro=0, gps=5),
    "barometer and satellites": Recorder(gps=5),
    "barometer and accelerometer": Recorder(accel=100),
    "three axes": Recorder(accel=100, axes=3),
    "saturated accelerometer": Recorder(accel=100, accel_range=4),
    "accelerometer of half scale": Recorder(accel=100, scale=0.5),
    "late accelerometer": Recorder(accel=100, late=1.6),
    "derived acceleration": Recorder(derived=True, speed=True),
    "satellites and accelerometer": Recorder(baro=0, gps=5, accel=100),
}
FAULTS: dict[str, dict[str, float]] = {
    "none": {},
    "slow heights": {"lag": 0.5},
    "static ports": {"static": 0.15},
    "spikes": {"spikes": 0.03},
}


@pytest.mark.sampled
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("sensors", SENSORS)
def test_no_combination_of_sensors_and_faults_reports_a_speed_that_the_climb_excludes(sensors: str, fault: str) -> None:
    """In vacuum a coast rises v²/2g, so with drag the speed is higher; and a mean is never above its peak."""
    random = np.random.default_rng(8)
    recorder = replace(SENSORS[sensors], **FAULTS[fault])  # type: ignore[arg-type]
    for path in draw(random, 1):
        found = read(written(path, recorder, random))
        speed, mean, peak = (found.figures.get(name) for name in ("top_speed", "avg_accel", "peak_accel"))
        if speed is not None:
            burnout = float(np.interp(path.burnout, path.time, path.height))
            least = np.sqrt(2 * GRAVITY * max(path.readouts()["apogee"] - burnout, 0.0))
            assert speed.value > least - 3 * max(speed.sd, 0.02 * least)
            assert abs(speed.value - path.readouts()["top_speed"]) < 5 * max(speed.sd, 0.02 * speed.value)
        if mean is not None and peak is not None:
            assert mean.value <= peak.value
