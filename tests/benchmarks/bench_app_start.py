"""How fast the app starts: `pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_app_start.py`.

Processor time of a whole process until its first paint, and until the rows of its first page are painted, compared with
an empty Textual app until its first paint, in alternating rounds.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from tests.benchmarks.timing import FLYER, beside, of_children
from tests.pressing import season

MAX_RATIO = 1.4
"""Maximum ratio to an empty app. [1]"""
PAINTED = """
import asyncio, os
async def painted():
    async with app.run_test(size=(80, 24)):
        os._exit(0)
asyncio.run(painted())
"""
EMPTY = "from textual.app import App\napp = App()\n" + PAINTED
COMMAND = "from fieldkit.tui.memory import pause_collection\npause_collection()\n"
"""The start of the command, before it imports the app."""
OURS = (
    "from pathlib import Path, PosixPath\n"
    + COMMAND
    + "from fieldkit.tui.app import FieldkitApp\napp = FieldkitApp({!r}, {!r})\n"
    + PAINTED
)

ROWS = (
    "from pathlib import Path, PosixPath\nimport asyncio, os\n"
    + COMMAND
    + "from fieldkit.tui.app import FieldkitApp\nfrom fieldkit.tui.widgets.table import Table\n"
    "drawn = Table.render_line\n"
    "def line(table, y):\n"
    "    if y and table.keys:\n"
    "        table.call_after_refresh(os._exit, 0)\n"
    "    return drawn(table, y)\n"
    "Table.render_line = line\n"
    "async def painted():\n"
    "    async with FieldkitApp({!r}, {!r}).run_test(size=(80, 24)):\n"
    "        await asyncio.sleep(60)\n"
    "asyncio.run(painted())\n"
)
"""The app until the rows of its first page are painted."""


def start(code: str) -> None:
    """Run an app as a process of its own."""
    subprocess.run([sys.executable, "-c", code], env=FLYER, check=True, stdout=subprocess.DEVNULL)


def beside_an_empty_app(benchmark: BenchmarkFixture, code: str) -> float:
    """The ratio of an app to an empty one, in alternating rounds, so that other load on the machine slows both. [1]"""
    empty = list[float]()

    def start_empty() -> None:
        before = of_children()
        start(EMPTY)
        empty.append(of_children() - before)

    start(code)  # to warm up
    benchmark.pedantic(start, (code,), setup=start_empty, rounds=15)
    ours = benchmark.stats.stats.median
    return beside(benchmark, ours, float(np.median(empty)), "an empty app")


@pytest.mark.parametrize("what", ["the first paint", "the first rows"])
@pytest.mark.benchmark(group="until", timer=of_children)
def test_start(what: str, benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    season(tmp_path / "ledger.db")
    code = {"the first paint": OURS, "the first rows": ROWS}[what]
    assert (
        beside_an_empty_app(benchmark, code.format(str(tmp_path / "ledger.db"), tmp_path / "settings.json")) < MAX_RATIO
    )
