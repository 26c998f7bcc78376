"""Long requests run one at a time, and are dropped if nobody waits for them anymore."""

import asyncio
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.computing import Turn
from fieldkit.tui.loop import loop_page
from tests.pressing import opened, press, season

PATIENCE = 20.0
"""Time limit for canceling a request, on a busy machine. [s]"""


async def test_a_reload_due_while_the_app_closes_is_skipped(tmp_path: Path) -> None:
    app = FieldkitApp(tmp_path / "ledger.db", tmp_path / "settings.json")
    async with app.run_test():
        pass
    assert not app.screen_stack
    app.look_round()


async def test_one_large_computation_runs_at_a_time_and_gives_way_between_its_steps() -> None:
    turn, done, running = Turn(), list[str](), threading.Event()

    def long() -> None:
        running.set()
        ends = time.monotonic() + PATIENCE
        while not done and time.monotonic() < ends:
            turn.give_way()
        done.append("long")

    first = asyncio.ensure_future(turn.compute(long))
    await asyncio.to_thread(running.wait)
    dropped = asyncio.ensure_future(turn.compute(lambda: done.append("dropped")))
    dropped.cancel()
    await asyncio.gather(first, turn.compute(lambda: done.append("short")))
    assert done == ["short", "long"]


async def test_a_long_computation_returns_free_memory_between_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    returned: list[int] = []
    monkeypatch.setattr("fieldkit.tui.computing.give_back", lambda: returned.append(1))
    turn, seen = Turn(), list[int]()

    def long() -> None:
        for _ in range(9):
            turn.give_way()
        seen.append(len(returned))

    await turn.compute(long)
    turn.give_way()  # not a computation
    assert seen == [1], "not at every step"
    assert len(returned) == 2, "and at the end"


async def test_a_request_is_canceled_by_the_next_and_when_the_app_closes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[int] = []
    running: list[int] = []
    most = [0]
    lock = threading.Lock()

    def look_forever(_resources: Any, _rocket: str, on_progress: Any) -> None:
        with lock:
            started.append(len(started))
            running.append(started[-1])
            most[0] = max(most[0], len(running))
        ends = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < ends:
                on_progress("looking", 0.5)
                time.sleep(0.01)
        finally:
            with lock:
                running.pop()

    monkeypatch.setattr(loop_page, "look", look_forever)
    season(tmp_path / "ledger.db")
    began = time.monotonic()
    async with opened(tmp_path / "ledger.db") as pilot:
        await press(pilot, "5")
        for count in (1, 2, 3):
            await pilot.press("S")
            while len(started) < count:
                await pilot.pause(0.01)
        assert most == [1]
        pilot.app.workers.cancel_all()
        while running:
            await pilot.pause(0.01)
    assert time.monotonic() - began < PATIENCE
