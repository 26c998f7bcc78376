"""The demo and the command infer, used by a newcomer and by a script."""

import re
from functools import partial
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services import demo
from fieldkit.services.inferred import FlightInference, infer_by_paper
from tests.commands import Run

CHECK_SHAPES = False

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "fieldkit" / "data" / "reference_flights.csv"


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.delenv("FIELDKIT_LEDGER", raising=False)


@pytest.mark.thorough
def test_the_demo_shows_readouts_to_next_apogee_and_does_not_touch_the_flyers_ledger(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.db"
    monkeypatch.setenv("FIELDKIT_LEDGER", str(mine))
    monkeypatch.setattr("sys.argv", ["fieldkit"])
    assert main(["demo"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert not mine.exists()
    assert not list((tmp_path / "home").glob("*"))
    assert max(map(len, printed.out.splitlines())) <= 80
    assert "12 flights of Astra imported. 8 are normal" in printed.out
    steps = re.split(r"^\d\. ", printed.out, flags=re.MULTILINE)
    assert len(steps) == 5
    _, _, inferred, predicted, loop = steps
    assert len(re.findall(r"^ +\d+ [AB]  .* m .*±.*±", inferred, flags=re.MULTILINE)) == 12
    forecasts = re.findall(r"^(\S+) +([AB]) +(\d+) m .*?(\d+) to (\d+) m", predicted, flags=re.MULTILINE)
    assert {one[:2] for one in forecasts} == {(m, c) for m in ("E35-5W", "F24-4W", "F39") for c in "AB"}
    assert all(int(low) < int(middle) < int(high) for *_, middle, low, high in forecasts)
    assert re.search(r"misses\s+by \d+\.\d m on average", loop)
    after = loop.partition("Next, enter a flight of yours")[2]
    typed = re.findall(r"^  fieldkit ?(.*)$", after, flags=re.MULTILINE)
    predict = "predict --motor F24-4W --wind 8mph"
    save, use = "import --example", "predict --rocket Astra --motor F24-7W"
    assert typed == ["add", predict, save, use, "", "docs start"]
    assert "checkout" not in printed.out


def test_the_demo_refuses_a_ledger_that_is_in_use(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "demo.db"
    with Ledger.open(path) as ledger:
        ledger.add([Flight(flight_id="1", rocket="Mine", apogee=100.0)])
    assert main(["--ledger", str(path), "demo"]) == 1
    assert "found 1 flight, expected an empty or new ledger" in capsys.readouterr().err
    with Ledger.open(path) as ledger:
        assert [flight.rocket for flight in ledger.flights()] == ["Mine"]


def test_an_interrupted_demo_leaves_no_incomplete_ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def cut_short(*_: object, **__: object) -> None:
        raise UnknownMotor("the power went")

    monkeypatch.setattr(demo, "look", cut_short)
    assert main(["--ledger", str(tmp_path / "demo.db"), "demo"]) == 1
    assert list(tmp_path.glob("*demo*")) == []


@pytest.mark.slow
def test_the_demo_fills_an_empty_ledger(tmp_path: Path) -> None:
    path = tmp_path / "demo.db"
    assert main(["--ledger", str(path), "demo"]) == 0
    with Ledger.open(path) as ledger:
        assert len(ledger.flights()) == 12
        assert len(ledger.predictions("Astra")) == 6


@pytest.fixture
def infer_command(run: Run) -> Run:
    """The command infer, on the reference flights."""
    run("import", TABLE)
    return partial(run, "infer")


@pytest.mark.parametrize("model", ["field", "paper"])
def test_infer_gives_drag_and_thrust_for_every_flight(model: str, infer_command: Run) -> None:
    flights = infer_command("--model", model, "--json").document["flights"]
    assert [one["flight_id"] for one in flights] == [str(number) for number in range(1, 13)]
    for one in flights:
        assert set(one) >= {"flight_id", "cd", "cd_sd", "alpha", "alpha_sd"}
        assert one["model"] == model
        assert one["provisional"] == (model == "field")
        assert 0.1 < one["cd"] < 2
        assert 0.4 < one["alpha"] < 1.6
        assert one["cd_sd"] > 0
        assert one["alpha_sd"] > 0


def test_infer_uses_the_named_flights(infer_command: Run) -> None:
    lines = infer_command("3", "Astra/9").out.splitlines()
    assert [line.split()[0] for line in lines[:3]] == ["flight", "3", "9"]
    assert lines[3].startswith("Provisional, from each flight alone"), "the fit has the final figures"
    assert "33" in infer_command("33", status=1).err


def test_a_flight_that_cannot_be_inferred_is_named_and_left_out(infer_command: Run, run: Run) -> None:
    run("edit", "2", "apogee=")
    printed = infer_command("1", "2", "--json")
    assert [one["flight_id"] for one in printed.document["flights"]] == ["1"]
    assert printed.err == "left out: flight 2: no readout, expected at least the apogee\n"
    assert "no flight could be used for inference" in infer_command("2", status=1).err


def test_infer_on_an_empty_ledger_says_what_to_do(run: Run) -> None:
    assert "found no flights" in run("infer", status=1).err


def test_a_warning_is_printed_once_for_all_its_flights(infer_command: Run) -> None:
    notes = infer_command("2", "3").err.splitlines()
    assert len(notes) == len({note.partition(": ")[2].partition(": ")[2] for note in notes})
    assert any(note.startswith("note: flights 2, 3: apogee alone cannot separate drag from thrust") for note in notes)


ROCKET = Flight(rocket="Kestrel", motor="F24-4W", dry_mass=0.322, diameter=0.066)
OTHERS = {
    "no dry mass": (ROCKET.with_changes(apogee=250.0, dry_mass=None), "no dry mass"),
    "no readout": (ROCKET, "no readout"),
    "unknown motor": (ROCKET.with_changes(apogee=250.0, motor="ZZ99"), "no motor 'ZZ99'"),
}


@pytest.mark.parametrize("case", OTHERS)
def test_missing_values_are_reported_and_the_other_flights_inferred(case: str, tmp_path: Path) -> None:
    flight, why = OTHERS[case]
    good = ROCKET.with_changes(flight_id="7", apogee=250.0)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        found = FlightInference(ledger, catalogue()).infer([flight.with_changes(flight_id="5"), good])
    assert [one.flight for one in found.inferred] == [good]
    (line,) = found.left_out
    assert line.startswith("flight 5: ")
    assert why in line


def test_inference_is_the_same_alone_and_among_others() -> None:
    flights = [ROCKET.with_changes(flight_id=str(n), apogee=height) for n, height in enumerate((240.0, 260.0, 280.0))]
    together = infer_by_paper(flights, catalogue()).inferred
    for flight, one in zip(flights, together, strict=True):
        (alone,) = infer_by_paper([flight], catalogue()).inferred
        assert (alone.cd, alone.alpha) == pytest.approx((one.cd, one.alpha), rel=1e-6)
    assert together[0].cd > together[1].cd > together[2].cd
