"""The source of a readout determines its bias: a device's, or none."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.model.hyperprior import FROM_DEVICES, START, Hyperprior, learned
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.sources import IN_SAMPLES, measured_by
from fieldkit.model.term_names import TermName
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import flown_and_planned, history_of

CHECK_SHAPES = False
PLAN = Flight("next", "Law", "A", "F24-4W", dry_mass=0.322, diameter=0.066)
SHOWN = ("apogee", *FROM_DEVICES)


def flown(source: str, count: int = 2) -> list[tuple[Flight, Found]]:
    """Simulated flights of a rocket with high drag, measured exactly by a source."""
    motor = catalogue().resolve(PLAN.motor)
    model = base_model(history_of([PLAN] * count, [motor] * count), START)
    truth = np.array([[term.mean for term in model.terms]])
    truth[0, model.names.index(TermName("drag"))] += 0.3
    readings = shown(model, truth, {})
    flights = []
    for i in range(count):
        values = {name: float(readings[name][0, i]) for name in SHOWN}
        sd = {"apogee": 1.0, "top_speed": 0.5, "burn_time": 0.05, "peak_accel": 3.0, "coast_to_apogee": 0.1}
        sources = dict.fromkeys(values, source) if source else {}
        flights.append((PLAN.with_changes(flight_id=f"{i}", **values, sd=sd, source=sources), motor))
    return flights


def test_a_flight_without_the_readout_has_the_source_of_the_previous_one() -> None:
    shows = [
        PLAN,
        PLAN.with_changes(top_speed=50.0, source={"top_speed": "typed"}),
        PLAN,
        PLAN.with_changes(top_speed=50.0, source={"top_speed": "baro"}),
        PLAN,
    ]
    speeds, burns = ([flight.readout(name) for flight in shows] for name in ("top_speed", "burn_time"))
    assert measured_by(IN_SAMPLES, speeds).tolist() == [0, 0, 0, 1, 1]
    assert measured_by(IN_SAMPLES, burns).tolist() == [0] * 5


def test_readouts_from_samples_share_no_term_with_those_of_a_device() -> None:
    typed, logged = flown("typed", 1), flown("accel", 1)
    model = base_model(flown_and_planned([*typed, *logged]), learned())
    weight = {term.name: term.weight.tolist() for term in model.terms}
    for readout in FROM_DEVICES:
        assert weight[TermName(readout, "fleet")] == weight[TermName(readout)] == [1.0, 0.0]
        assert weight[TermName(readout, "logged")] == [0.0, 1.0]
    only_logs = base_model(flown_and_planned(logged), learned())
    assert not [name for name in only_logs.names if name.quantity in FROM_DEVICES and name.level != "logged"]


@pytest.fixture
def slow_device() -> Hyperprior:
    """A hyperprior with devices that show speed 20% low with little variation."""
    means = {**learned().means, "top_speed": -0.2}
    return replace(learned(), means=means).with_sds(top_speed__fleet=0.01, top_speed__rocket=0.01)


def test_drag_and_thrust_follow_from_logged_readouts_despite_biased_devices(slow_device: Hyperprior) -> None:
    """Typed figures with the same values mean another flight, because that device would show 20% less speed."""
    motor = catalogue().resolve(PLAN.motor)

    def miss(source: str) -> float:
        (forecast,) = predict(flown(source, 4), [(PLAN, motor)], Assumed(hyperprior=slow_device), draws=400)
        off = np.log([forecast.cd, forecast.alpha]).T - [START.mean("drag") + 0.3, 0.0]
        return float(np.abs(off.mean(axis=0) / off.std(axis=0)).max())

    assert miss("accel") < 1.0 < miss("typed")


def test_apogees_by_satellites_are_true_heights_on_a_hot_day() -> None:
    motor = catalogue().resolve(PLAN.motor)
    flights = [
        PLAN.with_changes(temperature=313.15, apogee=250.0, eject_altitude=240.0, source=dict.fromkeys(names, source))
        for source in ("gps", "baro", "")
        for names in [("apogee", "eject_altitude")]
    ]
    model = base_model(history_of(flights, [motor] * 3), START)
    readings = shown(model, np.array([[term.mean for term in model.terms]]), {})
    assert readings["apogee"][0, 0] == pytest.approx(readings["true"][0, 0])
    for name in ("apogee", "eject_altitude"):
        by_satellites, by_pressure, unknown = readings[name][0].tolist()
        assert by_pressure == unknown
        assert by_pressure / by_satellites == pytest.approx(288.15 / 313.15)


def test_speeds_by_a_barometer_are_those_of_its_heights_on_a_hot_day() -> None:
    motor = catalogue().resolve(PLAN.motor)
    flights = [
        PLAN.with_changes(temperature=313.15, top_speed=60.0, source={"top_speed": source})
        for source in ("gps", "baro", "baro+accel", "accel")
    ]
    model = base_model(history_of(flights, [motor] * 4), START)
    speeds = shown(model, np.array([[term.mean for term in model.terms]]), {})["top_speed"][0]
    assert speeds[1] / speeds[0] == pytest.approx(288.15 / 313.15)
    assert speeds[2] / speeds[3] == pytest.approx(288.15 / 313.15)
