"""Forecasts forward in time depend on earlier flights of all rockets and on nothing else."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.forward_in_time import Forecast, forward
from fieldkit.model.hyperprior import learned
from fieldkit.motors import Found, catalogue

CHECK_SHAPES = False

START = datetime(2026, 1, 1)
APOGEES = (("Astra", 210.0), ("Luna", 205.0), ("Astra", 220.0), ("Luna", 200.0), ("Astra", 215.0), ("Nova", 190.0))


def fleet() -> list[tuple[Flight, Found]]:
    """Six flights of three similar rockets."""
    motor = catalogue().resolve("F24-4W")
    plan = Flight(motor="F24-4W", dry_mass=0.32, diameter=0.066, rail_length=1.2)
    return [
        (
            plan.with_changes(
                flight_id=str(number), rocket=rocket, apogee=apogee, date_time=START + timedelta(days=number)
            ),
            motor,
        )
        for number, (rocket, apogee) in enumerate(APOGEES)
    ]


@pytest.fixture(scope="module")
def found() -> list[Forecast]:
    return forward(fleet())


def test_every_clean_flight_is_forecast_including_the_first_of_a_rocket(found: list[Forecast]) -> None:
    assert [(row.rocket, row.earlier) for row in found] == [
        ("Astra", 0),
        ("Luna", 0),
        ("Astra", 1),
        ("Luna", 1),
        ("Astra", 2),
        ("Nova", 0),
    ]
    assert [row.flown for row in found] == [apogee for _, apogee in APOGEES]
    assert found[0].rivals.keys() == {"uncalibrated", "fleet_ratio"}
    assert found[4].rivals["flight_before"].tolist() == [220.0]


def test_a_later_flight_changes_no_earlier_forecast(found: list[Forecast]) -> None:
    flown = fleet()
    flown[3] = (flown[3][0].with_changes(apogee=90.0), flown[3][1])
    changed = forward(flown)
    for own, other in zip(found[:4], changed[:4], strict=True):
        np.testing.assert_array_equal(own.draws, other.draws)
        assert own.rivals.keys() == other.rivals.keys()
        for name, draws in own.rivals.items():
            np.testing.assert_array_equal(draws, other.rivals[name])
    assert changed[4].p50 != found[4].p50
    assert changed[5].p50 != found[5].p50


def test_a_fleet_informs_a_first_flight(found: list[Forecast]) -> None:
    (alone,) = forward(fleet()[5:])
    fleets = found[5]
    assert np.log(fleets.p95 / fleets.p05) < np.log(alone.p95 / alone.p05)
    low, high = (
        forward([(f.with_changes(apogee=height * (f.apogee or 0)), m) for f, m in fleet()[:5]] + fleet()[5:])
        for height in (0.8, 1.1)
    )
    assert low[5].p50 < high[5].p50


def test_a_rocket_is_forecast_the_same_alone_and_among_all(found: list[Forecast]) -> None:
    own = forward(fleet(), "Luna")
    assert [row.flight_id for row in own] == ["1", "3"]
    for row in own:
        (same,) = [one for one in found if one.flight_id == row.flight_id]
        np.testing.assert_array_equal(row.draws, same.draws)
        np.testing.assert_array_equal(row.rivals["fleet_ratio"], same.rivals["fleet_ratio"])


def test_a_flight_with_an_anomaly_is_neither_forecast_nor_used(found: list[Forecast]) -> None:
    flown = fleet()
    flown[2] = (flown[2][0].with_changes(tags=("off_axis",)), flown[2][1])
    rows = forward(flown)
    assert [row.flight_id for row in rows] == ["0", "1", "3", "4", "5"]
    assert rows[3].earlier == 1
    assert rows[2].p50 != found[3].p50


def test_another_hyperprior_gives_other_forecasts(found: list[Forecast]) -> None:
    narrow = learned().with_sds(drag__rocket=0.01, apogee__flight=0.01, drag__fleet=0.01)
    rows = forward(fleet()[:1], hyperprior=narrow)
    assert np.log(rows[0].p95 / rows[0].p05) < 0.9 * np.log(found[0].p95 / found[0].p05)


def test_progress_is_reported_and_it_can_be_stopped() -> None:
    steps: list[tuple[str, float]] = []

    def on_progress(text: str, done: float) -> None:
        steps.append((text, done))
        if len(steps) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        forward(fleet(), on_progress=on_progress)
    assert steps == [("Astra 0", 0.0), ("Luna 1", pytest.approx(1 / 6)), ("Astra 2", pytest.approx(1 / 3))]
    assert forward([]) == []
