"""Simulated histories of the study of a quick network: reproducible, with the truth that they state."""

import numpy as np
import pytest

from fieldkit.model.causes import NAMES
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.physics.history import groups
from fieldkit.selection.prior import inclusion_probabilities
from studies.quick_network import unexplained_patterns
from studies.quick_network.drawn_rockets import (
    MAX_FLIGHTS,
    READOUT_SETS,
    SENSORS,
    draw_rocket,
    split_motors,
    stock,
)
from studies.quick_network.inputs import effect_names
from studies.quick_network.tables import passes, table
from studies.quick_network.world import USUAL, secant, simulated_histories

CHECK_SHAPES = False
KNOWN = stock(split_motors()[0])
PRIOR = inclusion_probabilities()


def test_rockets_have_the_requested_numbers_of_flights_and_motors() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_rocket(rng, KNOWN) for _ in range(200)]
    lengths = np.array([len(one.used_in_fit) for one in drawn])
    assert lengths.min() == 1
    assert MAX_FLIGHTS / 2 < lengths.max() <= MAX_FLIGHTS
    assert all(len(one.flights) == len(one.found) == len(one.used_in_fit) + 1 == len(one.shows) + 1 for one in drawn)
    assert {name for one in drawn for row in one.shows for name in row} == set(READOUT_SETS[2])
    rocket = drawn[0]
    assert rocket.sds.shape == (len(rocket.flights), len(OBSERVED_READOUTS))
    assert {one.source for one in drawn} == set(SENSORS)


@pytest.mark.usefixtures("shapes_checked")
def test_a_history_states_its_effects_and_causes_and_is_drawn_again_from_its_seed() -> None:
    found = simulated_histories(np.random.default_rng(1), KNOWN, PRIOR, 8)
    assert len({one.effects for one in found}) > 2
    for one in found:
        assert set(one.effects) <= set(effect_names())
        assert one.apogee > 3.0
        assert len(one.causes) == one.history.flown
        assert not one.history.flights[-1].readouts()
    again = simulated_histories(np.random.default_rng(1), KNOWN, PRIOR, 8)
    assert [one.apogee for one in again] == [one.apogee for one in found]


def test_effects_and_causes_are_present_with_their_prior_probability() -> None:
    nothing = dict.fromkeys(PRIOR, 0.0)
    found = [one for seed in range(4) for one in simulated_histories(np.random.default_rng(seed), KNOWN, nothing, 8)]
    assert all((one.effects, one.unexplained) == ((), False) for one in found)
    causes = np.concatenate([one.causes for one in found])
    assert np.mean(causes != USUAL) == pytest.approx(0.1, abs=0.04)
    assert len(set(causes.tolist())) > len(NAMES) / 2
    everything = simulated_histories(np.random.default_rng(3), KNOWN, dict.fromkeys(PRIOR, 1.0), 3, flights=6)
    assert all(one.unexplained and len(one.effects) > 5 for one in everything)


def test_scales_have_the_median_and_tails_of_their_prior() -> None:
    rng = np.random.default_rng(0)
    drawn = np.array([secant(rng, 2.0, np.pi / 2, (1e-9, 1e9)) for _ in range(4000)])
    assert np.median(drawn) == pytest.approx(2.0, rel=0.1)
    assert np.mean(drawn > 2.0 * np.tan(0.45 * np.pi)) == pytest.approx(0.1, abs=0.02)


def test_a_bad_day_is_shared_by_its_flights() -> None:
    shared = 0
    for seed in range(20):
        rocket = draw_rocket(np.random.default_rng(seed), KNOWN, 20)
        days = groups(rocket.flights, rocket.found, "day")
        bad = unexplained_patterns._day(np.random.default_rng(seed), rocket) > 0
        if rocket.flights[0].date_time:
            assert len({day for day, is_bad in zip(days, bad, strict=True) if is_bad}) == 1
            assert not {day for day, is_bad in zip(days, bad, strict=True) if not is_bad} & {days[np.argmax(bad)]}
        shared += bad.sum() > 1
    assert shared > 5


def test_a_table_has_the_flights_and_the_closed_forms_of_each_history() -> None:
    pairs = list(passes(simulated_histories(np.random.default_rng(5), KNOWN, PRIOR, 2, flights=5)))
    whole = table(pairs)
    assert whole.mask.sum(axis=1).tolist() == [6.0] * len(pairs)
    assert (whole.judged <= whole.mask).all()
    assert np.allclose(whole.cause_chance[:, :5].astype(float).sum(axis=-1), 1.0, atol=0.01)
    middle = np.median(whole.mixture.astype(float), axis=1)
    assert np.allclose(middle, whole.column("mean"), atol=0.05)
