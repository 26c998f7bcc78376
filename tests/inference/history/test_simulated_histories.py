"""Simulated histories: reproducible draws, recorded values, and shards that resume."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from fieldkit.inference.history import shards
from fieldkit.inference.history.drawn_rockets import MAX_FLIGHTS, READOUT_SETS, draw_rocket, stock
from fieldkit.inference.history.features import effect_names, feature_names
from fieldkit.inference.history.simulated_histories import simulated_histories
from fieldkit.model.hyperprior import certified
from fieldkit.model.prior_predictive import split_motors
from fieldkit.model.rocket_model import base_model
from fieldkit.selection.prior import inclusion_probabilities
from fieldkit.selection.quick_candidates import quick_candidates

CHECK_SHAPES = False
KNOWN = stock(split_motors()[0])
PRIOR = inclusion_probabilities()


def test_rockets_have_the_requested_numbers_of_flights_and_motors() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_rocket(rng, KNOWN) for _ in range(200)]
    lengths = np.array([len(one.used_in_fit) for one in drawn])
    assert lengths.min() == 1
    assert lengths.max() > MAX_FLIGHTS / 2
    assert lengths.max() <= MAX_FLIGHTS
    assert all(len(one.flights) == len(one.found) == len(one.used_in_fit) + 1 == len(one.shows) + 1 for one in drawn)
    motors = [len({motor.motor.designation for motor in one.found[:-1]}) for one in drawn]
    assert max(motors) >= 5
    assert min(motors) == 1
    assert {name for one in drawn for row in one.shows for name in row} == set(READOUT_SETS[2])


@pytest.mark.usefixtures("shapes_checked")
def test_a_history_states_its_effects_and_has_the_readouts_of_its_rocket() -> None:
    found = simulated_histories(np.random.default_rng(1), KNOWN, quick_candidates, PRIOR, 8, 2)
    assert len({one.effects for one in found}) > 2
    for one in found:
        assert set(one.effects) <= set(effect_names())
        assert one.apogee > 3.0
        assert not one.history.flights[-1].readouts()
    again = simulated_histories(np.random.default_rng(1), KNOWN, quick_candidates, PRIOR, 8, 2)
    assert [one.apogee for one in again] == [one.apogee for one in found]


def test_effects_are_present_with_their_prior_probability() -> None:
    """No effects with a prior of zero; with a prior of one all effects that each rocket's flights could show, and a
    pattern."""
    nothing, everything = (dict.fromkeys(PRIOR, chance) for chance in (0.0, 1.0))
    for one in simulated_histories(np.random.default_rng(3), KNOWN, quick_candidates, nothing, 5, 2, flights=6):
        assert (one.effects, one.unexplained) == ((), False)
    found = simulated_histories(np.random.default_rng(3), KNOWN, quick_candidates, everything, 5, 2, flights=6)
    assert found
    for one in found:
        model = base_model(one.history.flights, one.history.found, certified(), 6)
        acting = {candidate.effect for candidate in quick_candidates(model, one.history.used_in_fit)}
        assert set(one.effects) == acting - {""}
        assert one.unexplained


def test_shards_of_another_prior_are_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "ROCKETS_PER_SHARD", 3)
    with ThreadPoolExecutor(1) as pool:
        shards.simulate_table(tmp_path, 5, 3, quick_candidates, PRIOR, pool)
        shards.simulate_table(tmp_path, 5, 3, quick_candidates, dict.fromkeys(PRIOR, 0.01), pool)
    assert len(list(tmp_path.glob("*/*.npy"))) == 2


@pytest.mark.usefixtures("shapes_checked")
def test_features_are_finite_and_named() -> None:
    found = simulated_histories(np.random.default_rng(2), KNOWN, quick_candidates, PRIOR, 6, 1)
    names = effect_names()
    for made in shards.summarized(found, quick_candidates, names):
        assert made.features.shape == (1, len(feature_names(names)))
        assert np.isfinite(made.features).all()
        assert made.baseline.apogee_sd > made.baseline.parameter_sd > 0


def test_existing_shards_are_used_and_missing_ones_created(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "ROCKETS_PER_SHARD", 3)
    with ThreadPoolExecutor(1) as pool:
        whole = shards.simulate_table(tmp_path, 5, 6, quick_candidates, PRIOR, pool)
        first = sorted(tmp_path.glob("*/*.npy"))
        first[1].unlink()
        kept = first[0].stat().st_mtime_ns
        again = shards.simulate_table(tmp_path, 5, 6, quick_candidates, PRIOR, pool)
    assert len(first) == 2
    assert first[0].stat().st_mtime_ns == kept
    assert np.array_equal(whole.features, again.features)
    assert np.array_equal(whole.truths, again.truths)
