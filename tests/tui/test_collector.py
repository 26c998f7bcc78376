"""The app keeps little memory: permanent objects are not scanned, removed screens are freed."""

import gc
from collections.abc import Iterable, Iterator
from pathlib import Path
from threading import Event
from weakref import WeakSet

import pytest
from textual.dom import DOMNode
from textual.widget import Widget

from fieldkit.tui.memory import freeze_permanent
from fieldkit.tui.page import PageScreen
from tests.pressing import calm, frozen, opened, press, season, shown

DEFAULT = (700, 10, 10)
"""Python's thresholds of the collector; the other tests have their own."""


@pytest.fixture(autouse=True)
def as_it_was() -> Iterator[None]:
    before = gc.get_threshold()
    gc.set_threshold(*DEFAULT)
    yield
    gc.set_threshold(*before)
    gc.freeze()


async def test_the_collector_skips_modules_and_pages_of_the_running_app(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    monkeypatch.setattr("fieldkit.tui.app.PAUSE", 0.0)
    gc.unfreeze()  # what was frozen when the tests were collected
    async with opened(tmp_path / "ledger.db", stays=True) as pilot:
        await calm(pilot)
        assert gc.get_freeze_count() > len(gc.get_objects())


class Ring:
    """Garbage that only the collector sees."""

    def __init__(self) -> None:
        self.itself = self


class Result:
    """Freed as soon as nothing refers to it."""


def rings() -> int:
    return sum(type(one) is Ring for one in gc.get_objects())


def test_skipping_permanent_objects_keeps_no_garbage_alive() -> None:
    for _ in range(100):
        Ring()
    gc.collect(1)  # the remaining ones are old
    freeze_permanent()
    gc.unfreeze()
    assert rings() == 0


def full_collections() -> int:
    found: int = gc.get_stats()[2]["collections"]
    return found


def test_permanent_objects_do_not_delay_the_collection_of_later_garbage() -> None:
    permanent: list[list[int]] = [[] for _ in range(600_000)]
    freeze_permanent()
    before = full_collections()
    later: list[list[int]] = [[] for _ in range(100_000)]
    assert len(permanent) > 4 * len(later)  # a quarter more would be collected in any case
    assert full_collections() > before


async def test_nothing_that_a_closed_screen_has_drawn_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    async with opened(tmp_path / "ledger.db") as pilot:
        await press(pilot, "f1")
        shown(pilot)
        widgets = pilot.app.screen.walk_children(with_self=True)
        assert line_count(widgets)
        await press(pilot, "escape")
        assert not widgets[0].is_attached
        assert not line_count(widgets)


def line_count(widgets: Iterable[DOMNode]) -> int:
    """Number of drawn lines in the caches of some widgets."""
    return sum(len(widget._styles_cache._cache) for widget in widgets if isinstance(widget, Widget))


async def test_the_result_of_a_request_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    async with opened(tmp_path / "ledger.db") as pilot:
        page, started, go = pilot.app.screen, Event(), Event()
        assert isinstance(page, PageScreen)
        made: WeakSet[Result] = WeakSet()

        def work() -> Result:
            started.set()
            go.wait(10)
            made.add(result := Result())
            return result

        gc.disable()
        try:
            page.ask(work, lambda _: None, "work", alone=True)
            while not started.is_set():
                await pilot.pause(0.01)
            page.ask(work, lambda _: None, "work", alone=True)  # drops the first request
            go.set()
            await calm(pilot)
        finally:
            gc.enable()
        assert len(made) == 0
