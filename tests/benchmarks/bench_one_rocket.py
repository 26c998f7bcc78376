"""`loop` and `report` for one rocket with 10 to 250 flights: `pytest -o addopts= --benchmark-only -s
tests/benchmarks/bench_one_rocket.py`.

Each is a whole process, in processor time; the ratio to 10 flights is printed.
"""

from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.ledger import Ledger
from tests.benchmarks.bench_ledger import ledger
from tests.benchmarks.timing import beside, of_children, whole_process

pytestmark = pytest.mark.benchmark(timer=of_children)
COMMAND = "import sys; sys.argv[1:] = {!r}; from fieldkit.cli.main import run; run()"
COMMANDS = {"loop": ["loop", "--rocket", "Astra"], "report": ["report", "Astra", "--force", "--out"]}
FEWEST = 10
SECONDS: dict[str, float] = {}
"""Time of each command with the fewest flights. [s]"""


@pytest.mark.parametrize("count", [FEWEST, 50, 100, 250])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_on_one_rocket(benchmark: BenchmarkFixture, command: str, count: int, tmp_path: Path) -> None:
    benchmark.group = f"`{command}` of one rocket"
    file = tmp_path / "ledger.db"
    with Ledger.open(ledger(1_000)) as source, Ledger.open(file) as one:
        one.add([flight.with_changes(rocket="Astra") for flight in source.flights()[:count]])
    arguments = ["--ledger", str(file), *COMMANDS[command]]
    arguments += [str(tmp_path / "astra.html")] if command == "report" else []
    benchmark.pedantic(whole_process, [COMMAND.format(arguments)], rounds=1)
    seconds = float(benchmark.stats.stats.min)
    beside(benchmark, seconds, SECONDS.setdefault(command, seconds), f"`{command}` of {FEWEST} flights")
