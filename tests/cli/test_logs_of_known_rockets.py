"""A log names no rocket: what the flyer says of it with `import` and `edit`, and what the ledger knows."""

from pathlib import Path

import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services.forecasts import predict_plans
from tests.commands import Run

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
PNUT = Path(__file__).parents[2] / "sample_logs" / "perfectflite__drogue_and_main.pf2"
LARK = ("--rocket", "Lark", "--motor", "F24-4W")


@pytest.fixture
def flown(run: Run) -> Run:
    """A ledger with one typed flight of Lark."""
    run("add", *LARK, "--config", "A", "--dry-mass", "323g", "--diameter", "66mm", "--apogee", "160m")
    return run


def newest(tmp_path: Path) -> tuple[str, str, str, float | None, float | None]:
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        flight = ledger.flight("last")
    return flight.rocket, flight.config, flight.motor, flight.dry_mass, flight.diameter


def test_a_log_of_a_known_rocket_gets_its_build_and_the_next_forecast(flown: Run, tmp_path: Path) -> None:
    _, out, error = flown("import", PNUT, *LARK)
    assert newest(tmp_path) == ("Lark", "A", "F24-4W", 0.323, 0.066)
    assert "filled in dry mass 323 g, diameter 66 mm; edit to change" in error
    assert "configuration A, the only one of Lark; edit to change" in error
    assert "Next on F24-4W: " in " ".join(out.split())
    again = flown("import", PNUT, *LARK)
    assert "Imported 0, 1 duplicate" in again.out
    assert "filled in" not in again.err


def test_logs_with_the_same_build_share_a_note(flown: Run, tmp_path: Path) -> None:
    folder = tmp_path / "logs"
    folder.mkdir()
    for log in sorted(PNUT.parent.glob("perfectflite__*.pf2"))[:3]:
        (folder / log.name).write_bytes(log.read_bytes())
    error = flown("import", folder, *LARK, "--config", "A").err
    assert len([line for line in error.splitlines() if "filled in" in line]) == 1
    assert error.count("note: flights flight-") == 1


def test_figures_of_the_flyer_replace_those_of_the_build(flown: Run, tmp_path: Path) -> None:
    error = flown("import", PNUT, *LARK, "--config", "A", "--dry-mass", "12oz").err
    assert newest(tmp_path)[3] == pytest.approx(0.3402, abs=1e-4)
    assert "filled in diameter 66 mm" in error


def test_rows_of_a_table_are_not_filled_in(flown: Run, tmp_path: Path) -> None:
    table = tmp_path / "season.csv"
    table.write_text("rocket,motor,date,apogee_m\nLark,F24-4W,2026-05-01,170\n", encoding="utf-8")
    error = flown("import", table).err
    assert newest(tmp_path)[3] is None
    assert "excluded from every fit: no dry mass; edit to add it" in error


def test_a_log_without_a_rocket_says_how_to_complete_it(run: Run, tmp_path: Path) -> None:
    _, out, error = run("import", PNUT)
    assert "is excluded from every fit: no rocket, no motor, no dry mass; edit to add them" in error
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        (id,) = ledger.ids([ledger.flight("last")])
    assert f"fieldkit edit {id} rocket=NAME motor=F24-4W dry_mass=320g" in " ".join(out.split())


def test_the_plan_that_waits_is_suggested_for_a_log(flown: Run, tmp_path: Path) -> None:
    plan = Flight().with_changes(rocket="Lark", config="A", motor="E35-5W")
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        predict_plans(ledger, catalogue(), [plan], save="plan")
    out = " ".join(flown("import", PNUT).out.split())
    assert "rocket=Lark motor=E35-5W dry_mass=323g" in out


def test_a_log_given_to_a_known_rocket_later_gets_its_build(flown: Run, tmp_path: Path) -> None:
    flown("import", PNUT)
    error = flown("edit", "last", "rocket=Lark", "motor=F24-4W").err
    assert "filled in dry mass 323 g, diameter 66 mm" in error
    assert newest(tmp_path) == ("Lark", "A", "F24-4W", 0.323, 0.066)
    flown("undo")
    assert newest(tmp_path) == ("", "", "", None, None)


def test_last_is_the_flight_entered_most_recently(flown: Run) -> None:
    flown("add", *LARK, "--apogee", "150m")
    assert "Flight 2 has the tag weak_launch" in flown("tag", "last", "weak_launch").out
    assert "tag 2 weak_launch" in flown("undo").out
    flown("remove", "last")
    assert "150.0 m" not in flown("flights").out


def test_a_flight_named_last_keeps_its_name(flown: Run) -> None:
    flown("add", *LARK, "--flight-id", "last", "--apogee", "150m")
    flown("add", *LARK, "--apogee", "155m")
    assert "Flight     last" in flown("show", "last").out


def test_a_mistyped_rocket_and_motor_are_reported(flown: Run) -> None:
    assert "no rocket 'Larc'; did you mean Lark?" in flown("import", PNUT, "--rocket", "Larc").err.splitlines()[0]
    assert "no motor 'F2-4'" in flown("import", PNUT, "--motor", "F2-4", status=1).err


def test_the_beginning_of_an_id_names_the_only_flight_that_has_it(flown: Run) -> None:
    flown("import", PNUT, *LARK)
    assert flown("show", "flight-").out.startswith("Flight                flight-")
    for name in ("1000", "1001"):
        flown("add", *LARK, "--flight-id", name, "--apogee", "155m")
    assert "100 is ambiguous" not in flown("show", "100", status=1).err
    assert "no flight '100'" in flown("show", "100", status=1).err
    flown("edit", "1000", "flight_id=alpha-1")
    flown("edit", "1001", "flight_id=alpha-2")
    assert "alpha is ambiguous: alpha-1 or alpha-2" in flown("remove", "alpha", status=1).err
