"""Drag that switches in the coasts of simulated logs."""

from collections.abc import Sequence

import numpy as np
import pytest

from fieldkit.analysis.force_profile import drag_profile
from fieldkit.selection.drag_steps import DragSteps, LoggedDrag, drag_steps
from fieldkit.selection.logged_forces import LoggedForces, with_probability
from tests.analysis.coasts import coast_log

OWN, PRIOR = 1.2e-3, -2.6


def steps(
    onsets: Sequence[float | None], ratio: float = 1.8, felt: bool = True, seed: int = 0, ports: float = 0.0
) -> DragSteps:
    """The steps in logs of a rocket whose brakes open at these times; None on flights on which they stay shut."""
    logs = []
    for number, onset in enumerate(onsets):
        scatter = 1 + 0.03 * np.random.default_rng(seed + number).normal()

        def drag(time: float, onset: float | None = onset, own: float = OWN * scatter) -> float:
            return own * (ratio if onset is not None and time >= onset else 1.0)

        profile = drag_profile(*coast_log(drag, 100 * seed + number, felt=felt, ports=ports))
        assert profile is not None
        logs.append(LoggedDrag(str(number), profile, profile.reference, 0.03))
    found = drag_steps(logs, PRIOR)
    assert found is not None
    return found


def test_brakes_that_open_on_some_flights_are_found_on_those() -> None:
    found = steps([2.5, None, 3.0, None, None])
    assert found.log_bayes > 3
    assert found.present > 0.9
    assert [one.member > 0.5 for one in found.flights] == [True, False, True, False, False]
    for flight, onset in ((0, 2.5), (2, 3.0)):
        (step,) = found.flights[flight].steps
        assert step.begin == pytest.approx(onset, abs=0.3)
        assert step.end is None
        assert step.ratio == pytest.approx(1.8, abs=3 * step.sd)


def test_pressure_alone_shows_brakes_that_triple_the_drag_beside_the_error_of_ports_that_flights_share() -> None:
    for seed in (0, 1):
        found = steps([2.0, None, 2.2, 2.1, None], ratio=3.0, felt=False, seed=seed, ports=0.04)
        assert [one.member > 0.5 for one in found.flights] == [True, False, True, True, False]


def test_drag_along_the_coast_is_relative_to_the_drag_without_the_step() -> None:
    found = steps([2.5, None, 3.0, None, None])
    braked, shut = found.flights[0], found.flights[1]
    late = (braked.time_from_liftoff > 3.0) & (braked.time_from_liftoff < 4.5)
    assert np.abs(braked.ratio[late] - 1.8).max() < 0.4
    assert np.abs(shut.ratio[shut.time_from_liftoff < 4.5] - 1).max() < 0.25


@pytest.mark.parametrize("felt", [True, False])
def test_healthy_flights_have_no_step(felt: bool) -> None:
    for seed in range(4):
        found = steps([None] * 4, felt=felt, seed=seed)
        assert found.present < 0.3
        assert max(one.member for one in found.flights) < 0.3


def test_brakes_that_close_again_have_an_end() -> None:
    logs = []
    for number in range(3):
        profile = drag_profile(*coast_log(lambda time: OWN * (2.2 if 2.0 <= time < 3.2 else 1.0), number))
        assert profile is not None
        logs.append(LoggedDrag(str(number), profile, profile.reference, 0.03))
    found = drag_steps(logs, PRIOR)
    assert found is not None
    for one in found.flights:
        first = one.steps[0]
        assert first.begin == pytest.approx(2.0, abs=0.3)
        assert first.end == pytest.approx(3.2, abs=0.3)


def test_what_one_flight_alone_shows_is_not_a_property_of_the_rocket() -> None:
    found = steps([2.5, None, None, None, None, None])
    assert found.flights[0].member > 0.5
    assert found.present < 0.67


def test_a_step_is_one_of_its_flight_if_drag_does_not_switch_on_the_others() -> None:
    """The law of total probability, with the odds of drag that switches as the logs alone have them, and lower."""
    found = steps([2.5, None, 3.0, None, None], ratio=2.5)
    forces = LoggedForces({one.flight_id: one for one in found.flights}, {}, found, {})
    for probability in (found.present, 0.3):
        for one in with_probability(forces, probability).drag.values():
            assert one.member == pytest.approx(probability * one.shared + (1 - probability) * one.lone)
            assert all(step.probability <= one.member + 1e-9 for step in one.steps)
    first, second = (with_probability(forces, 0.3).drag[name] for name in ("0", "1"))
    assert first.lone > 0.9
    assert first.member > 0.9
    assert second.member < 0.1


def test_no_logs_show_nothing() -> None:
    assert drag_steps([], PRIOR) is None
