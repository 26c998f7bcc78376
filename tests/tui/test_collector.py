"""No key waits while the collector looks through flights and pages that stay."""

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.pressing import frozen, opened, season


@pytest.fixture(autouse=True)
def as_it_was() -> Iterator[None]:
    yield
    gc.unfreeze()


async def test_what_an_app_that_stays_has_read_is_passed_by(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    async with opened(tmp_path / "ledger.db", stays=True):
        assert gc.get_freeze_count() > len(gc.get_objects())
