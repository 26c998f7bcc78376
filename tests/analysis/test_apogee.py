"""When a fitted curve turns around, and until when nothing may have braked it."""

import numpy as np
import pytest

from fieldkit.analysis.apogee import _vertices
from fieldkit.analysis.process_noise import phases
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
