"""Text from files and from a ledger is shown and never interpreted; nothing reaches other folders or the network."""

import ast
import csv
import io
import json
import os
import sys
import unicodedata
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import create_engine, text

from fieldkit import files
from fieldkit.cli.main import app, main
from fieldkit.errors import DamagedLog, LedgerError
from fieldkit.flight import Flight
from fieldkit.flight.storable import MAX_NAME
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger import Ledger
from fieldkit.motors import own
from fieldkit.presentation.export import csv_table
from fieldkit.safe_text import as_cell, from_cell
from fieldkit.services.imports import read_file
from fieldkit.tui.imports.import_look import beginning
from tests.effort import examples
from tests.openrocket.test_design import design

ROOT = Path(__file__).parents[1]
HOSTILE = {
    "escape": "\x1b[2J\x1b]0;owned\x07",
    "markup": "[bold red]x[/] [/nope] [@click=app.quit]q[/]",
    "reversed": "a\u202etxt.exe\u2066",
    "formula": "=HYPERLINK(1)",
    "sql": "'; DROP TABLE flights; --",
    "long": "x" * 100_000,
}
"""The longest is below the limit of a table's cell."""


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_text_is_escaped_in_the_terminal_and_exported_unchanged(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hostile = HOSTILE[what]
    flight = Flight(
        "1", rocket=hostile[:40], site=hostile[:MAX_NAME], notes=hostile, apogee=100.0, extra={"Lot": hostile}
    )
    with Ledger.open() as ledger:
        ledger.add([IncomingFlight(flight, source=f"{hostile[:40]}.csv")])
        ledger.tag("1", hostile[:40].replace(";", ""))  # which separates tags in a table
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
    (listed,) = json.loads(capsys.readouterr().out)["flights"]
    assert (listed["site"], listed["notes"]) == (hostile[:MAX_NAME], hostile)
    assert main(["export", str(tmp_path / "out.csv")]) == 0
    with Ledger.open(tmp_path / "other.db") as other, Ledger.open() as ledger:
        assert main(["--ledger", str(tmp_path / "other.db"), "import", str(tmp_path / "out.csv")]) == 0
        (copied,), (kept,) = other.flights(), ledger.flights()
    assert (copied.rocket, copied.site, copied.tags) == (kept.rocket, kept.site, kept.tags)


def test_a_nul_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "t.csv"
    table.write_text("flight_id,rocket,apogee_m,log\n1,Astra,100,\n2,Astra,101,a\0b.csv\n", encoding="utf-8")
    assert main(["import", str(table)]) in (0, 1)
    assert "\0" not in "".join(capsys.readouterr())


@given(st.text(max_size=12))
@examples(200)
def test_an_exported_cell_is_never_a_formula_and_imports_unchanged(word: str) -> None:
    assert not as_cell(word).startswith(("=", "+", "-", "@", "\t", "\r", "＝", "＋", "－", "＠"))
    assert from_cell(as_cell(word)) == word


@pytest.mark.parametrize("start", ["=1+1", "+1", "-1", "@SUM(1)", "'=1", "＝1", "\t=1"])
def test_no_exported_text_is_a_formula_and_numbers_remain_numbers(start: str) -> None:
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
    "linked/secret.csv",
    "folder/../../secret.csv",
    r"..\secret.csv",
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
    (folder / "linked").symlink_to(tmp_path, target_is_directory=True)
    (folder / "t.csv").write_text(f"flight_id,rocket,apogee_m,log\n1,Astra,100,{where}\n")
    assert main(["import", str(folder / "t.csv")]) == 0
    assert "expected a path inside the folder of the table" in capsys.readouterr().err
    with Ledger.open() as ledger:
        assert ledger.flights() == []


OPENERS = {"open", "read_bytes", "read_text"}
OF_FIELDKIT = {
    "cli/demo.py": "what the demonstration has just written",
    "cli/docs.py": "the manual",
    "__init__.py": "the declaration of the project",
    "importing/tables/flight_headings.py": "shipped headings",
    "importing/tables/headings.py": "shipped headings",
    "importing/tables/sheet_xml.py": "a part of an archive that is in memory",
    "importing/tables/spreadsheet.py": "a part of an archive that is in memory",
    "inference/network/ensemble.py": "weights, whose size and checksum are known",
    "model/hyperprior.py": "the shipped hyperprior",
    "motors/catalogue.py": "the shipped catalog",
    "openrocket/archive.py": "a part of an archive that is in memory",
    "parallel.py": "results that it saved",
    "planning/contest.py": "shipped rules",
    "plugins.py": "shipped cards",
    "presentation/report/html.py": "shipped templates",
    "reference/flights.py": "the shipped flights",
}
"""The modules that open files themselves, and which: none of unknown origin."""


def _opens(module: Path) -> bool:
    calls = [node for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))) if isinstance(node, ast.Call)]
    owners = {"os", "Ledger", "webbrowser"}
    return any(
        (isinstance(call.func, ast.Name) and call.func.id == "open")
        or (
            isinstance(call.func, ast.Attribute)
            and call.func.attr in OPENERS
            and not (isinstance(call.func.value, ast.Name) and call.func.value.id in owners)
        )
        for call in calls
    )


