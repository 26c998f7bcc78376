"""Long requests run one at a time, and are dropped if nobody waits for them anymore."""

import asyncio
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.computing import MAX_PAUSED, Turn
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


def stepping(turn: Turn, name: str, states: dict[str, str], dropped: threading.Event | None = None) -> Any:
    """A computation that gives way until its state is `end` or it is dropped."""

    def work() -> None:
        states[name] = "runs"
        ends = time.monotonic() + PATIENCE
        while states[name] != "end" and time.monotonic() < ends:
            turn.give_way(dropped.is_set if dropped is not None else lambda: False)
            if dropped is not None and dropped.is_set():
                break
        states[name] = "ended"

    return work


async def until(states: dict[str, str], name: str, state: str) -> None:
    """Wait until a computation has a state."""
    while states.get(name) != state:
        await asyncio.sleep(0.01)


async def test_a_computation_that_gave_way_ends_when_it_is_dropped_and_does_not_wait_for_its_turn() -> None:
    turn, states, dropped = Turn(), dict[str, str](), threading.Event()
    first = asyncio.ensure_future(turn.compute(stepping(turn, "first", states, dropped)))
    await until(states, "first", "runs")
    second = asyncio.ensure_future(turn.compute(stepping(turn, "second", states)))
    await until(states, "second", "runs")
    dropped.set()
    await first
    assert states == {"first": "ended", "second": "runs"}
    third = asyncio.ensure_future(turn.compute(stepping(turn, "third", states)))
    await until(states, "third", "runs")
    states["third"] = "end"
    await third
    states["second"] = "end"
    await second


async def test_no_more_computations_give_way_than_may_keep_their_memory() -> None:
    turn, states = Turn(), dict[str, str]()
    asked = []
    for n in range(MAX_PAUSED + 1):
        asked.append(asyncio.ensure_future(turn.compute(stepping(turn, str(n), states))))
        await until(states, str(n), "runs")
    last = asyncio.ensure_future(turn.compute(stepping(turn, "last", states)))
    await asyncio.sleep(0.2)
    assert "last" not in states
    states[str(MAX_PAUSED)] = "end"
    states["last"] = "end"
    for n in range(MAX_PAUSED):
        await until(states, str(n), "runs")
        states[str(n)] = "end"
    await asyncio.gather(*asked[:-1])
    await until(states, "last", "runs")
    states["last"] = "end"
    await asyncio.gather(*asked, last)


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
