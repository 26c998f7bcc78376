"""Whole numbers in texts of unknown origin: `int` fails for superscripts and for thousands of digits."""

import ast
from pathlib import Path

import pytest

from bench.faults.session import SAMPLES
from fieldkit.capture.protocols.altimulti import sentences
from fieldkit.cli.main import main
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.openrocket.archive import root_of
from fieldkit.openrocket.stored import reference_diameter
from fieldkit.safe_text import whole_number

CHECK_SHAPES = False
pytestmark = pytest.mark.fast
ROOT = Path(__file__).parents[1]
BOUNDED = {
    "planning/contest.py",
    "tui/serve.py",
    "importing/tables/column_choice.py",
}
"""Modules in which the number of digits is limited otherwise: by a file name, a caught error, a checked length."""
LONG = "9" * 5000


@pytest.mark.parametrize(
    ("text", "number"),
    [("0", 0), ("042", 42), ("", None), ("\u00b2", None), ("\u0663", None), ("-1", None), (LONG, None)],
)
def test_a_whole_number_is_a_few_ascii_digits(text: str, number: int | None) -> None:
    assert whole_number(text) == number


def test_the_next_id_follows_the_ids_that_are_numbers(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        for id in (LONG, "7", "\u00b2", "9" * 18, str(10**18)):
            ledger.add([Flight(flight_id=id, rocket="Astra", apogee=100.0)])
        assert ledger.next_flight_id("Astra") == str(10**18 + 1)
        assert ledger.next_flight_id("Comet") == "1"


def test_a_flight_with_any_part_number_of_its_log_is_compared_or_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "log.txt").write_bytes((ROOT / "sample_logs" / "bdureau__eight_bit_board_that_wraps.txt").read_bytes())
    table = tmp_path / "flights.csv"
    table.write_text(f"flight_id,rocket,motor,apogee_m,log,log_part\n1,Astra,F24-4W,100,log.txt,{LONG}\n")
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, "import", str(table)]) == 0
    assert main([*ledger, "compare", "1"]) in (0, 1)
    assert "Traceback" not in capsys.readouterr().err


def test_a_count_of_flights_that_is_not_a_number_is_ignored() -> None:
    body = b"nbrOfFlight,\xb2,"
    (one,) = sentences(b"$" + body + str(sum(body) % 256).encode() + b";")
    assert one.sound
    assert whole_number(one.fields[0]) is None


@pytest.mark.parametrize("number", ["\u00b2", LONG])
def test_a_stage_with_any_number_is_read(number: str) -> None:
    ours = f'<motorconfiguration configid="a"><stage number="{number}" active="false"/></motorconfiguration>'
    rocket = root_of((SAMPLES / "skylark.ork").read_bytes().replace(b"</name>", b"</name>" + ours.encode(), 1), "a.ork")
    assert reference_diameter(next(rocket.iter("rocket")), "a") > 0


def test_no_module_assumes_that_int_reads_whatever_isdigit_accepts() -> None:
    for file in sorted((ROOT / "fieldkit").rglob("*.py")):
        if file.relative_to(ROOT / "fieldkit").as_posix() in BOUNDED:
            continue
        text = file.read_text(encoding="utf-8")
        if "isdigit" not in text and "isdecimal" not in text:
            continue
        for function in ast.walk(ast.parse(text)):
            if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
                calls = [one.func for one in ast.walk(function) if isinstance(one, ast.Call)]
                asks = any(isinstance(one, ast.Attribute) and one.attr in ("isdigit", "isdecimal") for one in calls)
                reads = any(isinstance(one, ast.Name) and one.id == "int" for one in calls)
                assert not (asks and reads), f"{file}:{function.lineno}"
