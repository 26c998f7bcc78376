"""Messages of other rockets are saved in the ledger and updated when their flights change."""

from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.fleet import RocketFit, rocket_fit
from fieldkit.ledger import Ledger
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.model.term_names import fleet_term
from fieldkit.motors import catalogue
from fieldkit.motors.motor import Motor
from fieldkit.services import fleet
from fieldkit.services.fleet import MESSAGE_PREFIX, fleet_prior
from fieldkit.services.provenance import motor_digest
from tests.seasons import season

CHECK_SHAPES = False


@pytest.fixture
def ledger(tmp_path: Path) -> Ledger:
    ledger = Ledger.open(tmp_path / "ledger.db")
    for number in range(2):
        flights = [one for one, _ in season(np.random.default_rng(number), ("apogee",), 4)]
        ledger.add([one.with_changes(rocket=f"R{number}", flight_id=f"R{number}-{one.flight_id}") for one in flights])
    return ledger


def test_saved_messages_equal_those_computed_again(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    first = fleet_prior(ledger, catalogue(), "New")
    assert first is not None
    assert ledger.draft(f"{MESSAGE_PREFIX}R0") is not None
    monkeypatch.setattr("fieldkit.services.fleet.rocket_fit", None)  # nothing is fitted again
    with Ledger.open(ledger.name) as reopened:
        again = fleet_prior(reopened, catalogue(), "New")
    assert again is not None
    assert again.names == first.names
    np.testing.assert_allclose(again.mean, first.mean, atol=1e-5)
    np.testing.assert_allclose(again.covariance, first.covariance, atol=1e-6)


def test_flights_are_read_again_only_after_a_change(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[int] = []

    def flights() -> list[Flight]:
        read.append(1)
        return Ledger.flights(ledger)

    monkeypatch.setattr(ledger, "flights", flights)
    for rocket in ("New", "R0", "New"):
        fleet_prior(ledger, catalogue(), rocket)
    assert len(read) == 1
    with Ledger.open(ledger.name) as other:
        other.edit(other.ids(other.flights("R0"))[0], apogee=120.0)
    fleet_prior(ledger, catalogue(), "New")
    ledger.undo()
    fleet_prior(ledger, catalogue(), "New")
    assert len(read) == 3


def test_a_changed_flight_is_detected(ledger: Ledger) -> None:
    before = fleet_prior(ledger, catalogue(), "New")
    ledger.edit(ledger.ids(ledger.flights("R0"))[0], apogee=120.0)
    after = fleet_prior(ledger, catalogue(), "New")
    assert before is not None
    assert after is not None
    assert np.abs(after.mean - before.mean).max() > 1e-4


def test_a_message_belongs_to_one_version_and_one_source_of_readouts(
    ledger: Ledger, monkeypatch: pytest.MonkeyPatch
) -> None:
    def saved() -> str:
        fleet_prior(ledger, catalogue(), "New")
        return str((ledger.draft(f"{MESSAGE_PREFIX}R0") or {})["digest"])

    found = [saved()]
    ledger.edit(ledger.ids(ledger.flights("R0"))[0], source={"apogee": "baro"})
    found.append(saved())
    monkeypatch.setattr("fieldkit.services.fleet.__version__", "next")
    found.append(saved())
    assert len(set(found)) == 3


def test_a_rocket_does_not_inform_itself(ledger: Ledger) -> None:
    of_the_other = fleet_prior(ledger, catalogue(), "R0")
    ledger.edit(ledger.ids(ledger.flights("R0"))[0], apogee=120.0)
    again = fleet_prior(ledger, catalogue(), "R0")
    assert of_the_other is not None
    assert again is not None
    np.testing.assert_allclose(of_the_other.mean, again.mean, atol=1e-6)  # the second is read from the ledger


def test_the_rockets_flown_latest_inform_the_others(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise the first forecast in a ledger of thousands of rockets would take as many fits."""
    fitted: list[str] = []
    fleet_prior(ledger, catalogue(), "New", lambda name, done: fitted.append(name))
    assert fitted == ["R0", "R1"]
    assert not ledger.remarks
    monkeypatch.setattr(fleet, "MAX_ROCKETS", 1)
    ledger.add([ledger.flights("R0")[0].with_changes(flight_id="last", date_time=datetime(2030, 1, 1, 10))])
    fleet_prior(ledger, catalogue(), "New", lambda name, done: fitted.append(name))
    assert fitted[2:] == ["R0"]
    assert "of 2 rockets" in ledger.remarks[-1]


def test_a_new_flight_changes_only_the_message_of_its_rocket(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    """Although the earliest of the flights that are used is another one: every message is about the drift since the
    first flight in the ledger."""
    made: list[str] = []

    def noted(flown: FlownFlights, *given: Any) -> RocketFit:
        made.append(flown[0][0].rocket)
        return rocket_fit(flown, *given)

    monkeypatch.setattr(fleet, "MAX_ROCKETS", 2)
    monkeypatch.setattr(fleet, "rocket_fit", noted)
    first, year = ledger.flights("R0")[0], {"Old": 2019, "Mid": 2024, "Late": 2025}
    ledger.add([first.with_changes(rocket=name, date_time=datetime(year[name], 1, 1, 10)) for name in year])
    fleet_prior(ledger, catalogue(), "New")
    ledger.add([first.with_changes(rocket="Old", flight_id="last", date_time=datetime(2030, 1, 1, 10))])
    fleet_prior(ledger, catalogue(), "New")
    assert sorted(made[:2]) == ["Late", "Mid"]
    assert made[2:] == ["Old"]


@pytest.mark.thorough
def test_the_prior_of_another_rocket_is_hardly_wider_than_with_every_rocket(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At most by the factor sqrt(1 + 1/n) for n rockets, and its mean within what those leave unknown of the fleet."""
    used = 10
    monkeypatch.setattr(fleet, "MAX_ROCKETS", used)
    rng, known = np.random.default_rng(4), {"drag": "drag.rocket", "mass": "mass.rocket", "apogee": "apogee.rocket"}
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        for number in range(3 * used):
            flights = [one for one, _ in season(rng, ("apogee", "top_speed"), 4)]
            ledger.add([one.with_changes(rocket=f"R{number}") for one in flights])
        some = fleet_prior(ledger, catalogue(), "New")
        monkeypatch.setattr(fleet, "MAX_ROCKETS", 1000)
        with Ledger.open(ledger.name) as again:
            every = fleet_prior(again, catalogue(), "New")
    assert some is not None
    assert every is not None
    assert some.names == every.names
    for quantity, own in known.items():
        row, within = some.names.index(fleet_term(quantity)), learned().sds[own] ** 2
        few, all_of_them = (prior.covariance[row, row] for prior in (some, every))
        assert np.sqrt((few + within) / (all_of_them + within)) < np.sqrt(1 + 1 / used)
        assert abs(some.mean[row] - every.mean[row]) < 3 * np.sqrt(few - all_of_them)


def test_an_empty_ledger_has_no_fleet(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "empty.db") as empty:
        assert fleet_prior(empty, catalogue(), "New") is None


def test_each_thrust_curve_of_a_rocket_is_digested_once(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    digested: list[Motor] = []

    def noted(motor: Motor) -> str:
        digested.append(motor)
        return motor_digest(motor)

    monkeypatch.setattr("fieldkit.services.fleet.motor_digest", noted)
    fleet_prior(ledger, catalogue(), "New")
    assert len(digested) == 6  # four flights of each of two rockets on three motors
