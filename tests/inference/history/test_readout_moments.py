"""Forecasts of other readouts of a plan by the linear fit and with the network's Cd and alpha."""

import numpy as np
import pytest

from fieldkit.forecast.predict import predict
from fieldkit.inference.history.moments import (
    ParameterMoments,
    moments,
    parameter_moments,
    readout_moments,
)
from fieldkit.inference.network.history import QuickAnswer, quick_answer
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import history


@pytest.fixture(scope="module")
def answer() -> QuickAnswer:
    return quick_answer(history(8), quick_candidates)


def linear_parameters(answer: QuickAnswer) -> ParameterMoments:
    base = moments(answer.summary.forecast)
    return parameter_moments(base.cd, base.cd_sd, base.alpha, base.alpha_sd, base.correlation)


def test_the_same_drag_and_thrust_do_not_change_readouts(answer: QuickAnswer) -> None:
    linear, own = readout_moments(answer.summary.forecast), linear_parameters(answer)
    again = linear.given(own, own)
    assert again.mean == pytest.approx(linear.mean)
    assert again.sd == pytest.approx(linear.sd)


def test_knowing_drag_and_thrust_narrows_readouts_like_a_normal_distribution(answer: QuickAnswer) -> None:
    linear, own = readout_moments(answer.summary.forecast), linear_parameters(answer)
    known = linear.given(own, ParameterMoments(own.mean, np.zeros_like(own.covariance)))
    cross = linear.with_parameters[0]
    taken = np.einsum("ri,ij,rj->r", cross, np.linalg.inv(own.covariance[0]), cross)
    assert known.sd[0] ** 2 == pytest.approx(linear.sd[0] ** 2 - taken)


@pytest.mark.parametrize("count", [4, 12])
def test_readouts_are_near_those_of_the_fit(count: int) -> None:
    """Medians within a fifth of the fit's 90% interval."""
    flights = history(count)
    answer = quick_answer(flights, quick_candidates)
    known = list(zip(flights.flights, flights.found, strict=True))
    (fitted,) = predict(known[:-1], known[-1:], draws=2000)
    for name, draws in (("top_speed", fitted.top_speed), ("coast_to_apogee", fitted.coast)):
        low, middle, high = np.percentile(draws, [5, 50, 95])
        assert abs(answer.readouts[name][1] - middle) < 0.2 * (high - low)
