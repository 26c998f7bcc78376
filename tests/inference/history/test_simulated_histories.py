"""Simulated histories: reproducible draws, recorded values, and shards that resume."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.inference.history import shards, unexplained_patterns
from fieldkit.inference.history import simulated_histories as simulated
from fieldkit.inference.history.drawn_rockets import (
    MAX_FLIGHTS,
    READOUT_SETS,
    SENSORS,
    draw_rocket,
    split_motors,
    stock,
)
from fieldkit.inference.history.features import effect_names, feature_names
from fieldkit.inference.history.linear_fit import declared_terms, history_model
from fieldkit.inference.history.simulated_histories import simulated_histories
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import base_model
from fieldkit.model.term_names import TermName
from fieldkit.physics.history import groups
from fieldkit.selection.extended_model import rocket_model
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
        model = base_model(one.history, CERTIFIED_PRIOR)
        acting = {candidate.effect for candidate in quick_candidates(model)}
        always = {term.name.quantity for term in declared_terms(one.history.flights)} if not one.selects else set()
        assert set(one.effects) == acting - {""} - always
        assert one.unexplained


def test_simulated_rockets_have_every_parameter_of_the_model_that_is_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """That of the loop or of forecasts, with wind, lots of motors, readouts measured in samples, and the drift of a
    fleet over several years; in addition only weak effects."""
    worlds: list[Any] = []

    class Seen(simulated._World):
        def __init__(self, *args: Any) -> None:
            super().__init__(*args)
            worlds.append(self.model.names)

    monkeypatch.setattr(simulated, "_World", Seen)
    nothing, compared = dict.fromkeys(PRIOR, 0.0), set()
    for seed in (*range(24), 27, 109):  # the last two draw flights over several years, and from logs
        for one in simulated_histories(np.random.default_rng(seed), KNOWN, quick_candidates, nothing, 1, 1, flights=8):
            history = one.history
            if one.selects:
                model = rocket_model(history, hyperprior=CERTIFIED_PRIOR)
                assert set(model.names) == set(history_model(history, CERTIFIED_PRIOR, declared=False).names)
            else:
                model = history_model(history, learned(), one.shared, declared=True)
            others = set(worlds[-1]) - set(model.names)
            assert set(model.names) <= set(worlds[-1])
            assert all(name.level == "background" for name in others)
            compared |= set(model.names)
    levels = {("wind", "effect", ""), ("base_drag", "usual", ""), ("top_speed", "logged", ""), ("mass", "drift", 3)}
    assert {TermName(*one) for one in levels} <= compared
    assert any(name.level == "lot" for name in compared)


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


def test_all_readouts_of_a_flight_have_a_source_and_a_standard_deviation_or_none_has() -> None:
    rocket = draw_rocket(np.random.default_rng(4), KNOWN, 30)
    assert rocket.sds.shape == (31, len(OBSERVED_READOUTS))
    sources = {draw_rocket(np.random.default_rng(seed), KNOWN, 2).source for seed in range(40)}
    assert sources == set(SENSORS)
    for one in simulated_histories(np.random.default_rng(8), KNOWN, quick_candidates, PRIOR, 12, 1, flights=4):
        for flight in one.history.flights[:-1]:
            assert set(flight.sd) in (set(), set(flight.readouts()))
            assert set(flight.source) in (set(), set(flight.readouts()))
            assert all(sd > 0 for sd in flight.sd.values())


def test_shards_of_another_catalog_are_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "ROCKETS_PER_SHARD", 2)
    known, others = split_motors()
    changed = [replace(known[0], thrust=known[0].thrust * 1.01), *known[1:]]
    with ThreadPoolExecutor(1) as pool:
        shards.simulate_table(tmp_path, 5, 2, quick_candidates, PRIOR, pool)
        monkeypatch.setattr(shards, "split_motors", lambda: (changed, others))
        shards.simulate_table(tmp_path, 5, 2, quick_candidates, PRIOR, pool)
    assert len(list(tmp_path.glob("*/*.npy"))) == 2


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
