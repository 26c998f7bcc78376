"""Probabilities of effects from one linear pass, with the prior of the loop."""

from dataclasses import replace

import pytest

from fieldkit.inference.history.effect_probabilities import EffectProbabilities, effect_probabilities
from fieldkit.physics.history import History
from fieldkit.selection.prior import UNEXPLAINED, inclusion_probabilities
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import history

CHECK_SHAPES = False


def found_in(of: History) -> EffectProbabilities:
    return effect_probabilities(of, quick_candidates, inclusion_probabilities(), UNEXPLAINED)


@pytest.mark.usefixtures("shapes_checked")
def test_strong_wear_is_found_and_is_the_most_probable_effect() -> None:
    found = found_in(history(24, wear=0.05))
    assert found.inclusion["wear"] > 0.8
    assert found.none < 0.2
    assert max(found.inclusion, key=lambda name: found.inclusion[name]) == "wear"


def test_nothing_is_found_in_a_clean_history() -> None:
    for seed in range(3):
        found = found_in(history(24, seed=seed))
        assert found.none > 0.5, seed
        assert max(found.inclusion.values()) < 0.5, seed


def test_flights_that_say_nothing_leave_the_prior_of_the_loop() -> None:
    """One flight of an unknown rocket: the probability of each effect is that before any flight."""
    prior = inclusion_probabilities()
    for name, chance in found_in(history(1, recorded=("apogee",))).inclusion.items():
        assert chance == pytest.approx(prior[name], rel=0.3), name


def test_names_of_flights_rockets_and_configurations_change_nothing() -> None:
    whole = history(9, wear=0.03)
    renamed = [
        flight.with_changes(flight_id=f"x{number}", rocket="Other", config="Z")
        for number, flight in enumerate(whole.flights)
    ]
    one, other = found_in(whole), found_in(replace(whole, flights=tuple(renamed)))
    assert one.inclusion == pytest.approx(other.inclusion, abs=1e-6)
