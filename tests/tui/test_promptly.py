"""What keys would have to wait for is done while none is pressed."""

import gc
import sys
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldkit.tui import promptly
from tests.pressing import frozen, opened, press, season

CHECK_SHAPES = False


class Knot:
    """Something that only the collector can undo."""

    def __init__(self) -> None:
        self.me = self


@pytest.fixture(autouse=True)
def as_it_was() -> Iterator[None]:
    thresholds, interval = gc.get_threshold(), sys.getswitchinterval()
    yield
    gc.set_threshold(*thresholds)
    sys.setswitchinterval(interval)
    gc.unfreeze()


def test_what_is_knotted_is_collected_in_a_rest_where_enough_came_together(monkeypatch: pytest.MonkeyPatch) -> None:
    promptly.begin()
    knot = Knot()
    gc.collect(1)  # it is old now, and young collections pass it by
    there = weakref.ref(knot)
    del knot
    monkeypatch.setattr(promptly, "COLLECTIONS_BEFORE_FULL", promptly.NO_AUTOMATIC_FULL)
    promptly.tidy()
    assert there() is not None
    monkeypatch.setattr(promptly, "COLLECTIONS_BEFORE_FULL", 0)
    promptly.tidy()
    assert there() is None


async def test_no_key_waits_for_a_whole_collection_in_an_app_that_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frozen(monkeypatch)
    monkeypatch.setattr(promptly, "REST", 3600.0)
    season(tmp_path / "ledger.db")
    async with opened(tmp_path / "ledger.db", stays=True) as pilot:
        before = gc.get_stats()[2]["collections"]
        await press(pilot, "down", "enter", "escape", "t", "down", "escape", "6", "right", "1")
        assert gc.get_stats()[2]["collections"] == before
