"""The shipped field ensemble: right posteriors from any readouts, and warnings when they are due."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fieldkit.errors import ImpossibleFlight
from fieldkit.flight import Flight
from fieldkit.inference.network.ensemble import Ensemble
from fieldkit.inference.network.field_ensemble import infer_field, infer_observed, load_field, posterior
from fieldkit.inference.network.outliers import misfit
from fieldkit.inference.validation.field import score, table
from fieldkit.model.observation_noise import SUBSETS, measure
from fieldkit.model.observations import ALPHA_SD, DECLARED_FIELDS, INDEPENDENT_READOUTS, READOUT_NAMES, Observed
from fieldkit.model.prior_predictive import Truth, flown_motors, simulate
from fieldkit.motors import catalogue
from fieldkit.plugins import trained_folder


@pytest.fixture(scope="module")
def field() -> Ensemble:
    return load_field()


@pytest.fixture(scope="module")
def truth() -> Truth:
    return simulate(np.random.default_rng(11), flown_motors(catalogue().motors), 2000)


@pytest.fixture(scope="module")
def observed(truth: Truth) -> Observed:
    return measure(np.random.default_rng(12), truth)


def flight(**known: float) -> Flight:
    """A D12 flight of a 41 mm rocket, with an altimeter's readouts."""
    usual = {"dry_mass": 0.12, "diameter": 0.041, "apogee": 190.0, "top_speed": 62.0}
    return Flight(flight_id="1", rocket="Bertha", motor="Estes D12-5", **{**usual, **known})


@pytest.mark.parametrize("name", SUBSETS)
def test_intervals_have_their_stated_coverage(name: str, field: Ensemble, truth: Truth, observed: Observed) -> None:
    density = posterior(observed.only(*SUBSETS[name]), field)
    found, _ = score(np.random.default_rng(1), density.rows(slice(0, 1000)), truth.parameters[:1000])
    for parameter in ("drag_area", "alpha"):
        for level, covered in found["coverage"][parameter].items():
            assert covered == pytest.approx(float(level), abs=0.05)


def test_every_additional_readout_narrows_the_posterior(field: Ensemble, observed: Observed) -> None:
    some = observed.rows(slice(0, 500))
    sds = [posterior(some.only(*kept), field).margin(1).moments()[1].mean() for kept in SUBSETS.values()]
    assert sds == sorted(sds, reverse=True)
    assert sds[-1] < 0.7 * sds[0]


def test_the_accuracy_in_the_card_is_sufficient() -> None:
    card = json.loads((trained_folder("field") / "card.json").read_text())
    for name in SUBSETS:
        for coverage in card["test"][name]["coverage"].values():
            for level, covered in coverage.items():
                assert covered == pytest.approx(float(level), abs=0.015), (name, level)
    assert len(table(card)) > 10


def test_a_flight_gets_the_same_answer_alone_and_among_others(field: Ensemble) -> None:
    flights = [flight(), flight(apogee=150.0), flight(coast_to_apogee=5.0)]
    found = [catalogue().find(one.motor) for one in flights]
    together = infer_field(flights, found, field)
    alone = [infer_field([one], [motor], field) for one, motor in zip(flights, found, strict=True)]
    assert together.cd == pytest.approx([one.cd[0] for one in alone], rel=1e-4)
    assert together.alpha_sd == pytest.approx([one.alpha_sd[0] for one in alone], rel=1e-4)


def test_less_height_at_the_same_speed_means_more_drag(field: Ensemble) -> None:
    flights = [flight(apogee=170.0), flight(apogee=195.0)]
    found = infer_field(flights, [catalogue().find(one.motor) for one in flights], field)
    assert found.cd[0] > found.cd[1]


def test_draws_agree_with_mean_and_spread(field: Ensemble) -> None:
    found = infer_field([flight()], [catalogue().find("Estes D12-5")], field)
    area, alpha = found.draws(np.random.default_rng(1), 20_000)
    assert area.mean() == pytest.approx(found.drag_area[0], rel=0.02)
    assert alpha.std() == pytest.approx(found.alpha_sd[0], rel=0.05)
    assert found.cd[0] == pytest.approx(found.drag_area[0] / (np.pi / 4 * 0.041**2))


