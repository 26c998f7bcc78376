"""How much of a command's start is ours: `pytest -o addopts= --benchmark-only tests/bench_start.py`.

Each group holds a command as a whole process and the least that any program of its kind must do: a typer
program without a command, or the libraries that the command needs. The ratio is printed with the group.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

ROOT = Path(__file__).parents[1]
FLYER = {k: v for k, v in os.environ.items() if k != "FIELDKIT_CHECK_SHAPES"} | {"PYTHONPATH": str(ROOT)}

EMPTY = """
import typer
app = typer.Typer()
@app.command()
def nothing() -> None:
    "Nothing."
app(["--help"])
"""
BARE = "import typer, sqlalchemy, numpy"
FIELDKIT = "import sys; from fieldkit.cli.main import main; sys.exit(main({!r}))"


@pytest.fixture(scope="module")
def ledger(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = str(tmp_path_factory.mktemp("start") / "ledger.db")
    start(FIELDKIT.format(["--ledger", path, "import", str(ROOT / "fieldkit/data/reference_flights.csv")]))
    return path


def start(code: str) -> None:
    """One whole process."""
    subprocess.run([sys.executable, "-c", code], env=FLYER, check=True, stdout=subprocess.DEVNULL)


def measure(benchmark: BenchmarkFixture, code: str) -> None:
    benchmark.pedantic(start, (code,), rounds=7, warmup_rounds=1)


@pytest.mark.benchmark(group="help")
def test_an_empty_typer_program(benchmark: BenchmarkFixture) -> None:
    measure(benchmark, EMPTY)


@pytest.mark.benchmark(group="help")
def test_help(benchmark: BenchmarkFixture) -> None:
    measure(benchmark, FIELDKIT.format(["--help"]))


@pytest.mark.benchmark(group="predict")
def test_bare_imports(benchmark: BenchmarkFixture) -> None:
    measure(benchmark, BARE)


@pytest.mark.benchmark(group="predict")
def test_predict(benchmark: BenchmarkFixture, ledger: str) -> None:
    measure(benchmark, FIELDKIT.format(["--ledger", ledger, "predict", "--motor", "F24-4W"]))


@pytest.mark.benchmark(group="predict")
def test_flights(benchmark: BenchmarkFixture, ledger: str) -> None:
    measure(benchmark, FIELDKIT.format(["--ledger", ledger, "flights"]))
