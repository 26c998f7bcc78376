"""The check of drag along logged coasts: what the model draws passes it, and drag that changes in another way does not.

The coasts are drawn from the model itself: intervals whose relative drag is measured with independent errors.
"""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from fieldkit.analysis.force_profile import DragLikelihood, DragProfile, PortError
from fieldkit.selection.coast_check import CoastCheck, coast_check
from fieldkit.selection.drag_steps import DragSteps, LoggedDrag
from fieldkit.selection.model_check import ModelCheck, clearest, coasts_check
from fieldkit.shapes import Array

pytestmark = pytest.mark.fast

COUNT, SD = 40, 0.2
TIME: Array = np.asarray(1.5 + 0.1 * np.arange(COUNT), float)
STEPS = DragSteps(5.0, 1.0, 1.0, 0.02, 1.0, 0.1, 0.3, ())


def log(name: str, drag: Callable[[Array], Array], rng: np.random.Generator) -> LoggedDrag:
    """A coast with this relative drag over time and independent errors of its intervals."""
    precision: Array = np.asarray(np.eye(COUNT) / SD**2, float)
    shown: Array = np.asarray(drag(TIME) * (1 + 0.03 * rng.normal()) + SD * rng.normal(size=COUNT), float)
    ports = PortError(np.zeros(COUNT), 0.0, 0.0)
    one = DragLikelihood(0.0, precision, precision @ shown, np.zeros((COUNT, COUNT)), ports)
    profile = DragProfile(TIME, 0.1, 90.0 - 15.0 * TIME, 1.0, (one,), "acceleration")
    return LoggedDrag(name, profile, 1.0, 0.03)


def usual(time: Array) -> Array:
    return np.ones_like(time)


def braked(time: Array) -> Array:
    return np.where(time > 3.0, 2.0, 1.0)


def wavy(time: Array) -> Array:
    return 1 + 0.7 * np.sin(2 * np.pi * time / 1.5)


def check(drags: Sequence[Callable[[Array], Array]], seed: int, probability: float = 1.0) -> CoastCheck:
    rng = np.random.default_rng(seed)
    return coast_check([log(str(n), drag, rng) for n, drag in enumerate(drags)], STEPS, probability)


def test_coasts_drawn_from_the_model_have_uniform_p_values() -> None:
    p = np.array([check([usual, usual, braked], seed).p for seed in range(24)])
    assert (p < 0.05).mean() < 0.2  # 1.2 of 24 expected, 4 or fewer in 97% of such samples
    assert 0.25 < p.mean() < 0.75


def test_drag_that_changes_in_another_way_is_left() -> None:
    found = check([usual, wavy, usual], 1)
    assert found.p < 0.01
    assert found.flight_id == "1"
    assert found.ratio == pytest.approx(float(wavy(np.array(found.time_from_liftoff))), abs=0.3)


def test_a_step_that_the_verdict_denies_is_less_expected() -> None:
    denied, named = (check([usual, braked, braked, usual], 2, probability).p for probability in (0.0, 1.0))
    assert denied < named / 3


def test_the_smallest_p_value_of_the_checks_counts() -> None:
    readouts, coasts = ModelCheck(0.6, None, "a trend of the apogee"), CoastCheck(0.004, "8", 3.2, 1.6)
    found = clearest([readouts, coasts_check(coasts)])
    assert found.left == "forces"
    assert found.p == pytest.approx(1 - 0.996**2)
    assert found.pattern == "the drag of flight 8, 1.6 times the rocket's own 3.2 s after lift-off"
    assert clearest([readouts]).p == pytest.approx(0.6)
    trend = ModelCheck(0.001, "order", "a trend of the apogee")
    fine = clearest([trend, coasts_check(CoastCheck(0.5, "8", 3.2, 1.1)), ModelCheck(0.7, None, "an unusual drag")])
    assert (fine.left, fine.pattern) == ("order", "a trend of the apogee")
    assert fine.p == pytest.approx(1 - 0.999**3)
