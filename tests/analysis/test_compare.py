"""Two recordings of one flight on one clock."""

import numpy as np
import pytest

from fieldkit.analysis import Recorded, simulated
from fieldkit.analysis.compare import compare
from fieldkit.flight import Series

pytestmark = pytest.mark.fast

TIME = np.arange(0, 10, 0.05)


def _flown(time: np.ndarray) -> Recorded:
    """A climb of 30 m under thrust and a coast without drag."""
    after = np.maximum(time - 1, 0)
    height = 30 * np.minimum(time, 1) ** 2 + 60 * after - 4.9 * after**2
    return simulated([Series(time=time, altitude=height)], {})


def test_duplicate_rows_around_a_simulated_event_are_compared_once() -> None:
    once, repeated = _flown(TIME), _flown(np.sort(np.append(TIME, [TIME[20], TIME[20], TIME[80]])))
    for first, second in ((once, repeated), (repeated, once), (repeated, repeated)):
        found = compare(first, second)
        assert found.shift == pytest.approx(0.0, abs=1e-3)
        assert found.rms == pytest.approx(0.0, abs=0.05)
