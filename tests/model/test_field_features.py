"""The features of the field ensemble, and its simulated training flights."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import Flight
from fieldkit.model.field_features import FEATURES, features, shown
from fieldkit.model.observation_noise import NOISE, SUBSETS, forget, measure
from fieldkit.model.observations import (
    ALPHA_RANGE,
    ALPHA_SD,
    DECLARED_FIELDS,
    INDEPENDENT_READOUTS,
    READOUT_NAMES,
    Observed,
    drag_area_range,
    observe,
)
from fieldkit.model.prior_predictive import Truth, flown_motors, simulate
from fieldkit.motors import catalogue


@pytest.fixture(scope="module")
def truth() -> Truth:
    return simulate(np.random.default_rng(1), flown_motors(catalogue().motors), 3000)


@pytest.fixture(scope="module")
def observed(truth: Truth) -> Observed:
    return measure(np.random.default_rng(2), truth)


def test_no_feature_is_missing_whatever_the_flyer_omitted(observed: Observed) -> None:
    gaps = forget(np.random.default_rng(3), observed)
    columns = features(gaps)
    assert columns.shape == (len(gaps), len(FEATURES))
    assert np.isfinite(columns).all()
    bare = Observed(
        gaps.motor, gaps.declared * np.where(np.arange(len(DECLARED_FIELDS)) > 0, np.nan, 1.0), gaps.readouts * np.nan
    )
    assert np.isfinite(features(bare)).all()


def test_average_acceleration_is_not_independent_evidence(observed: Observed) -> None:
    readouts = observed.readouts.copy()
    column = READOUT_NAMES.index
    readouts[:, column("burn_time")] = np.maximum(readouts[:, column("burn_time")], 0.1)
    readouts[:, column("avg_accel")] = readouts[:, column("top_speed")] / readouts[:, column("burn_time")]
    exact = observed.with_readouts(readouts)
    known, unknown = features(exact), features(exact.without("avg_accel"))
    flag = FEATURES.index("has_avg_accel")
    differing = [name for name, a, b in zip(FEATURES, known.T, unknown.T, strict=True) if not np.allclose(a, b)]
    assert differing == [FEATURES[flag]]


def test_average_acceleration_substitutes_for_a_missing_speed(observed: Observed) -> None:
    speed = INDEPENDENT_READOUTS.index("top_speed")
    moving = observed.rows(observed.readout("burn_time") >= 0.5)
    typed, restored = shown(moving)[:, speed], shown(moving.without("top_speed"))[:, speed]
    assert np.median(np.abs(restored - typed)) < 0.03


def test_a_burn_time_rounded_to_a_tenth_is_refined_by_the_other_two_readouts() -> None:
    def burn_time(**readouts: float) -> float:
        flight = Flight(flight_id="1", motor="Estes C6", dry_mass=0.06, diameter=0.025, **readouts)
        seen = shown(observe([flight], [catalogue().find("Estes C6")]))
        return float(
            np.exp(seen[0, INDEPENDENT_READOUTS.index("burn_time")]) * catalogue().find("Estes C6").motor.burn_time
        )

    assert burn_time(burn_time=1.8) == pytest.approx(1.8)
    assert burn_time(burn_time=1.8, top_speed=60.0, avg_accel=60.0 / 1.83) == pytest.approx(1.83)
    assert burn_time(burn_time=1.8, top_speed=60.0, avg_accel=60.0 / 2.4) == pytest.approx(1.85)


def test_a_flight_without_a_mass_is_an_error_that_reports_it() -> None:
    flight = Flight(flight_id="7", motor="Estes C6", apogee=100.0)
    with pytest.raises(ImpossibleFlight, match="flight 7: no dry mass"):
        observe([flight], [catalogue().find("Estes C6")])


def test_a_recorded_flight_and_one_in_arrays_have_the_same_features(observed: Observed) -> None:
    motor = catalogue().find("Estes C6-5")
    flight = Flight(flight_id="1", motor="Estes C6-5", dry_mass=0.06, diameter=0.025, apogee=200.0, top_speed=70.0)
    one = observe([flight], [motor])
    assert one.given("delay")[0] == 5.0
    assert one.readout("apogee")[0] == 200.0
    assert np.isnan(one.readout("burn_time")[0])
    both = observe([flight, replace(flight, apogee=None)], [motor, motor])
    assert features(both)[0] == pytest.approx(features(one)[0])


def test_without_a_diameter_any_drag_area_is_possible(observed: Observed, truth: Truth) -> None:
    known = np.ptp(np.stack(drag_area_range(observed)), axis=0)
    declared = observed.declared.copy()
    declared[:, DECLARED_FIELDS.index("diameter")] = np.nan
    low, high = drag_area_range(replace(observed, declared=declared))
    assert (high - low > known).all()
    assert ((np.log(truth.drag_area) > low) & (np.log(truth.drag_area) < high)).all()


def test_the_same_seed_gives_the_same_flights_and_another_does_not() -> None:
    motors = flown_motors(catalogue().motors)[:20]
    one, same, other = (simulate(np.random.default_rng(seed), motors, 50) for seed in (5, 5, 6))
    assert np.array_equal(one.readouts, same.readouts, equal_nan=True)
    assert not np.array_equal(one.alpha[:10], other.alpha[:10])


def test_simulated_flights_cover_the_prior_and_lift_off(truth: Truth) -> None:
    assert len(truth) > 2800
    assert truth.readouts[:, READOUT_NAMES.index("apogee")].min() > 5
    assert ((truth.alpha > ALPHA_RANGE[0]) & (truth.alpha < ALPHA_RANGE[1])).all()
    assert truth.alpha.std() == pytest.approx(ALPHA_SD, rel=0.05)
    assert np.percentile(truth.cd, [1, 50, 99]) == pytest.approx([0.204, 0.55, 1.47], rel=0.1)


def test_readouts_have_the_resolution_of_the_device(observed: Observed) -> None:
    for column, name in enumerate(READOUT_NAMES):
        steps = observed.readouts[:, column] / NOISE[name].step
        assert np.nanmax(np.abs(steps - np.round(steps))) < 1e-6


def test_average_acceleration_is_speed_over_burn_time_except_for_rounding(observed: Observed) -> None:
    long = observed.rows(observed.readout("burn_time") > 1.5)
    ratio = long.readout("top_speed") / (long.readout("avg_accel") * long.readout("burn_time"))
    assert np.median(ratio) == pytest.approx(1.0, abs=0.01)


def test_every_evaluated_subset_of_readouts_occurs_in_training(observed: Observed) -> None:
    gaps = forget(np.random.default_rng(4), observed)
    patterns = {tuple(row) for row in np.isfinite(gaps.readouts)}
    whole = np.isfinite(observed.readouts).all(axis=0)
    for kept in SUBSETS.values():
        assert (
            tuple(bool(w) and name in kept for name, w in zip(READOUT_NAMES, whole, strict=True)) in patterns
            or kept == READOUT_NAMES
        )
