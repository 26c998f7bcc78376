"""Starting a command: `pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_start.py`.

Each command is a whole process and is compared with a bare Python process that imports the same third-party modules;
`--help` with an empty typer program, and `predict` also with the program's four libraries. Times are processor time.
"""

from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.ledger import Ledger
from fieldkit.model.readout_data import OBSERVED_READOUTS
from tests.benchmarks.timing import ROOT, beside, measured, of_children, whole_process
from tests.seasons import season

pytestmark = pytest.mark.benchmark(timer=of_children, group="start")
HELP, PREDICT = 1.5, 1.5
"""Maximum ratio to an empty typer program and bare imports; the aim is 1.3, which a busy machine exceeds. [1]"""

EMPTY = """
import typer
app = typer.Typer()
@app.command()
def nothing() -> None:
    "Nothing."
app(["--help"])
"""
FIELDKIT = "import sys; sys.argv[1:] = {!r}; from fieldkit.cli.main import run; run()"
STARTED = """
import contextlib, io, sys
from fieldkit.cli.main import main
with contextlib.redirect_stdout(io.StringIO()):
    assert main({!r}) == 0
own = {{*sys.stdlib_module_names, "fieldkit", "__main__"}}
print(*[name for name in sys.modules if name.split(".")[0] not in own])
"""
BARE = """
import importlib, contextlib
for name in {!r}:
    with contextlib.suppress(Exception):  # some are there only once others are
        importlib.import_module(name)
"""
LIBRARIES = ["numpy", "onnxruntime", "sqlalchemy", "typer"]
"""The program's libraries."""
LOG = str(ROOT / "sample_logs/perfectflite__drogue_and_main.pf2")
"""One small log."""
COPIED = "import shutil; shutil.copy({!r}, {!r}); "
"""An import adds a flight only once, so each round has a ledger of its own."""
COMMANDS = {
    "flights": [],
    "show": ["1"],
    "history": [],
    "motors": ["F24"],
    "infer": ["1"],
    "predict": ["--motor", "F24-4W"],
    "simulate": ["--motor", "F24-4W", "--dry-mass", "322g", "--diameter", "66mm", "--cd", "0.6"],
    "export": [],
}


@pytest.fixture(scope="module")
def ledger(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A season of twelve flights."""
    path = str(tmp_path_factory.mktemp("start") / "ledger.db")
    whole_process(FIELDKIT.format(["--ledger", path, "import", str(ROOT / "fieldkit/data/reference_flights.csv")]))
    return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A season of twenty flights with all readouts."""
    path = tmp_path_factory.mktemp("start") / "whole.db"
    with Ledger.open(path) as opened:
        opened.add([flight for flight, _ in season(np.random.default_rng(3), OBSERVED_READOUTS[:6], 20)])
    return str(path)


def least(code: str, rounds: int = 5) -> float:
    """The minimum time over whole processes. [s]"""
    spent = []
    for _ in range(rounds):
        began = of_children()
        whole_process(code)
        spent.append(of_children() - began)
    return min(spent)


def test_help(benchmark: BenchmarkFixture) -> None:
    seconds = measured(benchmark, whole_process, FIELDKIT.format(["--help"]))
    assert beside(benchmark, seconds, least(EMPTY), "an empty typer program") <= HELP


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command(benchmark: BenchmarkFixture, command: str, ledger: str, tmp_path: Path) -> None:
    arguments = ["--ledger", ledger, command, *COMMANDS[command]]
    started = whole_process(STARTED.format(arguments)).split()
    seconds = measured(benchmark, whole_process, FIELDKIT.format(arguments))
    beside(benchmark, seconds, least(BARE.format(started)), "bare imports")


@pytest.mark.parametrize("what", ["12 apogees", "20 flights with all readouts"])
def test_a_prediction(benchmark: BenchmarkFixture, what: str, ledger: str, whole: str) -> None:
    """Relative to the program's libraries."""
    arguments = ["--ledger", ledger if what == "12 apogees" else whole, "predict", *COMMANDS["predict"]]
    seconds = measured(benchmark, whole_process, FIELDKIT.format(arguments))
    assert beside(benchmark, seconds, least(BARE.format(LIBRARIES)), "bare " + ", ".join(LIBRARIES)) <= PREDICT


@pytest.mark.parametrize("libraries", [["numpy", "pandas"], ["numpy", "scipy.linalg", "sqlalchemy", "typer"]])
def test_an_import_of_one_log(benchmark: BenchmarkFixture, libraries: list[str], ledger: str, tmp_path: Path) -> None:
    """Relative to the libraries that read a table elsewhere, and to those that the import uses."""
    copy = str(tmp_path / "ledger.db")
    code = COPIED.format(ledger, copy) + FIELDKIT.format(["--ledger", copy, "import", LOG])
    seconds = measured(benchmark, whole_process, code)
    beside(benchmark, seconds, least(BARE.format(libraries)), "bare " + ", ".join(libraries))
