"""Rivals on cases computed by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtri

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.fleet_ratio import FLIGHT_SD, MEAN, MEAN_SD, ROCKET_SD, fleet_ratio, ratio_posterior
from fieldkit.forecast.evaluation.rivals import RIVALS, flight_before, last_on_motor, rival_draws, scalar
from fieldkit.forecast.evaluation.uncalibrated import NOMINAL_CD, Simulated, simulate
from fieldkit.model.hyperprior import learned
from fieldkit.motors import catalogue
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.setups import reference_area

F24, F39 = (catalogue().resolve(name) for name in ("F24-4W", "F39-6T"))


def flown(apogee: float | None, simulated: float = 200.0, rocket: str = "Astra", motor: str = "F24-4W") -> Simulated:
    """A flight with its simulation."""
    found = F24 if motor == "F24-4W" else F39
    return Simulated(Flight("1", rocket, motor=motor, apogee=apogee), found, simulated)


def forecast_by(rival: str, earlier: list[Simulated], plan: Simulated) -> list[float]:
    """A rival's forecast; None if it has too little data."""
    draws = RIVALS[rival](earlier, plan)
    return [] if draws is None else draws.tolist()


def test_without_a_flight_only_rivals_with_a_prior_or_a_simulation_forecast() -> None:
    plan = flown(None, 210.0)
    assert rival_draws([], plan).keys() == {"uncalibrated", "fleet_ratio"}
    other = [flown(180.0, rocket="Luna")]
    assert rival_draws(other, plan).keys() == {"uncalibrated", "fleet_ratio"}


def test_the_scalar_correction_is_the_mean_ratio_of_the_rocket_and_has_a_spread_from_three_flights_on() -> None:
    earlier = [flown(220.0), flown(500.0, rocket="Luna"), flown(130.0, 100.0)]
    plan = flown(None, 210.0)
    assert forecast_by("scalar", earlier, plan) == pytest.approx([210 * 1.2])
    draws = scalar([*earlier, flown(200.0)], plan)
    ratios = np.array([1.1, 1.3, 1.0])
    assert draws is not None
    assert np.median(draws) == pytest.approx(210 * ratios.mean())
    sd = np.log(ratios).std(ddof=1) * np.sqrt(4 / 3)
    assert np.quantile(draws, 0.95) == pytest.approx(210 * ratios.mean() * np.exp(sd * ndtri(0.95)), rel=0.01)


def test_the_last_flight_on_the_motor_is_repeated_or_else_scaled() -> None:
    earlier = [flown(220.0), flown(240.0), flown(390.0, 400.0, motor="F39-6T"), flown(500.0, rocket="Luna")]
    assert forecast_by("last_on_motor", earlier, flown(None, 210.0)) == [240.0]
    assert forecast_by("last_on_motor", earlier[:2], flown(None, 400.0, motor="F39-6T")) == pytest.approx([400 * 1.15])
    assert forecast_by("flight_before", earlier, flown(None, 210.0)) == [390.0]
    assert last_on_motor([], flown(None)) is None
    assert flight_before([], flown(None)) is None


def test_the_last_flight_rule_scatters_as_it_did_on_all_rockets() -> None:
    def width(apogees: list[float]) -> float:
        others = [flown(apogee, rocket="Luna") for apogee in apogees]
        draws = forecast_by("last_flight", [*others, flown(220.0), flown(240.0)], flown(None, 210.0))
        assert np.median(draws) == pytest.approx(240.0)
        return float(np.log(np.quantile(draws, 0.95) / np.quantile(draws, 0.05)))

    assert width([200.0, 201.0] * 20) < 0.3 < 0.6 < width([200.0, 300.0] * 20)
    scaled = forecast_by("last_flight", [flown(220.0), flown(240.0)], flown(None, 400.0, motor="F39-6T"))
    assert np.median(scaled) == pytest.approx(400 * 1.2)
    assert not forecast_by("last_flight", [flown(500.0, rocket="Luna")], flown(None, 210.0))


def test_a_flight_that_the_simulation_leaves_on_the_pad_has_no_ratio() -> None:
    earlier = [flown(220.0), flown(100.0, 0.0)]
    assert forecast_by("scalar", earlier, flown(None, 210.0)) == pytest.approx([231.0])
    assert np.median(fleet_ratio(earlier, flown(None, 0.0))) == 0.0


def test_the_uncalibrated_forecast_is_always_the_plain_simulation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = Flight("1", "Astra", motor="F24-4W", dry_mass=0.32, apogee=250.0)
    wide = plan.with_changes(diameter=0.066)
    (thumb, known) = simulate([(plan, F24), (wide, F24)])
    area = reference_area([plan, wide], 0)
    expected = fly(field_setup([plan, wide], [F24, F24], NOMINAL_CD * area)).readouts()["apogee"]
    assert [thumb.simulated, known.simulated] == pytest.approx(expected.tolist())
    assert area[1] == pytest.approx(np.pi / 4 * 0.066**2)
    other = replace(learned(), means={**learned().means, "drag": 1.0})
    monkeypatch.setattr("fieldkit.model.hyperprior.learned", lambda: other)
    monkeypatch.setattr("fieldkit.forecast.assumed.learned", lambda: other)
    assert simulate([(wide, F24)])[0].simulated == known.simulated
    assert simulate([]) == []


def test_the_fleet_ratio_starts_from_its_prior() -> None:
    draws = fleet_ratio([], flown(None, 200.0))
    assert np.median(draws) == pytest.approx(200 * 0.85, rel=0.01)
    logs = np.log(draws / 170)
    middle = np.quantile(logs, 0.84) - np.quantile(logs, 0.16)
    assert middle / 2 == pytest.approx(np.hypot(np.hypot(MEAN_SD, ROCKET_SD), FLIGHT_SD), rel=0.1)


def test_the_fleet_ratio_of_normal_flights_is_the_conjugate_posterior(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fieldkit.forecast.evaluation.fleet_ratio.FREEDOM", 1e9)
    logs, rocket = np.log([1.0, 1.1, 0.7]), np.array([0, 0, 1])
    mean, variance = ratio_posterior(logs, rocket, 1)
    prior = MEAN_SD**2 + ROCKET_SD**2 * np.equal.outer(rocket, rocket)
    cross = MEAN_SD**2 + ROCKET_SD**2 * (rocket == 1)
    gain = np.linalg.solve(prior + FLIGHT_SD**2 * np.eye(3), cross)
    assert mean == pytest.approx(MEAN + gain @ (logs - MEAN))
    assert variance == pytest.approx(MEAN_SD**2 + ROCKET_SD**2 - gain @ cross)


def test_the_fleet_ratio_of_a_new_rocket_follows_other_rockets_and_resists_outliers() -> None:
    others = [flown(200.0, rocket=name) for name in "ABCDEF" for _ in range(3)]
    plan = flown(None, 200.0)
    start, later = (float(np.median(fleet_ratio(earlier, plan))) for earlier in ([], others))
    assert start < later < 200
    far, near = (float(np.median(fleet_ratio([*others, flown(apogee)], plan))) for apogee in (20.0, 150.0))
    assert far > 0.6 * later
    assert near < later
