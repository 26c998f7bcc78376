"""Histories simulated by the model with an effect: a strong effect is found."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import observe
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.selection.candidates import Place, effect_candidates, effect_terms
from fieldkit.selection.diagnose import Diagnosis, diagnose
from fieldkit.selection.extended_model import rocket_model

READ_TO = {
    "apogee": 0.01,
    "top_speed": 0.01,
    "burn_time": 0.02,
    "peak_accel": 0.03,
    "coast_to_apogee": 0.01,
    "apogee_to_eject": 0.0,
}
"""Scatter of readouts, as a fraction."""


@dataclass(frozen=True)
class Strong:
    """An effect with a strength (of its fitted value) at a place, in flights with these changes, and its name."""

    place: Place
    strength: float
    named: str
    flights: Mapping[str, Any]


SLOW_AND_FAST = {"motor": ("F24-4W", "F39-6T", "G80-7T"), "dry_mass": (0.3, 0.2, 0.2)}
STRONG = {
    "an altimeter that corrects": Strong(
        Place("altimeter_temperature"), 1.0, "altimeter_temperature", {"temperature": (268.0, 308.0, 288.0, 318.0)}
    ),
    "a lot drilled short": Strong(
        Place("early_ejection_seconds"), 3.0, "early_ejection", {"delay": (3.5, 6.0, 4.5, 5.0)}
    ),
    "fins that flutter": Strong(Place("flutter"), 1.2, "flutter", SLOW_AND_FAST),
    "tip-off": Strong(
        Place("tip_off"), 400.0, "tip_off", {"dry_mass": (0.25, 0.7, 0.45, 0.9), "rail_length": (0.8, 1.8)}
    ),
    "a site of unknown elevation": Strong(
        Place("blank_elevation", "high"),
        2500.0,
        "air_density",
        {"site": ("low", "high"), "site_elevation": (50.0, None)},
    ),
    "heavier recovery gear": Strong(Place("heavier_recovery", "", "9"), 0.15, "mass_offset", {}),
    "a motor lot that burns longer": Strong(Place("slow_lot", "", "9"), 0.35, "thrust_curve", {}),
}


def history(strong: Strong, count: int = 16) -> tuple[Diagnosis, list[Flight]]:
    """Flights from the model of the search with an effect, and their diagnosis."""
    rng = np.random.default_rng(7)
    flights = []
    for row in range(count):
        columns = {name: values[row % len(values)] for name, values in strong.flights.items()}
        plain: dict[str, Any] = {"dry_mass": 0.322, "diameter": 0.066, "motor": ("F24-7W", "F39-6T")[row % 2]}
        when = datetime(2026, 5, 1, 10) + timedelta(days=7 * (row // 4), minutes=30 * (row % 4))
        flights.append(Flight(str(row + 1), rocket="Found", date_time=when, **{**plain, **columns}))
    found = [catalogue().resolve(flight.motor) for flight in flights]
    model = rocket_model(history_of(flights, found))
    terms = effect_terms(strong.place, model)
    wide = model.with_terms(*terms)
    usual = [strong.strength if term in terms else term.mean for term in wide.terms]
    readings = shown(wide, np.array([usual]), {})
    noisy = []
    for row, flight in enumerate(flights):
        readouts = {
            name: float(readings[name][0, row] * (1 + sd * rng.standard_normal())) for name, sd in READ_TO.items()
        }
        noisy.append(flight.with_changes(**{name: value for name, value in readouts.items() if np.isfinite(value)}))
    known = history_of(noisy, found, used_in_fit=[True] * count)
    return diagnose(rocket_model(known), observe(known)), noisy


@pytest.mark.slow
@pytest.mark.parametrize("name", STRONG)
def test_a_strong_effect_is_found(name: str) -> None:
    strong = STRONG[name]
    diagnosis, _ = history(strong)
    assert strong.named in (diagnosis.effect, *diagnosis.also), diagnosis.posterior.inclusion
    assert diagnosis.posterior.inclusion[strong.named] > 0.3
    # how long a motor burns hardly changes the height
    assert diagnosis.after.mae < diagnosis.before.mae or strong.named == "thrust_curve"


def test_effects_that_begin_later_are_never_tried_from_the_first_flight_on() -> None:
    flights = [Flight(str(row), dry_mass=0.3, diameter=0.06, motor="F24-7W", apogee=300.0) for row in range(8)]
    model = rocket_model(history_of(flights, [catalogue().resolve(flight.motor) for flight in flights]))
    places = [one.place for one in effect_candidates(model, np.ones(8, bool))]
    for name in ("heavier_recovery", "slow_lot"):
        assert {place.since for place in places if place.effect == name} == {"2", "3", "4", "5", "6"}


def test_a_missing_elevation_is_tried_at_the_sites_without_one() -> None:
    sites = (("low", 50.0), ("high", None))
    flights = [
        Flight(str(row), dry_mass=0.3, diameter=0.06, motor="F24-7W", apogee=300.0, site=site, site_elevation=elevation)
        for row, (site, elevation) in enumerate(sites * 3)
    ]
    model = rocket_model(history_of(flights, [catalogue().resolve(flight.motor) for flight in flights]))
    places = [one.place for one in effect_candidates(model, np.ones(6, bool))]
    assert [place.where for place in places if place.effect == "blank_elevation"] == ["high"]
    assert {place.where for place in places if place.effect == "site_elevation"} == {"low", "high"}


def test_common_departures_are_in_the_plain_model_but_not_in_addition_to_a_learned_one() -> None:
    flights = [Flight("1", dry_mass=0.3, diameter=0.06, motor="F24-7W")]
    found = [catalogue().resolve("F24-7W")]
    assert TermName("base_drag", "usual") in rocket_model(history_of(flights, found)).names
    assert TermName("base_drag", "usual") not in rocket_model(history_of(flights, found), hyperprior=learned()).names
