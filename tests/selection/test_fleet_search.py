"""What several rockets share is found over the fleet, and only if it is there."""

import random
from dataclasses import replace
from datetime import date, datetime, timedelta

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.fleet import joint_evidence
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.motors import catalogue
from fieldkit.selection.fleet_groups import SharedDifference
from fieldkit.selection.fleet_search import (
    FleetRocket,
    fleet_differences,
    fleet_of,
    log_bayes,
    log_shifts,
    rocket_message,
    search_fleet,
)

ROCKETS = ("Ash", "Birch", "Cedar")


def season(rocket: str, motor: str, apogee: float, month: int, seed: int, **more: object) -> list[FlownFlight]:
    rng = random.Random(seed)
    first = datetime(2025, month, 1, 10)
    plain = Flight(rocket=rocket, config="A", motor=motor, dry_mass=0.322, diameter=0.066).with_changes(**more)
    found = catalogue().resolve(motor)
    return [
        (
            replace(
                plain,
                flight_id=f"{rocket} {month}.{number}",
                date_time=first + timedelta(days=number),
                apogee=apogee * float(np.exp(rng.gauss(0, 0.03))),
            ),
            found,
        )
        for number in range(3)
    ]


def fleet(later: float) -> list[FleetRocket]:
    """Three rockets on two motor types; since September the F24 flights have `later` times their usual apogee."""
    flown = {
        name: [
            *season(name, "F24-4W", 250 - 6 * number, 5, seed=number),
            *season(name, "E35-5W", 170 - 4 * number, 4, seed=10 + number),
            *season(name, "F24-4W", later * (250 - 6 * number), 9, seed=20 + number),
            *season(name, "E35-5W", 170 - 4 * number, 9, seed=30 + number),
        ]
        for number, name in enumerate(ROCKETS)
    }
    return fleet_of(flown, learned())


@pytest.fixture(scope="module")
def weaker() -> list[FleetRocket]:
    return fleet(0.78)


def test_a_motor_type_that_gets_weaker_for_every_rocket_is_found_with_its_day(weaker: list[FleetRocket]) -> None:
    found = search_fleet(weaker)[0]
    assert (found.candidate.level, found.candidate.effect) == ("lot", "motor_thrust")
    assert "F24" in found.candidate.of
    assert found.candidate.since == date(2025, 9, 1)
    assert found.probability > 0.9
    mean, sd = found.strengths["thrust"]
    assert mean < -3 * sd


def test_rockets_that_fly_as_usual_share_nothing() -> None:
    assert all(found.probability < 0.5 for found in search_fleet(fleet(1.0)))


def test_a_candidate_that_concerns_no_flight_with_an_apogee_does_not_change_the_evidence(
    weaker: list[FleetRocket],
) -> None:
    nobody = {one.name: np.zeros(len(one.model.flights), bool) for one in weaker}
    plain = {one.name: rocket_message(one.plain, ()) for one in weaker}
    assert log_bayes(
        SharedDifference(("motor_thrust",), "lot", "F24", None, nobody), weaker, plain, ()
    ) == pytest.approx(0)


def test_the_evidence_of_a_candidate_with_a_vanishing_prior_is_that_of_the_plain_fleet(
    weaker: list[FleetRocket],
) -> None:
    one = next(one for one in fleet_differences(weaker) if one.since == date(2025, 9, 1) and "F24" in one.of)
    fits = [rocket.fit(one.terms(rocket.name, 1e-6)) for rocket in weaker]
    with_terms = [rocket_message(fit, [one]) for rocket, fit in zip(weaker, fits, strict=True)]
    plain = [rocket_message(rocket.plain, ()) for rocket in weaker]
    assert joint_evidence(with_terms) == pytest.approx(joint_evidence(plain), abs=1e-3)


def test_a_group_needs_two_flights_with_the_difference_and_two_without(weaker: list[FleetRocket]) -> None:
    for one in fleet_differences(weaker):
        inside = sum(int(one.members[rocket.name].sum()) for rocket in weaker)
        assert inside >= 2
        assert sum(len(rocket.model.flights) for rocket in weaker) - inside >= 2


def test_the_altimeter_of_a_flight_is_a_group() -> None:
    flown = {
        "Ash": [
            *season("Ash", "F24-4W", 250, 5, seed=1, extra={"Altimeter": "A2 no. 7"}),
            *season("Ash", "F24-4W", 250, 6, seed=2, extra={"Altimeter": "pnut"}),
        ]
    }
    devices = {one.of for one in fleet_differences(fleet_of(flown, learned())) if one.level == "device"}
    assert devices == {"A2 no. 7", "pnut"}


def test_a_forecast_rests_on_earlier_flights_alone(weaker: list[FleetRocket]) -> None:
    one = next(one for one in fleet_differences(weaker) if one.since == date(2025, 9, 1) and "F24" in one.of)
    flights = [flight for rocket in weaker for flight in rocket.model.flights]
    dated = sorted(flights, key=lambda flight: flight.date_time or datetime.min)
    order = {(flight.rocket, flight.flight_id): number for number, flight in enumerate(dated)}
    shifts = log_shifts(one, weaker, order, latest=8)
    last = max(shifts, key=lambda key: order[key])
    moved = [
        replace(rocket, data=replace(rocket.data, values=_raised(rocket, last))) if rocket.name == last[0] else rocket
        for rocket in weaker
    ]
    assert log_shifts(one, moved, order, latest=8) == pytest.approx(shifts)
    assert shifts[last] < -0.1


def _raised(rocket: FleetRocket, which: tuple[str, str]) -> np.ndarray:
    values = rocket.data.values.copy()
    values[[flight.flight_id for flight in rocket.model.flights].index(which[1]), 0] += 1.0
    return values
