"""Leave-one-out forecasts by hypotheses: a repeated fit and importance sampling give a hypothesis the same weight."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.fit import fit, refits_without
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import Term
from fieldkit.physics.history import history_of
from fieldkit.scoring.score import Forecasts, score
from fieldkit.selection import averaged
from fieldkit.selection.averaged import MAX_REFIT_WORK, left_out, that_pay
from fieldkit.selection.candidates import Candidate, Place, Switched, effect_terms
from fieldkit.selection.diagnose import by_state
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.hypotheses import Hypothesis, SetPosterior
from fieldkit.selection.search import checked
from tests.seasons import season

pytestmark = pytest.mark.fast
FLIGHTS = 8
MANY = 40


def unreliable(flights: int) -> Hypothesis:
    """The plain model of a season, whose importance weights count as unreliable."""
    pairs = season(np.random.default_rng(1), ("apogee",), flights, None)
    some, found = [flight for flight, _ in pairs], [motor for _, motor in pairs]
    model = rocket_model(history_of(some, found))
    plain = fit(model, observe(history_of(some, found, used_in_fit=[True] * flights)), outlier_flights=True)
    (one,) = checked(SetPosterior((Hypothesis((), plain),))).hypotheses
    assert one.sampled is not None
    return replace(one, sampled=replace(one.sampled, pareto_k_without=np.linspace(1, 2, flights)))


def test_a_repeated_fit_has_the_weight_of_importance_sampling() -> None:
    refitted = unreliable(FLIGHTS)
    assert refitted.sampled is not None
    sampled = replace(refitted, sampled=replace(refitted.sampled, pareto_k_without=np.zeros(FLIGHTS)))
    both = left_out(SetPosterior((sampled, refitted)))
    count = len(both.weight) // 2
    mean_weight = both.weight[:count].sum(axis=0)
    assert np.abs(mean_weight - 0.5).max() < 0.2


def test_the_work_of_repeated_fits_does_not_grow_with_the_flights(monkeypatch: pytest.MonkeyPatch) -> None:
    repeated: list[int] = []

    def counted(whole: Fit, rows: list[int], scales: Any) -> list[Fit]:
        repeated.extend(rows)
        return refits_without(whole, rows, scales)

    one = unreliable(MANY)
    monkeypatch.setattr(averaged, "refits_without", counted)
    some = left_out(SetPosterior((one,)))
    assert sorted(repeated) == list(range(MANY - MAX_REFIT_WORK // MANY, MANY))
    monkeypatch.setattr(averaged, "MAX_REFIT_WORK", MANY**2)
    every = left_out(SetPosterior((one,)))
    sd = (every.weight * every.sd).sum(axis=0)
    assert np.abs(((some.weight * some.mean).sum(axis=0) - (every.weight * every.mean).sum(axis=0)) / sd).max() < 0.02
    assert (some.weight * some.sd).sum(axis=0) == pytest.approx(sd, rel=0.02)


def test_a_forecast_averages_over_the_states_of_brakes() -> None:
    pairs = season(np.random.default_rng(3), ("apogee",), 12, None)
    lower = [
        flight.with_changes(apogee=(flight.apogee or 0) * (0.85 if k % 2 else 1)) for k, (flight, _) in enumerate(pairs)
    ]
    flown = [(flight, motor) for flight, (_, motor) in zip(lower, pairs, strict=True)]
    place = Place(
        "drag_step", switched=Switched(tuple((f.flight_id, 0.9 * (k % 2)) for k, f in enumerate(lower)), 0.9, 0.5)
    )
    (_, shut), (_, opened) = states = by_state((place,))
    plan = [(lower[-1].unflown(tags=()), pairs[-1][1])]

    def mean(*averaged: tuple[float, tuple[Place, ...]]) -> float:
        (found,) = predict(flown, plan, Assumed(averaged))
        return float(found.apogee.mean())

    low, high, both = mean((1.0, opened)), mean((1.0, shut)), mean(*states)
    assert low < 0.95 * high
    assert both == pytest.approx((low + high) / 2, rel=0.015)


def test_brakes_that_a_controller_opens_do_not_spoil_forecasts() -> None:
    # the flights with open brakes are as high as the others, which the drag of brakes alone would not make them
    pairs = season(np.random.default_rng(2), ("apogee",), 12, None)
    some, found = [flight for flight, _ in pairs], [motor for _, motor in pairs]
    data = observe(history_of(some, found, used_in_fit=[True] * 12))
    opened = tuple((flight.flight_id, 0.8 * (number % 3 == 0)) for number, flight in enumerate(some))
    place = Place("drag_step", switched=Switched(opened, 0.8, 1 / 3))
    plain = rocket_model(history_of(some, found))
    strength, state = effect_terms(place, plain)
    strength = replace(strength, mean=1.0, sd=0.2)

    base = fit(plain, data, outlier_flights=True)

    def error(*terms: Term) -> float:
        candidates = (Candidate(place, terms),) if terms else ()
        fitted = fit(plain.with_terms(*terms), data, outlier_flights=True)
        forecasts = left_out(
            SetPosterior(checked(SetPosterior((Hypothesis((), base), Hypothesis(candidates, fitted)))).hypotheses[-1:])
        )
        return score(forecasts, data.values[:, 0], data.seen[:, 0]).mae

    without = error()
    assert error(strength) > 1.2 * without
    assert error(strength, state) < 1.15 * without


def test_effects_are_averaged_in_only_while_that_forecasts_held_out_flights_no_worse() -> None:
    truth, seen, one = np.log([200.0, 210.0, 190.0, 205.0]), np.ones(4, bool), np.ones((1, 4))
    plain = Forecasts(np.log(200.0) * one, 0.05 * one, one)
    near, far = (Forecasts(truth + error * one, 0.05 * one, one) for error in (0.0, 0.2))
    assert that_pay(plain, near, truth, seen) == (near, True)
    assert that_pay(plain, far, truth, seen) == (plain, False)
    once = replace(near, mean=np.where(np.arange(4) == 1, near.mean + 0.2, near.mean))  # far off on one flight
    forward, _ = that_pay(plain, once, truth, seen, forward=True)
    assert (forward.mean[0, :2] == once.mean[0, :2]).all()
    assert (forward.mean[0, 2:] == plain.mean[0, 2:]).all()
    assert that_pay(plain, far, truth, np.zeros(4, bool)) == (far, True)  # without an apogee the evidence decides
