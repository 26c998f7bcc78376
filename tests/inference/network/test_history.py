"""The shipped history network: laws for any answer, and histories with known answers."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.errors import DamagedModel
from fieldkit.forecast.at_once import forecast_at_once, forecasts_at_once
from fieldkit.inference.history.features import feature_names
from fieldkit.inference.network.history import checked, load_history, pooled, quick_answer
from fieldkit.inference.network.history_parts import LEVELS, MEDIAN, STANDARD, answer, monotone, quantile_draws, width
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import History
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import history

CHECK_SHAPES = False


def ends(of: History) -> tuple[float, float]:
    """The median apogee [m] and the relative width of the 90% interval. [1]"""
    estimate = quick_answer(of, quick_candidates)
    low, high = (float(estimate.log_apogee[LEVELS.index(level)]) for level in (0.05, 0.95))
    return float(np.exp(estimate.log_apogee[MEDIAN])), high - low


def test_a_pool_is_between_its_opinions_and_agrees_if_they_do() -> None:
    chance = np.array([0.0, 0.02, 0.5, 0.9, 1.0])
    odds = np.log(np.clip(chance, 1e-9, 1 - 1e-9) / (1 - np.clip(chance, 1e-9, 1 - 1e-9)))
    np.testing.assert_allclose(pooled(chance, odds), chance, atol=1e-8)
    np.testing.assert_allclose(pooled(chance, -odds), 0.5)
    assert (np.diff(pooled(chance, np.zeros(5))) > 0).all()


def test_the_probabilities_of_a_history_are_pooled_with_its_own_odds() -> None:
    estimate, network = quick_answer(history(12), quick_candidates), load_history()
    names = tuple(network.card["effects"])
    features = estimate.summary.features
    alone, columns = answer(network.members(features), len(names)), feature_names(names)
    for name, chance in estimate.inclusion.items():
        own = pooled(alone.inclusion[0, names.index(name)], features[0, columns.index(f"{name}.odds")])
        assert chance == pytest.approx(float(own), abs=1e-12)
    assert estimate.none == pytest.approx(float(pooled(alone.none[0], features[0, columns.index("none_odds")])))


def test_strong_wear_is_found_and_is_the_most_probable_effect() -> None:
    estimate = quick_answer(history(24, wear=0.05), quick_candidates)
    assert estimate.inclusion["wear"] > 0.8
    assert estimate.none < 0.2
    assert max(estimate.inclusion, key=lambda name: estimate.inclusion[name]) == "wear"


def test_nothing_is_found_in_a_clean_history() -> None:
    for seed in range(3):
        estimate = quick_answer(history(24, seed=seed), quick_candidates)
        assert estimate.none > 0.5, seed
        assert max(estimate.inclusion.values()) < 0.5, seed


def test_more_flights_narrow_the_forecast_and_the_posterior_of_drag() -> None:
    few, many = (history(count, seed=3) for count in (2, 30))
    assert ends(many)[1] < ends(few)[1]
    assert quick_answer(many, quick_candidates).log_cd[1] < quick_answer(few, quick_candidates).log_cd[1]


@pytest.mark.usefixtures("shapes_checked")
def test_a_rocket_that_flew_lower_is_forecast_lower() -> None:
    whole = history(10)
    lower = [
        flight.with_changes(apogee=0.8 * flight.apogee if flight.apogee else None, top_speed=None, coast_to_apogee=None)
        for flight in whole.flights
    ]
    same = [flight.with_changes(top_speed=None, coast_to_apogee=None) for flight in whole.flights]
    ratio = ends(replace(whole, flights=tuple(lower)))[0] / ends(replace(whole, flights=tuple(same)))[0]
    assert 0.75 < ratio < 0.9


def test_names_of_flights_rockets_and_configurations_change_nothing() -> None:
    whole = history(9, wear=0.03)
    renamed = [
        flight.with_changes(flight_id=f"x{number}", rocket="Other", config="Z")
        for number, flight in enumerate(whole.flights)
    ]
    one, other = (quick_answer(of, quick_candidates) for of in (whole, replace(whole, flights=tuple(renamed))))
    assert one.inclusion == pytest.approx(other.inclusion, abs=1e-6)
    assert one.log_apogee == pytest.approx(other.log_apogee, abs=1e-6)


def test_the_order_of_simultaneous_flights_matters_only_for_effects_that_grow() -> None:
    """Two flights of one day with the same setup exchange their readouts."""
    whole = history(10)
    flights = list(whole.flights)
    first, second = flights[0], flights[2]
    shown = ("apogee", "top_speed", "coast_to_apogee")
    flights[0] = first.with_changes(**{name: second.number(name) for name in shown})
    flights[2] = second.with_changes(**{name: first.number(name) for name in shown})
    one, other = (quick_answer(of, quick_candidates) for of in (whole, replace(whole, flights=tuple(flights))))
    assert one.summary.baseline.apogee == pytest.approx(other.summary.baseline.apogee, abs=1e-6)
    assert one.log_apogee == pytest.approx(other.log_apogee, abs=0.02)
    assert one.inclusion["mass_offset"] == pytest.approx(other.inclusion["mass_offset"], abs=0.1)


def test_probabilities_are_between_zero_and_one_and_quantiles_in_order() -> None:
    rng = np.random.default_rng(0)
    estimate = answer(3 * rng.normal(size=(50, 5, width(12))), 12)
    for chances in (estimate.inclusion, estimate.none, estimate.unexplained):
        assert ((chances >= 0) & (chances <= 1)).all()
    assert (np.diff(estimate.quantiles, axis=1) > 0).all()
    assert (estimate.scale > 0).all()


@pytest.mark.usefixtures("shapes_checked")
def test_an_untrained_member_answers_like_the_linear_fit() -> None:
    assert monotone(np.zeros(len(LEVELS))) == pytest.approx(STANDARD)
    draws = quantile_draws(STANDARD, 4000)
    assert draws.mean() == pytest.approx(0.0, abs=1e-3)
    assert draws.std() == pytest.approx(1.0, abs=0.02)


def test_a_card_with_other_features_is_refused() -> None:
    shipped = load_history()
    with pytest.raises(DamagedModel, match="other features"):
        checked(replace(shipped, features=shipped.features[:-1]))


OTHERS_FLEW_ONE = SharedPrior(
    (TermName("drag", "fleet"), TermName("thrust", "motor", "AeroTech F39T")),
    np.array([-0.55, 0.02]),
    np.array([[0.02, 1e-4], [1e-4, 1e-3]]),
)
"""Information from other rockets, which flew one of the motors that are new to this rocket."""


@pytest.mark.parametrize("shared", [None, OTHERS_FLEW_ONE])
def test_many_motors_at_once_are_answered_as_if_each_were_alone(shared: SharedPrior | None) -> None:
    """Motors that the rocket flew, others, and one twice."""
    whole = history(8)
    flown = list(zip(whole.flights[:-1], whole.found[:-1], strict=True))
    motors = [catalogue().resolve(name) for name in ("F24-4W", "F39-6T", "E35-5W", "E15-4W", "F39-6T")]
    plans = [(whole.flights[-1].with_changes(motor=found.motor.name), found) for found in motors]
    together = forecasts_at_once(flown, plans, shared=shared)
    for plan, estimate in zip(plans, together, strict=True):
        alone = forecast_at_once(flown, plan, shared=shared)
        assert estimate.log_apogee == pytest.approx(alone.log_apogee, abs=1e-6)
        assert [*estimate.log_cd, *estimate.log_alpha] == pytest.approx([*alone.log_cd, *alone.log_alpha], abs=1e-6)
        assert estimate.inclusion == pytest.approx(alone.inclusion, abs=1e-6)
