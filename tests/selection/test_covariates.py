"""Patterns follow conditions known before lift-off, whatever their name, and never outcomes of the flight."""

from collections.abc import Sequence
from datetime import datetime, timedelta

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.selection.covariates import known_before
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.patterns import known_patterns

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
MOTORS = "F24-4W", "F39-6T", "E15-4W", "F39-6T"


def season(count: int = 16, **columns: Sequence[str]) -> list[Flight]:
    """Flights on three motors, with simulated readouts, a scatter of 2%, and the flyer's columns."""
    plans = [
        Flight(
            f"F{row}",
            rocket="Kite",
            config="A",
            dry_mass=0.32 + 0.02 * (row % 5),
            diameter=0.066,
            motor=MOTORS[row % 4],
            delay=4.0 + 2 * (row % 2),
            date_time=datetime(2026, 3, 1, 10) + timedelta(days=7 * row),
            extra={name: texts[row] for name, texts in columns.items()},
        )
        for row in range(count)
    ]
    model = base_model(history_of(plans, [catalogue().resolve(plan.motor) for plan in plans]))
    start = np.array([[term.mean for term in model.terms]])
    readings = shown(model, start, {})
    noise = np.exp(0.02 * np.random.default_rng(7).normal(size=count))
    return [
        plan.with_changes(
            apogee=float(readings["apogee"][0, row] * noise[row]), top_speed=float(readings["top_speed"][0, row])
        )
        for row, plan in enumerate(plans)
    ]


def texts(numbers: Sequence[float]) -> list[str]:
    return [f"{number:.3f}" for number in numbers]


def test_columns_that_name_an_outcome_are_not_conditions() -> None:
    flights = season(6)
    for name in (
        "published_apogee_m",
        "stated_top_speed_mps",
        "Peak acceleration (g)",
        "cd",
        "published_alpha",
        "duration",
    ):
        assert not known_before(name, flights), name
    for name in (
        "wind_speed_gust",
        "paint",
        "rail_condition",
        "igniter_batch",
        "humidity_hangar",
        "top_coat",
        "burn_ban",
    ):
        assert known_before(name, flights), name


def test_columns_that_repeat_a_readout_are_outcomes_whatever_their_name() -> None:
    flights = season()
    apogees = np.array([flight.apogee for flight in flights], float)
    rng = np.random.default_rng(3)
    forecast = 1.2 * apogees * np.exp(0.04 * rng.normal(size=16))
    columns = {
        "openrocket_m": texts(forecast),
        "the_other_program": texts(forecast / 0.3048),
        "sim_ft": texts(0.8 * apogees / 0.3048),
        "fin_spread_mm": texts(60 + 3 * rng.normal(size=16)),
        "hangar_k": texts(285 + 10 * rng.normal(size=16)),
    }
    flights = [
        flight.with_changes(extra={name: column[row] for name, column in columns.items()})
        for row, flight in enumerate(flights)
    ]
    assert [name for name in columns if known_before(name, flights)] == ["fin_spread_mm", "hangar_k"]
    named = {str(pattern) for kind in known_patterns(flights) for pattern in kind}
    assert "fin_spread_mm" in named
    assert not any("openrocket" in where for where in named)


def test_a_pattern_in_a_users_own_column_is_found() -> None:
    """Drag that rises with a condition that no effect uses."""
    spread = np.random.default_rng(5).normal(size=16)
    flights = season(fin_spread_mm=texts(60 + 3 * spread), sim_m=["0"] * 16)
    low = [
        flight.with_changes(
            apogee=float((flight.apogee or 0.0) * np.exp(-0.06 * own)),
            top_speed=float((flight.top_speed or 0.0) * np.exp(-0.02 * own)),
            extra={**flight.extra, "sim_m": f"{(flight.apogee or 0.0) * np.exp(-0.06 * own) * 1.1:.1f}"},
        )
        for flight, own in zip(flights, spread, strict=True)
    ]
    model = base_model(history_of(low, [catalogue().resolve(flight.motor) for flight in low]))
    found = diagnose(model, observe(history_of(low, model.found, used_in_fit=[True] * len(low))))
    assert found.effect == "unexplained"
    assert any("fin_spread_mm" in str(place) for place in found.pattern)
    assert not any("sim_m" in str(place) for one in found.posterior.hypotheses for place in one.places)
