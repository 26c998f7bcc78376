"""Text from files and from a ledger is shown and not obeyed; nothing reaches outside, neither folders nor networks."""

import ast
import csv
import io
import json
import os
import sys
import unicodedata
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import create_engine, text

from fieldkit import files
from fieldkit.cli.main import app, main
from fieldkit.errors import DamagedLog, LedgerError
from fieldkit.export import csv_table
from fieldkit.flight import Flight
from fieldkit.intake import read_file
from fieldkit.ledger import Ledger
from fieldkit.motors import own
from fieldkit.safe_text import as_cell, from_cell

ROOT = Path(__file__).parents[1]
HOSTILE = {
    "escape": "\x1b[2J\x1b]0;owned\x07",
    "markup": "[bold red]x[/] [/nope] [@click=app.quit]q[/]",
    "reversed": "a\u202etxt.exe\u2066",
    "formula": "=HYPERLINK(1)",
    "sql": "'; DROP TABLE flights; --",
    "long": "x" * 100_000,
}
"""The longest is below what a cell of a table may hold."""


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_text_reaches_no_terminal_and_comes_back_whole(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hostile = HOSTILE[what]
    flight = Flight(
        flight_id="1", rocket=hostile[:40], site=hostile, notes=hostile, apogee=100.0, extra={"Lot": hostile}
    )
    with Ledger.open() as ledger:
        ledger.add([flight], source=f"{hostile[:40]}.csv")
        ledger.tag("1", hostile[:40].replace(";", ""))  # which parts tags in a table
    for command in (
        ["flights"],
        ["show", "1"],
        ["history"],
        ["flights", "--rocket", hostile[:40]],
        ["show", hostile[:40]],
    ):
        main(command)
        out, err = capsys.readouterr()
        controls = {c for c in out + err if unicodedata.category(c) in ("Cc", "Cf", "Cs") and c != "\n"}
        assert not controls, command
    assert main(["flights", "--json"]) == 0
    (told,) = json.loads(capsys.readouterr().out)["flights"]
    assert told["site"] == hostile
    assert main(["export", str(tmp_path / "out.csv")]) == 0
    with Ledger.open(tmp_path / "other.db") as other, Ledger.open() as ledger:
        assert main(["--ledger", str(tmp_path / "other.db"), "import", str(tmp_path / "out.csv")]) == 0
        (copied,), (kept,) = other.flights(), ledger.flights()
    assert (copied.rocket, copied.tags) == (kept.rocket, kept.tags)


def test_a_nul_is_refused_in_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "t.csv"
    table.write_text("flight_id,rocket,apogee_m,log\n1,Astra,100,\n2,Astra,101,a\0b.csv\n", encoding="utf-8")
    assert main(["import", str(table)]) in (0, 1)
    assert "\0" not in "".join(capsys.readouterr())


@given(st.text(max_size=12))
@settings(max_examples=200)
def test_a_cell_is_never_a_formula_and_comes_back(word: str) -> None:
    assert not as_cell(word).startswith(("=", "+", "-", "@", "\t", "\r", "＝", "＋", "－", "＠"))
    assert from_cell(as_cell(word)) == word


@pytest.mark.parametrize("start", ["=1+1", "+1", "-1", "@SUM(1)", "'=1", "＝1", "\t=1"])
def test_no_exported_text_is_a_formula_and_numbers_stay_numbers(start: str) -> None:
    flight = Flight(
        flight_id=start, rocket=start, notes=start, tags=(start,), apogee_to_eject=-0.4, extra={start: start}
    )
    header, row = csv.reader(io.StringIO(csv_table([flight])))
    cells = dict(zip(header, row, strict=True))
    assert cells["apogee_to_eject_s"] == "-0.4"
    for name, cell in cells.items():
        assert not name.startswith(("=", "+", "-", "@", "\t", "＝"))
        assert cell == "-0.4" or not cell.startswith(("=", "+", "-", "@", "\t", "＝"))


OUTSIDE = [
    "../secret.csv",
    "/etc/passwd",
    "link.csv",
    "folder/../../secret.csv",
    r"C:\secret.csv",
    r"\\host\share\log.csv",
]


@pytest.mark.parametrize("where", OUTSIDE)
def test_a_log_outside_the_folder_of_its_table_is_not_read(
    where: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "table"
    folder.mkdir()
    (tmp_path / "secret.csv").write_text("secret")
    (folder / "link.csv").symlink_to(tmp_path / "secret.csv")
    (folder / "t.csv").write_text(f"flight_id,rocket,apogee_m,log\n1,Astra,100,{where}\n")
    assert main(["import", str(folder / "t.csv")]) == 0
    assert "expected a path inside the folder of the table" in capsys.readouterr().err
    with Ledger.open() as ledger:
        assert ledger.flights() == []


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes in folders")
def test_a_log_that_is_a_pipe_is_not_waited_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "t.csv").write_text("flight_id,rocket,apogee_m,log\n1,Astra,100,pipe.csv\n")
    assert main(["import", str(tmp_path / "t.csv")]) == 0
    assert "cannot be read (not a plain file), taken without it" in capsys.readouterr().err


def test_a_file_without_end_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "LARGEST", 1 << 20)
    (tmp_path / "long.csv").write_bytes(bytes((1 << 20) + 1))
    for endless in (tmp_path / "long.csv", Path("/dev/zero")):
        if endless.exists():
            with pytest.raises(DamagedLog, match=r"cannot be read \(more than 1 MiB\)"):
                read_file(endless)


