"""How fast the app is there and answers a key: `pytest -o addopts= --benchmark-only -s tests/bench_app.py`.

The first group holds the app and an empty Textual app, each as a whole process up to its first paint; the second the
time from a key to the screen that shows it, in a ledger of 5,000 flights, beside an empty app that answers a key.
Times are of the processor, all threads together: what workers do while a key is answered is counted with it.
"""

import asyncio
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
from textual.constants import MAX_FPS
from textual.pilot import Pilot

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from tests.pressing import opened, season
from tests.timing import FLYER, beside, of_children

MANY = 5000
PAINT = 2.5
"""Times an empty app, at most. [1]"""


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


def measure(benchmark: BenchmarkFixture, code: str) -> None:
    def start() -> None:
        subprocess.run([sys.executable, "-c", code], env=FLYER, check=True, stdout=subprocess.DEVNULL)

    benchmark.pedantic(start, rounds=9, warmup_rounds=1)
    TOOK[benchmark.name] = benchmark.stats.stats.data


@pytest.mark.benchmark(group="first paint", timer=of_children)
def test_an_empty_app_is_painted(benchmark: BenchmarkFixture) -> None:
    measure(benchmark, EMPTY)


@pytest.mark.benchmark(group="first paint", timer=of_children)
def test_the_app_is_painted(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    season(tmp_path / "ledger.db")
    measure(benchmark, OURS.format(str(tmp_path / "ledger.db"), tmp_path / "settings.json"))
    empty, ours = (float(np.median(TOOK[name])) for name in ("test_an_empty_app_is_painted", benchmark.name))
    assert beside(benchmark, ours, empty, "an empty app") < PAINT


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
    *("2", "down", "9", "2", "3", "enter", "1", "4", "0", "up", "ctrl+u", "escape"),
    *("6", "down", "right", "left", "7", "3", "1"),
]
"""Moving, filtering as one types, sorting by each column, typing a flight in, turning pages: each a key of its own.
Pages are made ready out of sight before; the first time that a key is pressed counts with the others."""


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
                await self._answered(pilot.app)
                self.done.put_nowait(None)
        self.done.put_nowait(None)

    async def _answered(self, app: App[None]) -> None:
        """Until nothing that a key brought about is left to do and the screen shows it, painted when Textual paints."""
        while True:
            while self.loop._ready:  # type: ignore[attr-defined]  # messages that widgets were woken for
                await asyncio.sleep(0)
            screen = app.screen
            if not (screen._dirty_widgets or screen._layout_required or screen._repaint_required or screen._callbacks):
                return
            await asyncio.sleep(1 / MAX_FPS)

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
    session.press("down")  # the app is opened
    benchmark.pedantic(lambda: session.press(next(keys)), rounds=5 * len(KEYS))
    session.press("")
    session.loop.close()
    TOOK[benchmark.name] = benchmark.stats.stats.data


@pytest.mark.benchmark(group="a key", timer=processor)
def test_an_empty_app_hears_a_key(benchmark: BenchmarkFixture) -> None:
    answer(benchmark, listening)


@pytest.mark.benchmark(group="a key", timer=processor)
def test_a_key_is_answered_with_five_thousand_flights(
    benchmark: BenchmarkFixture, crowded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(crowded.parent)  # a folder with few files for the page Import
    answer(benchmark, lambda: opened(crowded, stays=True))
    empty, ours = TOOK["test_an_empty_app_hears_a_key"], TOOK[benchmark.name]
    slowest = sorted(zip(ours, cycle(KEYS), strict=False), reverse=True)[:5]
    shares = {
        f"within_{share:.0%}_ms": round(float(np.quantile(ours, share)) * 1e3, 1) for share in (0.5, 0.95, 0.99, 1)
    }
    benchmark.extra_info |= shares | {"slowest_ms": [f"{key} {took * 1e3:.0f}" for took, key in slowest]}
    beside(benchmark, float(np.median(ours)), float(np.median(empty)), "an empty app")
    sys.stdout.write(f"{benchmark.extra_info}\n")
