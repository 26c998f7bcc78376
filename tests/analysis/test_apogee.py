"""When a fitted curve turns around, and until when nothing may have braked it."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.analysis.apogee import _vertices, height_at
from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import Heights
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.process_noise import phases
from fieldkit.analysis.records import Event
from fieldkit.analysis.samples import Marks
from fieldkit.analysis.smooth import Grid
from fieldkit.physics.standard_atmosphere import GRAVITY

pytestmark = pytest.mark.fast


def test_the_vertex_of_a_curve_is_found_between_its_knots() -> None:
    time = np.arange(0.0, 10.0, 0.1)
    tops = np.array([4.0, 4.03, 4.08, 9.87])
    speeds = GRAVITY * (tops[:, None] - time)
    places = np.argmax(-((time - tops[:, None]) ** 2), axis=1)
    assert _vertices(time, speeds, places) == pytest.approx(tops)


@pytest.mark.parametrize(("charge", "coasts"), [(6.0, True), (8.0, False), (np.inf, False), (4.5, False)])
def test_nothing_brakes_a_rocket_until_a_shock_is_felt_soon_after_its_top(charge: float, coasts: bool) -> None:
    grid = Grid(-1.0, 0.05, 240)
    phase = phases(grid, Marks(0.0, 1.0, 5.0, charge))
    after_top = (grid.middles > 5.0) & (grid.middles < 5.8)
    assert bool((phase[after_top] == 2).all()) == coasts
    assert (phase[(grid.middles > 2.0) & (grid.middles < 4.0)] == 2).all()


@pytest.mark.parametrize("moment", [3.0, 8.0])
def test_an_uncertain_lag_is_an_error_of_a_height_on_a_slope(moment: float) -> None:
    """Inside the curve and after its end: a lag that may be off by half of it moves a fall of 20 m/s by 10 m/s."""
    time = np.arange(0.0, 10.0, 0.1)
    height = 300.0 - 20 * time
    knots, flat = time[time < 5], np.zeros((2, 50))
    curve = Ascent(knots, height[:50], flat[0] - 20, flat[0], height[:50] + flat, flat - 20, flat, 0.3, 0.0, fused=True)
    track = Heights(time, height, True, 0.3, "barometric altitude")
    seen = Outline(0.0, 1.0, 2.0, True, 0.0, 0.2, 300.0, height, False, 100.0)
    sds = [height_at(curve, replace(track, lag_sd=lag), seen, Event(moment, 0.02, "")).sd for lag in (0.0, 0.2)]
    assert sds[1] == pytest.approx(np.hypot(sds[0], 20 * 0.2), rel=0.02)


def test_the_gas_of_a_charge_does_not_move_the_height_at_ejection() -> None:
    """A charge at 7.85 s moves the heights after it by 30 m; ejection is found 0.15 s later, give or take 0.2 s."""
    time = np.arange(0.0, 10.0, 0.05)
    true = 300.0 - GRAVITY * time**2 / 2
    height = true + 0.3 * np.random.default_rng(1).standard_normal(time.size) + 30.0 * ((time > 7.85) & (time < 8.1))
    knots, flat = time[time < 5], np.zeros((2, 100))
    curve = Ascent(knots, true[:100], flat[0], flat[0], true[:100] + flat, flat, flat, 0.3, 0.0, fused=True)
    track = Heights(time, height, True, 0.3, "barometric altitude")
    seen = Outline(0.0, 1.0, 2.0, True, 0.0, 0.2, 300.0, height, False, 100.0)
    found = height_at(curve, track, seen, Event(8.0, 0.2, ""))
    assert found.value == pytest.approx(300.0 - GRAVITY * 8.0**2 / 2, abs=3.0)
    assert found.sd == pytest.approx(8 * GRAVITY * 0.2, rel=0.2)
