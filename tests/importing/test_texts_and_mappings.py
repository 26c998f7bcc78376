"""What a ledger cannot store is rejected by its row, and a home with mappings refuses what an empty one does."""

import json
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.importing.read import read
from fieldkit.paths import HOME
from tests.lived_in import move_in
from tests.samples import SAMPLES, any_motor, owner

CHECK_SHAPES = False


@pytest.fixture
def lived_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The beginning of a command line, in a home with mappings of samples and of flights, a draft and US units."""
    move_in(tmp_path, monkeypatch)
    return ["--ledger", str(tmp_path / "ledger.db")]


def test_a_binary_file_is_refused_by_name_in_a_lived_in_home(
    lived_in: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number, content in enumerate((bytes(range(256)) * 64, b"", b"\0" * 5000, b"\xff\xfe" + b"\xd8\x00" * 500)):
        file = tmp_path / f"junk{number}.csv"
        file.write_bytes(content)
        capsys.readouterr()
        for command in ("import", "inspect"):
            assert main([*lived_in, command, str(file)]) == 1
            assert f"junk{number}.csv" in capsys.readouterr().err


def test_a_lived_in_home_reads_every_format_as_an_empty_one(
    lived_in: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for format, file in {owner(sample): sample for sample in SAMPLES}.items():
        answers = []
        for home in (tmp_path / "home", tmp_path / "empty"):
            monkeypatch.setenv(HOME, str(home))
            capsys.readouterr()
            status = main([*lived_in, "inspect", str(file), "--json"])
            answers.append((status, capsys.readouterr().out))
        assert answers[0] == answers[1], format


def test_texts_that_no_ledger_can_store_cost_their_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flight = {"rocket": "A", "motor": "F24-4W", "apogee_m": 100}
    rows = [{"flight_id": id, **flight} for id in ("\ud800", "2", "x" * 100_000)]
    file = tmp_path / "flights.json"
    file.write_text(json.dumps({"flights": rows}))
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    for command in ("inspect", "import"):
        capsys.readouterr()
        assert main([*ledger, command, str(file), "--json"]) == 0
        shown = capsys.readouterr()
        assert "x" * 1000 not in shown.out + shown.err
        document = json.loads(shown.out)
        if command == "import":
            assert document["flights"] == ["2"]
            first, second = document["rejected"]
            assert "flight_id" in first["error"]
            assert first["row"] != second["row"]
        else:
            assert document["files"][0]["would_store"] == 1


HEADER, GOOD = "flight_id,rocket,motor,dry_mass_g,diameter_mm,apogee_m", "F24-4W,310,54"


def test_one_line_in_another_encoding_does_not_change_the_others() -> None:
    """As after rows were copied between tables: a name in UTF-8 stays as it is beside one in the old code page."""
    lines = [HEADER.encode(), f"1,Kön,{GOOD},200".encode(), f"2,Kön,{GOOD},201".encode("cp1252")]
    imported = read(b"\n".join([*lines, f"3,Żuk,{GOOD},202".encode()]), "t.csv", any_motor)
    assert [one.rocket for one in imported.flights] == ["Kön", "Kön", "Żuk"]
    assert not imported.rejected


@pytest.mark.parametrize("lost", ["\0", "\0" * 4])
def test_a_part_lost_to_nuls_costs_its_row(lost: str) -> None:
    rows = [f"{number},Lark,{GOOD},{200 + number}" for number in range(1, 20)]
    rows[6] = rows[6].replace("Lark", f"La{lost}k")
    imported = read("\n".join([HEADER, *rows, ""]).encode(), "t.csv", any_motor)
    assert len(imported.flights) == 18
    assert [(one.row, one.error) for one in imported.rejected] == [
        (8, "found a NUL character, as where a part was lost, expected text")
    ]
