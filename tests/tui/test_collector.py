"""No key waits for the garbage collector to scan permanent flights and pages."""

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldkit.tui.memory import PassedBy
from tests.pressing import calm, frozen, opened, press, season


@pytest.fixture(autouse=True)
def as_it_was() -> Iterator[None]:
    gc.unfreeze()  # what was frozen when the tests were collected
    yield
    gc.freeze()


async def test_the_collector_skips_data_that_the_running_app_has_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    async with opened(tmp_path / "ledger.db", stays=True):
        assert gc.get_freeze_count() > len(gc.get_objects())


async def test_flights_are_excluded_from_collection_only_while_no_key_is_pressed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    monkeypatch.setattr("fieldkit.tui.app.PAUSE", 0.0)
    async with opened(tmp_path / "ledger.db", stays=True) as pilot:
        await calm(pilot)
        extended: list[int] = []
        monkeypatch.setattr(PassedBy, "extend", lambda _: extended.append(1))
        await press(pilot, "t", "space", "escape")  # an edit: the flights are read again
        await press(pilot, "u")
        assert not extended
        monkeypatch.setattr("fieldkit.tui.in_order.REST", 0.0)
        await press(pilot, "U")
        assert extended


class Ring:
    """Garbage that only the collector sees."""

    def __init__(self) -> None:
        self.itself = self


def rings() -> int:
    gc.unfreeze()
    return sum(type(one) is Ring for one in gc.get_objects())


def test_skipping_permanent_data_does_not_keep_garbage_alive() -> None:
    passed_by = PassedBy()
    passed_by.extend()
    for _ in range(100):
        Ring()
    gc.collect(1)  # the remaining ones are old
    passed_by.extend()
    assert rings() == 0


def test_later_garbage_is_collected_once_there_is_much_more() -> None:
    passed_by, held = PassedBy(), [Ring() for _ in range(100)]
    passed_by.extend()
    held.clear()
    more: list[list[int]] = [[] for _ in range(gc.get_freeze_count())]
    passed_by.extend()
    assert more
    assert rings() == 0
