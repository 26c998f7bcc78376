"""Leave-one-out forecasts by hypotheses: a repeated fit and importance sampling give a hypothesis the same weight."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.inference.laplace.fit import fit
from fieldkit.model.readout_data import observe
from fieldkit.selection.averaged import left_out
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.hypotheses import Hypothesis, SetPosterior
from fieldkit.selection.search import checked
from tests.seasons import season

pytestmark = pytest.mark.fast
FLIGHTS = 8


def test_a_repeated_fit_has_the_weight_of_importance_sampling() -> None:
    pairs = season(np.random.default_rng(1), ("apogee",), FLIGHTS, None)
    flights, found = [flight for flight, _ in pairs], [motor for _, motor in pairs]
    model = rocket_model(flights, found)
    plain = fit(model, observe(flights, [True] * FLIGHTS), outlier_flights=True)
    posterior = checked(SetPosterior((Hypothesis((), plain),)))
    (one,) = posterior.hypotheses
    assert one.sampled is not None
    unreliable = replace(one.sampled, pareto_k_without=np.full(FLIGHTS, np.inf))
    sampled = replace(one, sampled=replace(one.sampled, pareto_k_without=np.zeros(FLIGHTS)))
    refitted = replace(one, sampled=unreliable)
    both = left_out(SetPosterior((sampled, refitted)))
    count = len(both.weight) // 2
    mean_weight = both.weight[:count].sum(axis=0)
    assert np.abs(mean_weight - 0.5).max() < 0.2