def test_files_of_unknown_origin_are_opened_in_one_module() -> None:
    """It refuses pipes, which block, and devices, which never end."""
    package = ROOT / "fieldkit"
    modules = [*package.rglob("*.py"), *(ROOT / "parsers").glob("*.py")]
    opening = {
        (one.relative_to(package) if one.is_relative_to(package) else one).as_posix() for one in modules if _opens(one)
    }
    assert opening - {"files.py"} == {*OF_FIELDKIT}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes in folders")
def test_the_beginning_of_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    os.symlink("/dev/zero", tmp_path / "endless.csv")
    os.symlink("loop.csv", tmp_path / "loop.csv")
    assert [beginning(tmp_path / f"{name}.csv") for name in ("pipe", "endless", "loop")] == [(), (), ()]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes in folders")
def test_a_log_that_is_a_pipe_is_not_waited_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "t.csv").write_text("flight_id,rocket,apogee_m,log\n1,Astra,100,pipe.csv\n")
    assert main(["import", str(tmp_path / "t.csv")]) == 0
    assert "cannot be read (a pipe or a device, not a plain file); imported without it" in capsys.readouterr().err


def test_an_endless_file_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MAX_FILE_SIZE", 1 << 20)
    (tmp_path / "long.csv").write_bytes(bytes((1 << 20) + 1))
    with pytest.raises(DamagedLog, match=r"cannot be read \(more than 1 MiB\)"):
        read_file(tmp_path / "long.csv")
    if Path("/dev/zero").exists():
        with pytest.raises(DamagedLog, match=r"cannot be read \(a pipe or a device"):
            read_file(Path("/dev/zero"))


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


def test_an_endless_motor_file_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own, "MAX_MOTOR_FILE_SIZE", 1 << 20)
    (tmp_path / "big.rse").write_bytes(b"<" * ((1 << 20) + 1))
    motors, errors = own.own_motors(tmp_path)
    assert not motors
    assert "cannot be read (more than 1 MiB)" in str(errors[0])


