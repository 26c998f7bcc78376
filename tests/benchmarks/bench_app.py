"""How fast the app answers a key: `pytest -o addopts= --benchmark-only -s tests/benchmarks/bench_app.py`.

All effects of a key with a ledger of 5,000 flights, compared with a key in an empty app. Times are processor time over
all threads, including workers. A key is answered, in wall-clock time, at the first paint after it, or when nothing is
left to paint; it is done when all workers are idle and the screen is up to date.
"""

import asyncio
import resource
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from datetime import datetime, timedelta
from functools import partial
from itertools import cycle
from pathlib import Path
from time import perf_counter
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from textual import events
from textual._compositor import Compositor
from textual.app import App
from textual.constants import MAX_FPS
from textual.pilot import Pilot
from textual.screen import Screen

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from tests.benchmarks.timing import beside
from tests.pressing import PAINTED as RENDERED
from tests.pressing import opened

MANY = 5000
SHARES = (0.5, 0.95, 0.99, 1)
"""Reported quantiles of the response times. [1]"""
AHEAD = "ready"
"""Work without a key: preparing pages in the background."""


def processor() -> float:
    """Processor time of this process with all threads and of its finished child processes. [s]"""
    spent = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in spent)


SECONDS: dict[str, list[float]] = {}
"""Seconds of every round, by benchmark."""


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
    *("s", "z", "s", "s", "s", "s", "s", "s", "s", "s", "s", "z"),
    *("2", "down", "9", "2", "3", "enter", "1", "4", "0", "up", "ctrl+u", "escape"),
    *("6", "down", "right", "left", "7", "3", "1", "home", "enter", "t", "down", "escape", "escape"),
    *("4", "down", "down", "up", "slash", "f", "escape", "5", "right", "left", "1"),
]
"""Moving, filtering, sorting by each column, entering a flight, changing pages, opening a flight and its tags, choosing
a motor, changing panels. Pages are prepared in the background first; the first press of a key counts like the
others."""


class Session:
    """An app that stays open while keys are sent one at a time; the response time of each. [s]"""

    def __init__(self, open: Callable[[], AbstractAsyncContextManager[Pilot[None]]]) -> None:
        self.loop = asyncio.new_event_loop()
        self.keys: asyncio.Queue[str] = asyncio.Queue()
        self.done: asyncio.Queue[None] = asyncio.Queue()
        self.task = self.loop.create_task(self._run(open))
        self.answers: list[float] = []
        self.places: list[str] = []
        """The key and the page of each answer."""
        self.paints = 0
        """Number of keys after which something was painted. [1]"""
        self.painted: float | None = None

    async def _run(self, open: Callable[[], AbstractAsyncContextManager[Pilot[None]]]) -> None:
        async with open() as pilot:
            with (
                patch.object(pilot.app, "_display", partial(self._paint, pilot.app)),
                patch.object(Compositor, "render_update", RENDERED),  # tests paint nothing until they look
            ):
                while key := await self.keys.get():
                    self.painted, pressed, page = None, perf_counter(), pilot.app.current_mode
                    pilot.app.post_message(events.Key(key, key if len(key) == 1 else None))
                    await self._done(pilot.app)
                    self.answers.append((self.painted or perf_counter()) - pressed)
                    self.places.append(f"{key} on {page}")
                    self.paints += self.painted is not None
                    self.done.put_nowait(None)
        self.done.put_nowait(None)

    def _paint(self, app: App[None], screen: Screen[None], what: Any) -> None:
        """Render the terminal's output, and note the time of the first one."""
        if what is not None and not app._batch_count:
            what.render_segments(app.console)
            self.painted = self.painted or perf_counter()

    async def _done(self, app: App[None]) -> None:
        """Wait until all effects of a key are done and painted by Textual."""
        while True:
            while self.loop._ready:  # type: ignore[attr-defined]  # messages waiting for widgets
                await asyncio.sleep(0)
            screen, busy = app.screen, [one for one in app.workers if not one.is_finished and one.group != AHEAD]
            due = screen._dirty_widgets or screen._layout_required or screen._repaint_required or screen._callbacks
            if not (busy or due):
                return
            await asyncio.sleep(1 / MAX_FPS)

    def press(self, key: str) -> None:
        """Send a key and wait for its effects; an empty key closes the app."""
        self.keys.put_nowait(key)
        self.loop.run_until_complete(self.done.get())


@asynccontextmanager
async def listening() -> AsyncIterator[Pilot[None]]:
    """An empty app that receives keys and does nothing."""
    async with App[None]().run_test(size=(80, 24)) as pilot:
        yield pilot


def answer(benchmark: BenchmarkFixture, open: Callable[[], AbstractAsyncContextManager[Pilot[None]]]) -> Session:
    """A session with the response time of each key."""
    session, keys = Session(open), cycle(KEYS)
    session.press("down")  # the app is opened
    session.answers.clear()
    session.places.clear()
    session.paints = 0
    benchmark.pedantic(lambda: session.press(next(keys)), rounds=5 * len(KEYS))
    session.press("")
    session.loop.close()
    SECONDS[benchmark.name] = benchmark.stats.stats.data
    return session


def shares(name: str, seconds: Sequence[float], places: Sequence[str]) -> dict[str, Any]:
    """Quantiles of the response times, and the slowest keys with their pages."""
    slowest = sorted(zip(seconds, places, strict=True), reverse=True)[:5]
    within = {
        f"within_{fraction:.0%}_{name}_ms": round(float(np.quantile(seconds, fraction)) * 1e3, 1) for fraction in SHARES
    }
    return within | {f"slowest_{name}_ms": [f"{key} {one * 1e3:.0f}" for one, key in slowest]}


@pytest.mark.benchmark(group="a key", timer=processor)
def test_an_empty_app_hears_a_key(benchmark: BenchmarkFixture) -> None:
    answer(benchmark, listening)


@pytest.mark.benchmark(group="a key", timer=processor)
def test_a_key_is_answered_with_five_thousand_flights(
    benchmark: BenchmarkFixture, crowded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(crowded.parent)  # a folder with few files for the Import page
    session = answer(benchmark, lambda: opened(crowded, stays=True))
    assert session.paints > len(session.answers) / 2, "what the app paints is not seen: answers are not measured"
    empty, ours = SECONDS["test_an_empty_app_hears_a_key"], SECONDS[benchmark.name]
    benchmark.extra_info |= shares("answered", session.answers, session.places)
    benchmark.extra_info |= shares("done", ours, session.places)
    beside(benchmark, float(np.median(ours)), float(np.median(empty)), "an empty app")
    sys.stdout.write(f"{benchmark.extra_info}\n")
