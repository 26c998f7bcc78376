"""A rocket with very many flights is fitted with the most informative ones, which every command says in a line."""

import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.cli.session import known_motors
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.services import plausible_flights
from fieldkit.services.forecasts import flown
from fieldkit.services.plausible_flights import MAX_FITTED_FLIGHTS, MAX_LATEST_FLIGHTS, exclusions, followed, simulable

START = datetime(2020, 1, 1, 10)


def flights(count: int, rocket: str = "Astra") -> list[Flight]:
    return [
        Flight(
            flight_id=str(number),
            rocket=rocket,
            config="A",
            motor="F24-4W",
            dry_mass=0.322,
            diameter=0.066,
            apogee=245.0 + number % 10,
            date_time=START + timedelta(days=number),
        )
        for number in range(count)
    ]


def test_the_latest_flights_of_each_rocket_are_fitted() -> None:
    many = sorted([*flights(MAX_FITTED_FLIGHTS + 7), *flights(3, "Comet")], key=lambda flight: str(flight.date_time))
    motors = known_motors()
    kept = [flight for flight, _ in followed(many, motors)]
    assert [flight.flight_id for flight in kept if flight.rocket == "Comet"] == ["0", "1", "2"]
    assert [int(flight.flight_id) for flight in kept if flight.rocket == "Astra"] == [*range(7, MAX_FITTED_FLIGHTS + 7)]
    assert len(simulable(many, motors)) == len(many)
    (line,) = exclusions(many, motors)
    assert line.startswith(f"Astra: fits use {MAX_FITTED_FLIGHTS} of its {MAX_FITTED_FLIGHTS + 7} flights")
    assert not exclusions(kept, motors)


def test_the_older_flights_of_motors_and_configurations_with_fewest_flights_are_fitted() -> None:
    many, older = flights(100), MAX_FITTED_FLIGHTS - MAX_LATEST_FLIGHTS
    changes = [{"motor": "E35-5W"}, {"config": "B"}, {"motor": "F39-6T"}]
    for change, rows in zip(changes, (range(20), range(20, 22), range(40, 60)), strict=True):
        for row in rows:
            many[row] = many[row].with_changes(**change)
    many[59] = many[59].with_changes(tags=("weak_launch",))
    kept = [int(flight.flight_id) for flight, _ in followed(many, known_motors())]
    assert kept == [*range(16, 22), *range(55, 59), *range(100 - MAX_LATEST_FLIGHTS, 100)]
    assert len(kept) == MAX_LATEST_FLIGHTS + older


@pytest.mark.parametrize("command", [["predict", "--motor", "F24-4W"], ["loop", "--quick", "--dry-run"]], ids=str)
def test_the_work_for_a_rocket_does_not_grow_with_its_oldest_flights(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = []
    for count, begin in ((2 * MAX_FITTED_FLIGHTS, 0), (2 * MAX_FITTED_FLIGHTS, MAX_FITTED_FLIGHTS)):
        file = tmp_path / f"{begin}.db"
        with Ledger.open(file) as ledger:
            ledger.add(flights(count)[begin:])
            assert len(flown(ledger, known_motors(), "Astra")) == MAX_FITTED_FLIGHTS
        assert main(["--ledger", str(file), *command]) == 0
        shown = capsys.readouterr()
        assert ("fits use" in " ".join((shown.out + shown.err).split())) is (begin == 0)
        answers.append(
            [
                line
                for line in shown.out.splitlines()
                if "fits use" not in line and "latest" not in line and "fewest" not in line
            ]
        )
    assert answers[0] == answers[1]


@pytest.mark.thorough
def test_three_times_as_many_flights_hardly_narrow_a_forecast(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the oldest flights of a rocket could add: the spread of its flights remains, however many there were."""
    rng = np.random.default_rng(2000)
    many = [flight.with_changes(apogee=250.0 * float(np.exp(rng.normal(0, 0.04)))) for flight in flights(150)]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(many)
    widths = []
    for factor in (1, 3):
        monkeypatch.setattr(plausible_flights, "MAX_FITTED_FLIGHTS", factor * MAX_FITTED_FLIGHTS)
        monkeypatch.setattr(plausible_flights, "MAX_LATEST_FLIGHTS", factor * MAX_LATEST_FLIGHTS)
        assert main(["--ledger", str(tmp_path / "ledger.db"), "predict", "--motor", "F24-4W", "--json"]) == 0
        apogee = json.loads(capsys.readouterr().out)["predictions"][0]["apogee_m"]
        widths.append(apogee["p95"] - apogee["p05"])
    assert widths[0] == pytest.approx(widths[1], rel=0.1)