def test_without_a_diameter_drag_area_is_known_and_cd_is_not(field: Ensemble) -> None:
    whole = flight(coast_to_apogee=5.0, burn_time=1.5)
    motor = catalogue().find("Estes D12-5")
    found = infer_field([whole, replace(whole, diameter=None)], [motor, motor], field)
    assert found.drag_area[1] == pytest.approx(found.drag_area[0], rel=0.3)
    assert found.cd_sd[1] / found.cd[1] > 1.2 * found.cd_sd[0] / found.cd[0]
    assert any("no diameter" in line for line in found.warnings[1])


def test_a_flight_without_any_readout_is_answered_by_the_prior_with_a_warning(field: Ensemble) -> None:
    silent = Flight(flight_id="1", motor="Estes D12-5", dry_mass=0.12, diameter=0.041)
    found = infer_field([silent], [catalogue().find("Estes D12-5")], field)
    assert found.alpha[0] == pytest.approx(1.0, abs=0.03)
    assert found.alpha_sd[0] == pytest.approx(ALPHA_SD, abs=0.02)
    assert any("no readout" in line for line in found.warnings[0])


def test_apogee_of_a_heavy_rocket_alone_does_not_constrain_drag(field: Ensemble) -> None:
    heavy = Flight(flight_id="1", motor="Estes D12-5", dry_mass=0.25, diameter=0.025, apogee=70.0)
    found = infer_field([heavy], [catalogue().find("Estes D12-5")], field)
    assert any("apogee alone cannot separate drag from thrust" in line for line in found.warnings[0])


def test_a_missing_mass_is_an_error_that_names_the_flight(field: Ensemble) -> None:
    with pytest.raises(ImpossibleFlight, match="flight 1: no dry mass"):
        infer_field([Flight(flight_id="1", apogee=100.0)], [catalogue().find("Estes D12-5")], field)


def test_one_good_flight_in_a_hundred_gets_a_warning(field: Ensemble, observed: Observed) -> None:
    assert 0.002 < (misfit(field, observed) >= 0).mean() < 0.025


@pytest.mark.parametrize(("name", "factor"), [("apogee", 1.5), ("top_speed", 1.5), ("coast_to_apogee", 0.4)])
def test_an_inconsistent_readout_is_named(name: str, factor: float, field: Ensemble, observed: Observed) -> None:
    some = observed.rows(slice(0, 300))
    readouts = some.readouts.copy()
    readouts[:, READOUT_NAMES.index(name)] *= factor
    which = misfit(field, some.with_readouts(readouts))
    possible = {"apogee": ("apogee", "eject_altitude")}.get(name, (name,))  # either of two heights may be the wrong one
    assert np.isin(which, [INDEPENDENT_READOUTS.index(one) for one in possible]).mean() > 0.6


def test_an_inconsistent_readout_is_left_out_and_the_interval_widens(field: Ensemble) -> None:
    good = flight(coast_to_apogee=5.0, burn_time=1.5)
    motor = catalogue().find("Estes D12-5")
    found = infer_field([good, replace(good, apogee=400.0)], [motor, motor], field)
    assert found.fits.tolist() == [True, False]
    assert found.warnings[1][0].startswith("apogee of 400 m is inconsistent with the rest")
    assert found.cd_sd[1] > found.cd_sd[0]


def test_conditions_beyond_training_are_reported(field: Ensemble) -> None:
    brick = flight(dry_mass=0.9)
    found = infer_field([brick], [catalogue().find("Estes D12-5")], field)
    assert any("outside the training range" in line for line in found.warnings[0])


def test_declared_conditions_may_all_be_missing(field: Ensemble, observed: Observed) -> None:
    declared = observed.declared.copy()
    declared[:, 1:] = np.nan
    found = infer_observed(replace(observed, declared=declared).rows(slice(0, 20)), field)
    assert np.isfinite(found.cd).all()
    assert DECLARED_FIELDS[0] == "dry_mass"
