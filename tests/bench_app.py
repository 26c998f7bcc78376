"""How fast the app is there and answers: `pytest -o addopts= --benchmark-only tests/bench_app.py`.

The first group holds the app and an empty Textual app, each as a whole process up to its first paint; the second the
time from a key to the screen that shows it, in a ledger of 5,000 flights, beside an empty app that answers a key.
On a machine that does other things as well, `--benchmark-timer=tests.bench_app.processor` counts processor time.
"""

import asyncio
import os
import resource
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from datetime import datetime, timedelta
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from textual import events
from textual.app import App
from textual.pilot import Pilot

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from tests.pressing import opened, season

ROOT = Path(__file__).parents[1]
FLYER = {k: v for k, v in os.environ.items() if k != "FIELDKIT_CHECK_SHAPES"} | {"PYTHONPATH": str(ROOT)}
MANY = 5000


def processor() -> float:
    """Processor time of this process, all of its threads, and of the processes that it has waited for. [s]"""
    spent = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in spent)


PAINTED = """
import asyncio, os
async def painted():
    async with app.run_test(size=(80, 24)):
        os._exit(0)
asyncio.run(painted())
"""
EMPTY = "from textual.app import App\napp = App()\n" + PAINTED
OURS = (
    "from pathlib import Path, PosixPath\nfrom fieldkit.tui.app import FieldkitApp\napp = FieldkitApp({!r}, {!r})\n"
    + PAINTED
)


TOOK: dict[str, list[float]] = {}
"""Seconds of every round, by the benchmark that it is of."""


def tell(capsys: pytest.CaptureFixture[str], *lines: str) -> None:
    """Print lines among the benchmarks."""
    with capsys.disabled():
        sys.stdout.write("\n".join(["", *lines]))


def measure(benchmark: BenchmarkFixture, code: str) -> None:
    def start() -> None:
        subprocess.run([sys.executable, "-c", code], env=FLYER, check=True, stdout=subprocess.DEVNULL)

    benchmark.pedantic(start, rounds=9, warmup_rounds=1)
    TOOK[benchmark.name] = benchmark.stats.stats.data


@pytest.mark.benchmark(group="first paint")
def test_an_empty_app_is_painted(benchmark: BenchmarkFixture) -> None:
    measure(benchmark, EMPTY)


@pytest.mark.benchmark(group="first paint")
def test_the_app_is_painted(benchmark: BenchmarkFixture, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    season(tmp_path / "ledger.db")
    measure(benchmark, OURS.format(str(tmp_path / "ledger.db"), tmp_path / "settings.json"))
    empty, ours = (float(np.median(TOOK[name])) for name in ("test_an_empty_app_is_painted", benchmark.name))
    tell(capsys, f"first paint in {ours:.2f} s, {ours / empty:.1f} times an empty app's {empty:.2f} s")


@pytest.fixture(scope="module")
def crowded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ledger of 5,000 flights."""
    file = tmp_path_factory.mktemp("many") / "ledger.db"
    first = datetime(2020, 1, 1, 10)
    flights = [
        Flight(
            flight_id=str(n),
            rocket=f"Rocket {n % 17}",
            config="AB"[n % 2],
            motor=("C6-5", "F24-4W", "E35-5W")[n % 3],
            date_time=first + timedelta(hours=n),
            dry_mass=0.3,
            diameter=0.066,
            apogee=100.0 + n % 200,
        )
        for n in range(MANY)
    ]
    with Ledger.open(file) as ledger:
        ledger.add(flights)
    return file


KEYS = [
    *("down", "up", "pagedown", "pageup", "end", "home"),
    *("slash", "2", "f", "4", "backspace", "backspace", "backspace", "escape"),
    *("s", "r", "s", "s", "s", "s", "s", "s", "s", "s", "s", "r"),
    *("2", "9", "2", "3", "enter", "up", "ctrl+u", "escape", "6", "down", "right", "left", "7", "3", "1"),
]
"""Moving, filtering as one types, sorting by each column, typing a flight in, turning pages: each a key of its own.
Pages are opened for the first time while the benchmark warms up."""


class Session:
    """An app that stays open while keys are sent to it, one at a time."""

    def __init__(self, open: Callable[[], AbstractAsyncContextManager[Pilot[None]]]) -> None:
        self.loop = asyncio.new_event_loop()
        self.keys: asyncio.Queue[str] = asyncio.Queue()
        self.done: asyncio.Queue[None] = asyncio.Queue()
        self.task = self.loop.create_task(self._run(open))

    async def _run(self, open: Callable[[], AbstractAsyncContextManager[Pilot[None]]]) -> None:
        async with open() as pilot:
            while key := await self.keys.get():
                pilot.app.post_message(events.Key(key, key if len(key) == 1 else None))
                await pilot._wait_for_screen()  # until every message that the key brought about was read
                self.done.put_nowait(None)
        self.done.put_nowait(None)

    def press(self, key: str) -> None:
        """Send a key and wait for what comes of it; the empty one closes the app."""
        self.keys.put_nowait(key)
        self.loop.run_until_complete(self.done.get())


@asynccontextmanager
async def listening() -> AsyncIterator[Pilot[None]]:
    """An empty app that is told of keys and does nothing."""
    async with App[None]().run_test(size=(80, 24)) as pilot:
        yield pilot


def answer(benchmark: BenchmarkFixture, open: Callable[[], AbstractAsyncContextManager[Pilot[None]]]) -> None:
    session, keys = Session(open), cycle(KEYS)
    benchmark.pedantic(lambda: session.press(next(keys)), rounds=5 * len(KEYS), warmup_rounds=len(KEYS))
    session.press("")
    session.loop.close()
    TOOK[benchmark.name] = benchmark.stats.stats.data


@pytest.mark.benchmark(group="a key")
def test_an_empty_app_hears_a_key(benchmark: BenchmarkFixture) -> None:
    answer(benchmark, listening)


@pytest.mark.benchmark(group="a key")
def test_a_key_is_answered_with_five_thousand_flights(
    benchmark: BenchmarkFixture, crowded: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answer(benchmark, lambda: opened(crowded))
    empty, ours = TOOK["test_an_empty_app_hears_a_key"], TOOK[benchmark.name]
    slowest = sorted(zip(ours, cycle(KEYS), strict=False), reverse=True)[:5]
    lines = []
    for name, share in (("half of the keys", 0.5), ("19 of 20", 0.95), ("all", 1.0)):
        took, beside = (float(np.quantile(times, share)) for times in (ours, empty))
        lines.append(
            f"{name} within {took * 1e3:.1f} ms, {took / beside:.1f} times an empty app's {beside * 1e3:.1f} ms"
        )
    lines.append("slowest: " + ", ".join(f"{key} {took * 1e3:.0f} ms" for took, key in slowest))
    tell(capsys, *lines)
