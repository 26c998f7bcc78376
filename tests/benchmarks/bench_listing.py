"""`fieldkit flights` with long ledgers, to the first screen and in total: `pytest -o addopts= --benchmark-only -s
tests/benchmarks/bench_listing.py`.

Each is a whole process, in processor time, relative to `fieldkit --version` and to a bare import of the command's two
libraries in the same run.
"""

import subprocess
import sys

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from tests.benchmarks.bench_ledger import ledger
from tests.benchmarks.timing import FLYER, beside, measured, of_children

pytestmark = pytest.mark.benchmark(timer=of_children)
COMMAND = "import sys; sys.argv[1:] = {!r}; from fieldkit.cli.main import run; run()"
BARE = "import os, sqlalchemy.dialects.sqlite.pysqlite, typer.main; os._exit(0)"
"""Exit without freeing memory, like the commands."""
SCREEN = 24
"""Lines of a terminal. [1]"""
SECONDS: dict[str, float] = {}
"""Times of the baselines. [s]"""


def printed(code: str, lines: int | None = None) -> None:
    """A separate Python process, ended after a number of lines, or run to its end."""
    with subprocess.Popen([sys.executable, "-c", code], env=FLYER, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        for read, _ in enumerate(process.stdout, start=1):
            if read == lines:
                process.stdout.close()
                process.kill()
                break


LEAST = {"fieldkit --version": COMMAND.format(["--version"]), "bare imports": BARE}


@pytest.mark.parametrize("what", LEAST)
def test_the_least_that_it_could_be(benchmark: BenchmarkFixture, what: str) -> None:
    benchmark.group = what
    SECONDS[what] = measured(benchmark, printed, LEAST[what], rounds=9)
    beside(benchmark, SECONDS[what], SECONDS["fieldkit --version"], "fieldkit --version")


@pytest.mark.parametrize(("size", "lines"), [(100, SCREEN), (100_000, SCREEN), (100, None), (10_000, None)])
def test_the_command_flights(benchmark: BenchmarkFixture, size: int, lines: int | None) -> None:
    benchmark.group = "the first screen of `flights`" if lines else "all of `flights`"
    code = COMMAND.format(["--ledger", str(ledger(size)), "flights"])
    seconds = measured(benchmark, printed, code, lines, rounds=9)
    ratio = beside(benchmark, seconds, SECONDS["bare imports"], "bare imports")
    assert ratio < (2.0 if lines else 4.0)
