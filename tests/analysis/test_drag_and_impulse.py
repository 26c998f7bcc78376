"""Drag from a coast and impulse from a burn, on flights that are known exactly."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from fieldkit.analysis import Recorded, columns, measure
from fieldkit.flight import Flight
from fieldkit.importing.read import read
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.ledger import Ledger
from fieldkit.ledger.rows import same
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.sources import has_log
from fieldkit.motors import Motor, catalogue
from fieldkit.physics.atmosphere import pad_air
from fieldkit.physics.flight import fly as simulate
from fieldkit.physics.history import field_setup, history_of
from fieldkit.physics.logged import burn_impulse, coast_drag
from fieldkit.presentation.export import csv_table, document
from tests.analysis.recordings import FAST, LARGE, SMALL, TINY, Logger, Rocket, Truth, changed, fly, log

LOGGERS = {
    "plain": Logger(),
    "feet": Logger(resolution=0.3048),
    "fast": Logger(rate=100, noise=1.0),
    "10 Hz": Logger(rate=10, noise=0.3),
    "thin": Logger(rate=5),
    "quiet": Logger(rate=50, noise=0.1),
    "spikes": Logger(spikes=0.03),
    "shock": Logger(shock=60),
    "pressure": Logger(channel="pressure", wait=60),
    "drifted zero": Logger(drift=12),
    "jitter": Logger(jitter=0.3),
    "fused": Logger(accelerometer=50, spikes=0.01, shock=30),
}
"""Recorders with different faults."""
ROCKETS = {"tiny": TINY, "small": SMALL, "large": LARGE, "fast": FAST}
TEN: dict[str, object] = {"coast_drag": None, "burn_impulse": None, "sd": {}, "source": {}}
"""Changes that turn a logged flight into one with ten typed readouts."""


LAW = Flight("1", "Law", motor="F24-4W", apogee=281.3, coast_drag=0.0031, burn_impulse=118.2).with_changes(
    sd={"coast_drag": 6e-5, "burn_impulse": 2.3}, source={"coast_drag": "baro", "burn_impulse": "accel"}
)


def drag_of(rocket: Rocket, mass: float | None = None) -> float:
    """The true drag of a coast in standard air. [1/m]"""
    air = pad_air(*(np.array(x) for x in (rocket.elevation, np.nan, np.nan, np.nan)))
    return float(0.5 * air.density * rocket.area / (mass or rocket.mass))


def impulse_of(truth: Truth, rocket: Rocket) -> float:
    """Thrust over mass, integrated over the burn. [m/s]"""
    burning = truth.time <= truth.burnout
    air = pad_air(*(np.array(x) for x in (rocket.elevation, np.nan, np.nan, np.nan)))
    drag = drag_of(rocket) * air.density_ratio(truth.height) * truth.speed**2
    return float(np.trapezoid((truth.felt + drag)[burning], truth.time[burning]))


@cache
def recorded(rocket: str, logger: str) -> tuple[Recorded, Rocket, Truth]:
    """A random flight of a kind of rocket, and what is measured in its log."""
    rng = np.random.default_rng([list(ROCKETS).index(rocket), list(LOGGERS).index(logger)])
    flown = changed(ROCKETS[rocket], rng)
    truth = fly(flown)
    return measure(log(truth, LOGGERS[logger], rng)), flown, truth


@pytest.mark.slow
def test_drag_and_impulse_are_within_two_standard_deviations() -> None:
    drag, impulse, relative = [], [], []
    for rocket in ROCKETS:
        for logger in LOGGERS:
            measured, flown, truth = recorded(rocket, logger)
            if found := measured.figures.get("coast_drag"):
                drag.append((found.value - drag_of(flown)) / found.sd)
                relative.append(found.sd / found.value)
            if (found := measured.figures.get("burn_impulse")) and rocket != "fast":
                impulse.append((found.value - impulse_of(truth, flown)) / found.sd)
    assert len(drag) >= 45
    assert len(impulse) >= 25
    assert np.mean(np.abs(drag) < 2) >= 0.95
    assert np.mean(np.abs(impulse) < 2) >= 0.93
    assert np.median(relative) < 0.03


def test_twice_the_mass_has_half_the_drag_in_a_log() -> None:
    light, heavy = (
        measure(log(fly(rocket), Logger(noise=0.2), np.random.default_rng(1))).figures["coast_drag"]
        for rocket in (LARGE, replace(LARGE, mass=2 * LARGE.mass, thrust=2 * LARGE.thrust))
    )
    assert heavy.value == pytest.approx(light.value / 2, rel=0.03)


def test_a_coast_without_drag_has_no_measured_drag() -> None:
    measured = measure(log(fly(replace(SMALL, area=1e-9)), Logger(), np.random.default_rng(1)))
    assert "apogee" in measured.figures
    assert "coast_drag" not in measured.figures


@pytest.mark.parametrize(
    "logger", [Logger(rate=1), Logger(early=0.35), Logger(late=0.5)], ids=["1 Hz", "early", "late"]
)
def test_a_coast_that_is_too_coarse_or_too_short_gives_no_drag(logger: Logger) -> None:
    measured = measure(log(fly(TINY), logger, np.random.default_rng(1)))
    assert not {"coast_drag", "burn_impulse"} & set(measured.figures)


def test_a_burn_that_ends_near_the_speed_of_sound_has_no_impulse() -> None:
    measured = recorded("fast", "plain")[0].figures
    assert "coast_drag" in measured
    assert "burn_impulse" not in measured


@pytest.mark.parametrize("gain", [0.94, 1.06])
def test_warm_and_cold_days_do_not_bias_the_drag(gain: float) -> None:
    """An altimeter reads low in warm air and high in cold air."""
    (series,) = log(fly(SMALL), Logger(noise=0.2), np.random.default_rng(3))
    assert series.altitude is not None
    found = measure((replace(series, altitude=gain * series.altitude),)).figures["coast_drag"]
    assert abs(found.value - drag_of(SMALL)) < 2 * found.sd
    assert found.sd < 0.06 * found.value


F24 = "F24-4W"
AREA = np.pi / 4 * 0.066**2


def motor() -> Motor:
    return catalogue().resolve(F24).motor


def flown_on(cd: float, thrust_factor: float, logger: Logger, seed: int) -> Flight:
    """A flight on a motor of the catalog, with what is measured in its log."""
    rocket = Rocket(mass=0.322, area=cd * AREA, delay=8.0, elevation=0.0)
    measured = measure(log(fly(rocket, motor(), thrust_factor), logger, np.random.default_rng(seed)))
    fields, _ = columns(measured, {})
    plan = Flight("1", "Astra", "A", F24, dry_mass=0.322, diameter=0.066, delay=8.0)
    return plan.with_changes(**fields)


def fitted(flight: Flight) -> Fit:
    model = base_model(history_of([flight], [catalogue().resolve(F24)]), learned())
    return fit_robustly(model, observe(history_of([flight], model.found, used_in_fit=[True]), learned()))


def per_mass(result: Fit, *bends: str) -> tuple[float, float]:
    """Posterior mean and sd of the sum of the terms on one quantity, minus those on the second."""
    signs = [1.0 if t.bends == bends[0] else -1.0 if t.bends in bends[1:] else 0.0 for t in result.model.terms]
    along = np.array(signs) * [term.weight[0] for term in result.model.terms]
    mean, variance = result.mean @ along, np.einsum("i,sij,j->s", along, result.covariance, along)
    middle = result.weights @ mean
    return float(middle), float(np.sqrt(result.weights @ (variance + (mean - middle) ** 2)))


@pytest.mark.thorough
@pytest.mark.parametrize(("logger", "ratio"), [(Logger(), 0.55), (Logger(accelerometer=50), 1 / 3)])
def test_one_logged_flight_distinguishes_drag_from_thrust(logger: Logger, ratio: float) -> None:
    """Static ports limit what a barometer shows; an accelerometer shows drag per mass three times as well as ten
    readouts."""
    for cd, thrust_factor in ((0.45, 1.0), (0.6, 0.9), (0.8, 1.06)):
        logged = flown_on(cd, thrust_factor, logger, 4)
        before, after = fitted(logged.with_changes(**TEN)), fitted(logged)
        assert per_mass(after, "drag", "mass")[1] < ratio * per_mass(before, "drag", "mass")[1]
        assert per_mass(after, "drag")[1] < 0.6 * per_mass(before, "drag")[1]
        for bends, truth in (("drag", cd), ("thrust", thrust_factor)):
            mean, sd = per_mass(after, bends)
            assert abs(mean - np.log(truth)) < 2 * sd


def test_the_models_expectation_agrees_with_a_simulated_log() -> None:
    rocket = Rocket(mass=0.322, area=0.6 * AREA, delay=8.0, elevation=0.0)
    logged = flown_on(0.6, 1.0, Logger(noise=0.1, accelerometer=50), 2)
    setup = field_setup([logged], [catalogue().resolve(F24)], np.array([0.6 * AREA]))
    expected = {"coast_drag": coast_drag(setup, simulate(setup)), "burn_impulse": burn_impulse(setup)}
    coasting = 0.322 + motor().casing_mass
    assert expected["coast_drag"][0] == pytest.approx(drag_of(rocket, coasting), rel=1e-4)
    for name, values in expected.items():
        assert values[0] == pytest.approx(logged.number(name), abs=2 * logged.sd[name])


def test_drag_halves_at_twice_the_mass_and_is_zero_in_a_vacuum() -> None:
    flight = Flight("1", "Astra", "A", F24, dry_mass=0.3, diameter=0.066, delay=8.0)
    setup = field_setup([flight], [catalogue().resolve(F24)], np.array([0.002]))
    flown = simulate(setup)
    twice = setup.with_changes(dry_mass=2 * setup.dry_mass + motor().casing_mass)
    assert coast_drag(twice, flown) == pytest.approx(coast_drag(setup, flown) / 2)
    assert coast_drag(setup.with_changes(drag_area=np.zeros(1)), flown) == 0
    assert burn_impulse(setup.with_changes(thrust_factor=np.array([1.1]))) == pytest.approx(1.1 * burn_impulse(setup))
    assert burn_impulse(setup.with_changes(burn_stretch=np.array([1.2]))) == pytest.approx(burn_impulse(setup))
    mass = 0.3 + motor().casing_mass + 0.5 * motor().propellant_mass
    assert burn_impulse(setup)[0] == pytest.approx(motor().total_impulse / mass, rel=0.01)


def test_a_force_during_the_coast_is_included_in_its_drag() -> None:
    flight = Flight("1", "Astra", "A", F24, dry_mass=0.3, diameter=0.066, delay=8.0)
    setup = field_setup([flight], [catalogue().resolve(F24)], np.array([0.002]))
    flown = simulate(setup)
    forced = setup.with_changes(forces=((lambda state, strength: -strength * state.drag, np.array([0.3])),))
    assert coast_drag(forced, flown) == pytest.approx(1.3 * coast_drag(setup, flown))


def test_flights_without_a_log_have_no_terms_for_it() -> None:
    typed = Flight("1", "Astra", "A", F24, dry_mass=0.3, diameter=0.066, apogee=250.0)
    model = base_model(history_of([typed], [catalogue().resolve(F24)]), learned())
    assert not has_log(typed)
    assert not {"coast_drag", "burn_impulse"} & set(model.names)
    values = np.array([[term.mean for term in model.terms]])
    assert np.isnan(shown(model, values, {})["coast_drag"]).all()


def test_measurements_from_a_log_survive_the_ledger_and_exports(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([LAW])
        assert ledger.flight("1") == LAW
    texts = {"csv": csv_table([LAW]), "json": json.dumps({"flights": [document(LAW)]})}
    assert "coast_drag_pkm,coast_drag_sd_pkm,coast_drag_source,burn_impulse_mps" in texts["csv"]
    for ending, text in texts.items():
        (flight,) = read(text.encode(), f"flights.{ending}", lambda name: "").flights
        assert same(flight, LAW)
    assert "coast_drag" not in csv_table([LAW.with_changes(coast_drag=None)])


def test_a_plan_made_from_a_logged_flight_omits_the_measurements_of_its_log() -> None:
    """Otherwise the flight would be forecast from itself."""
    bare = LAW.with_changes(**dict.fromkeys(LAW.readouts()))
    assert not has_log(bare)
    assert (bare.sd, bare.source) == ({}, {})