def test_a_log_that_expands_to_more_than_its_stated_size_is_not_unpacked(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([IncomingFlight(Flight(flight_id="1", rocket="Astra"), Original.of(bytes(10_000_000)))])
    engine = create_engine(f"sqlite:///{file}")
    with engine.begin() as connection:
        connection.execute(text("UPDATE logs SET size = 1000"))
    engine.dispose()
    with Ledger.open(file) as ledger, pytest.raises(LedgerError, match="differs from the 1,000 bytes"):
        ledger.log("1")


def test_nothing_is_ever_unpickled() -> None:
    folders = [ROOT / name for name in ("fieldkit", "parsers", "models", "bench", "tools")]
    unpicklers = {"pickle", "shelve", "marshal", "dill", "joblib", "cloudpickle"}
    for file in [file for folder in folders for file in folder.rglob("*.py")]:
        source = file.read_text(encoding="utf-8")
        if not any(name in source for name in (*unpicklers, "load")):
            continue
        for node in ast.walk(ast.parse(source)):
            names = {one.name for one in node.names} if isinstance(node, ast.Import) else set()
            names |= {str(node.module)} if isinstance(node, ast.ImportFrom) else set()
            assert not names & unpicklers, file
            if isinstance(node, ast.Attribute) and node.attr == "load":
                assert ast.unparse(node) not in ("torch.load", "np.load", "numpy.load"), file


# --- No network

FLIGHTS = str(ROOT / "fieldkit" / "data" / "reference_flights.csv")
ROCKET = "\x1b[2J[red]x[/] [/n] a\u202eb <b>{1}"
COMMANDS: dict[str, list[str]] = {
    "inspect": ["LOG", "TABLE"],
    "import": ["TABLE"],
    "export": [],
    "capture": ["--list"],
    "add": ["--rocket", ROCKET, "--motor", "F24-4W", "--apogee", "100m", "--notes", ROCKET, "--site", ROCKET],
    "flights": [],
    "units": [],
    "weather": [str(ROOT / "docs" / "example-weather.csv"), "--site", ROCKET],
    "flyer": [],
    "show": ["1"],
    "edit": ["1", "notes=x"],
    "tag": ["1", ROCKET],
    "untag": ["1", ROCKET],
    "remove": ["1"],
    "undo": [],
    "redo": [],
    "mappings": [],
    "sites": [ROCKET, "--elevation", "212m"],
    "kits": ["Big Bertha", "--dry-mass", "80g"],
    "remeasure": [],
    "report": ["2", "--out", "card.md"],
    "ork": ["DESIGN"],
    "history": [],
    "backups": [],
    "backups restore": ["--yes"],
    "docs": ["start"],
    "motors": ["F24"],
    "model": [],
    "simulate": ["--motor", "F24-4W", "--dry-mass", "322g", "--diameter", "66mm", "--cd", "0.6"],
    "compare": ["LOG", "LOG"],
    "infer": ["2"],
    "predict": ["--motor", "F24-4W", "--config", "A"],
    "predictions": [],
}
"""Every fast command, in an order in which each finds what it needs."""
LONG = {
    "demo": [],
    "loop": [],
    "learn": ["TABLE"],
    "score": [],
    "paper": [],
    "study reference": [],
    "study rockets": [],
    "study shortfall": [],
    "delay": ["--motor", "F24-4W"],
    "ballast": ["--motor", "F24-4W", "--target", "240m"],
    "contest": ["--season", "2026"],
    "season": ["--season", "2027", "--motor", "F24-4W"],
    "finals": ["--season", "2027", "--motor", "F24-4W", "--targets", "795-800"],
    "landing": ["--motor", "F24-4W", "--wind", "3m/s"],
    "daysheet": ["--motor", "F24-4W", "--wind", "3m/s", "--out", "sheet.png"],
}
OTHER_COMMANDS = {"serve", "tui", "train", "track"}
"""Commands that listen, need a terminal, run for hours in other processes, or need a log with satellite positions
(`tests/presentation/test_kml.py`)."""
REACHING = {"socket.connect", "socket.bind", "socket.getaddrinfo", "socket.sendto", "socket.sendmsg", "urllib.Request"}
_forbidden: list[str] | None = None


def _watch(event: str, arguments: tuple[object, ...]) -> None:
    if _forbidden is not None and event in REACHING:
        _forbidden.append(f"{event} {arguments!r}")
        raise OSError("no network here")


@pytest.fixture
def sockets() -> Iterator[list[str]]:
    """Attempts to use a socket; each fails."""
    global _forbidden
    sys.addaudithook(_watch)  # it stays installed, and does nothing after this test
    _forbidden = []
    yield _forbidden
    _forbidden = None


def leaves(command: Any, words: tuple[str, ...] = ()) -> Iterator[str]:
    """Every command with an effect, with the arguments that lead to it."""
    below = getattr(command, "commands", {})
    if words and (not below or command.invoke_without_command):
        yield " ".join(words)
    for word, one in below.items():
        yield from leaves(one, (*words, word))


def test_every_command_is_tried_here() -> None:
    assert {*COMMANDS, *LONG, *OTHER_COMMANDS} == set(leaves(typer.main.get_command(app)))


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, list[str]], list[str]]:
    """The arguments of a command about flights of a rocket with a hostile name, in a folder with everything that it
    needs."""
    monkeypatch.chdir(tmp_path)
    log = next((ROOT / "sample_logs").glob("perfectflite__drogue*")).read_bytes()
    unusual = "".join(c for c in ROCKET if c not in "<>/" and (c >= " " or sys.platform != "win32"))
    named = {name: Path(f"{unusual}.{name.lower()}") for name in ("TABLE", "DESIGN", "LOG")}
    named["TABLE"].write_text(Path(FLIGHTS).read_text(encoding="utf-8").replace("Astra", ROCKET), encoding="utf-8")
    named["DESIGN"].write_text(design().replace("Skylark", "a\u202eb[red]"), encoding="utf-8")
    named["LOG"].write_bytes(log)
    motors = tmp_path / "home" / "motors"
    motors.mkdir(parents=True)
    (motors / "mine.eng").write_text("F24\x1b[2J[red] 24 70 4 0.02 0.05 \u202eMe\n0.1 50\n1.0 0\n;\n", encoding="utf-8")
    return lambda command, words: [*command.split(), *(str(named.get(word, word)) for word in words)]


def harmless(captured: tuple[str, str]) -> bool:
    """Whether nothing was printed that a terminal would execute."""
    return not {c for c in "".join(captured) if unicodedata.category(c) in ("Cc", "Cf", "Cs") and c != "\n"}


@pytest.mark.thorough
def test_no_command_uses_a_network_or_prints_a_name_unescaped(
    sockets: list[str],
    asked: Callable[[str, list[str]], list[str]],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("TERM", "dumb")  # no colors of the terminal
    for command, words in COMMANDS.items():
        assert main(asked(command, words)) == 0, (command, capsys.readouterr())
        assert not sockets, command
        assert harmless(capsys.readouterr()), command
    assert harmless((Path("card.md").read_text(encoding="utf-8"), ""))


@pytest.mark.slow
@pytest.mark.parametrize("command", LONG)
def test_no_long_command_uses_a_network_or_prints_a_name_unescaped(
    command: str,
    sockets: list[str],
    asked: Callable[[str, list[str]], list[str]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(asked("import", ["TABLE"]))
    assert main(asked(command, LONG[command])) == 0, capsys.readouterr()
    assert not sockets
    assert harmless(capsys.readouterr())