BOMBS = {
    "entities": b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><a>&b;</a>',
    "outside": b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a SYSTEM "file:///etc/passwd">]><a>&a;</a>',
    "nested": b"<a>" * 20_000,
    "long": b'<engine-database><engine code="' + b"x" * 1_000_000 + b'"/></engine-database>',
}


@pytest.mark.parametrize("bomb", BOMBS)
def test_an_xml_bomb_is_a_damaged_file(bomb: str) -> None:
    with pytest.raises(DamagedLog) as error:
        own.read(BOMBS[bomb], "bomb.rse")
    assert len(str(error.value)) < 400


def test_a_motor_file_without_end_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own, "LARGEST", 100)
    (tmp_path / "big.rse").write_bytes(b"<" * 101)
    motors, errors = own.own_motors(tmp_path)
    assert not motors
    assert "found more than 100 bytes" in str(errors[0])


def test_a_log_that_unpacks_to_more_than_its_row_says_is_not_unpacked(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([Flight(flight_id="1", rocket="Astra")], log=bytes(10_000_000))
    engine = create_engine(f"sqlite:///{file}")
    with engine.begin() as connection:
        connection.execute(text("UPDATE logs SET size = 1000"))
    engine.dispose()
    with Ledger.open(file) as ledger, pytest.raises(LedgerError, match="another size than the 1000 bytes"):
        ledger.log("1")


def test_nothing_is_ever_unpickled() -> None:
    shelves = [ROOT / name for name in ("fieldkit", "parsers", "models", "bench", "tools")]
    for file in [file for shelf in shelves for file in shelf.rglob("*.py")]:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = {one.name for one in node.names} if isinstance(node, ast.Import) else set()
            names |= {str(node.module)} if isinstance(node, ast.ImportFrom) else set()
            assert not names & {"pickle", "shelve", "marshal", "dill", "joblib", "cloudpickle"}, file
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("torch.load", "np.load", "numpy.load"):
                pytest.fail(f"{file}: {ast.unparse(node)}")


# --- No network

FLIGHTS = str(ROOT / "fieldkit" / "data" / "reference_flights.csv")
COMMANDS: dict[str, list[str]] = {
    "import": [FLIGHTS],
    "export": [],
    "capture": ["--list"],
    "add": ["--rocket", "Astra", "--apogee", "100m"],
    "flights": [],
    "show": ["1"],
    "edit": ["1", "notes=x"],
    "tag": ["1", "mine"],
    "untag": ["1", "mine"],
    "remove": ["1"],
    "undo": [],
    "sites": ["North field", "--elevation", "212m"],
    "remeasure": [],
    "predictions": [],
    "report": ["2"],
    "ork": ["missing.ork"],
    "redo": [],
    "history": [],
    "backups": [],
    "docs": ["start"],
    "motors": ["F24"],
    "model": [],
    "simulate": ["--motor", "F24-4W", "--dry-mass", "322g", "--diameter", "66mm", "--cd", "0.6"],
    "compare": [str(ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2")] * 2,
    "infer": ["2"],
    "predict": ["--motor", "F24-4W", "--config", "A"],
    "tui": [],
}
"""Every command, as far as it takes moments, in an order in which each finds what it needs."""
LONG = {"demo", "loop", "score", "study", "paper", "train", "delay", "ballast", "contest"}
ASKED_FOR = {"serve"}
"""Commands that are there to listen."""
REACHING = {"socket.connect", "socket.bind", "socket.getaddrinfo", "socket.sendto", "socket.sendmsg", "urllib.Request"}
_forbidden: list[str] | None = None


def _watch(event: str, arguments: tuple[object, ...]) -> None:
    if _forbidden is not None and event in REACHING:
        _forbidden.append(f"{event} {arguments!r}")
        raise OSError("no network here")


@pytest.fixture
def sockets() -> Iterator[list[str]]:
    """What was tried with a socket; each try fails."""
    global _forbidden
    sys.addaudithook(_watch)  # it stays, and does nothing after this test
    _forbidden = []
    yield _forbidden
    _forbidden = None


def test_no_command_reaches_for_a_network(sockets: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    listed = set(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
    assert listed - LONG - ASKED_FOR <= set(COMMANDS), "a new command is to be tried here too"
    for command, arguments in COMMANDS.items():
        main([command, *arguments])
        assert not sockets, command
    capsys.readouterr()


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments", [["demo"], ["loop"], ["score"], ["paper"], ["study", "rockets"], ["delay", "--motor", "F24-4W"]]
)
def test_no_long_command_reaches_for_a_network(arguments: list[str], sockets: list[str]) -> None:
    main(["import", FLIGHTS])
    main(arguments)
    assert not sockets
