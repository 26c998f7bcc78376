"""A table of first flights of high-power rockets narrows forecasts of such flights, and of no others."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from jaxtyping import config

from fieldkit.errors import NoFlights
from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.model.hyperprior import DESIGN_DRAG, START, learned
from fieldkit.motors import catalogue
from fieldkit.services.learn_high_power import learn_from_table, read_table
from tests.services.test_plausibility import Run, run_command

__all__ = ["run_command"]
COLUMNS = ("flight_id", "rocket", "diameter_mm", "motor", "apogee_m", "predicted_one_m", "predicted_two_m", "peak_mach")
ROWS = (
    ("1", "Gibb", "76.2", "I284W (AT)", "1192.7", "1313.7", "1215.8", "0.55"),
    ("2", "Byrum", "76.2", "J570W (AT)", "1747", "1610", "1878", "0.75"),
    ("3", "Ion Drive", "101.6", "K550W", "2446", "2630", "2356", "0.79"),
)
SHARED = Path(__file__).parents[3] / "shared" / "data" / "highpower_predicted_flown.csv"


def table(folder: Path, *rows: tuple[str, ...]) -> Path:
    """A table of these flights."""
    path = folder / "designs.csv"
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    return path


def test_only_complete_high_power_flights_are_read(tmp_path: Path) -> None:
    without = [
        ("4", "No Mach", "76.2", "K550W", "2400", "2500", "2500", ""),
        ("5", "F", "66", "F24", "250", "260", "", "0.3"),
    ]
    found = read_table(table(tmp_path, *ROWS, *without), catalogue())
    assert [one.flight.rocket for one in found.forecasts] == ["Gibb", "Byrum", "Ion Drive"]
    assert found.forecasts[0].apogees == (1313.7, 1215.8)
    assert 170 < found.forecasts[0].top_speed < 190


def test_a_table_without_forecasts_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(NoFlights, match="expected at least one"):
        read_table(table(tmp_path, ("5", "F", "66", "F24", "250", "260", "", "0.3")), catalogue())


def test_a_table_narrows_forecasts_of_designs_on_high_power_motors(tmp_path: Path) -> None:
    found = learn_from_table(read_table(table(tmp_path, *ROWS), catalogue()), START)
    assert found.high_power < 1.0
    assert found.design_drag < DESIGN_DRAG
    assert [row["name"] for row in found.about["high_power_flights"]["scores"]][:2] == ["fieldkit", "as model rockets"]

    def spread(motor: str, hyperprior: object) -> float:
        plan = Flight("plan", "R", "A", motor, dry_mass=2.0 if motor == "K550W" else 0.3, diameter=0.066)
        assumed = Assumed(cds={"A": 0.5}, hyperprior=hyperprior)  # type: ignore[arg-type]
        (one,) = predict([], [(plan, catalogue().resolve(motor))], assumed, draws=400)
        return float(np.std(np.log(one.apogee)))

    assert spread("K550W", found) < 0.95 * spread("K550W", START)
    assert spread("F24", found) > 0.9 * spread("F24", START)


def test_the_command_keeps_the_rest_of_the_card(run_command: Run, tmp_path: Path) -> None:
    status, _, _ = run_command(
        "learn", "--high-power", str(table(tmp_path, *ROWS)), "--out", str(tmp_path / "card.json")
    )
    card = json.loads((tmp_path / "card.json").read_text())
    assert status == 0
    assert card["sds"] == dict(learned().sds)
    assert card["data"] == learned().about["data"]
    assert card["high_power_flights"]["flights"] == 3


def test_a_missing_table_is_a_usage_error(run_command: Run) -> None:
    status, _, err = run_command("learn")
    assert status == 2
    assert "expected at least one" in err


@pytest.mark.thorough
@pytest.mark.skipif(not SHARED.exists(), reason="the table of high-power flights is not here")
def test_the_shipped_figures_agree_with_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fieldkit.services.learn_high_power.scores", lambda *_: [])  # a fit for each rocket left out
    monkeypatch.setattr(config, "jaxtyping_disable", True)  # shapes are checked above, with fewer flights
    found = learn_from_table(read_table(SHARED, catalogue()), learned())
    assert (found.high_power, found.design_drag) == pytest.approx(
        (learned().high_power, learned().design_drag), rel=0.01
    )
    assert found.about["high_power_flights"]["sha256"] == learned().about["high_power_flights"]["sha256"]
