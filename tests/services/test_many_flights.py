"""A rocket with very many flights is fitted with its latest ones, which every command says in a line."""

from datetime import datetime, timedelta
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.cli.session import known_motors
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.services.forecasts import flown
from fieldkit.services.plausible_flights import MAX_FITTED_FLIGHTS, exclusions, followed, simulable

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
    assert line.startswith(f"Astra: its {MAX_FITTED_FLIGHTS} latest flights are used")
    assert line.endswith(f"excluded: 7 of {MAX_FITTED_FLIGHTS + 7}")
    assert not exclusions(kept, motors)


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
        assert ("latest flights are used" in " ".join((shown.out + shown.err).split())) is (begin == 0)
        answers.append([line for line in shown.out.splitlines() if "latest" not in line and "excluded" not in line])
    assert answers[0] == answers[1]
