"""The Capture page before a capture shows what to do, earlier captures and known loggers."""

from pathlib import Path

import pytest

from fieldkit.paths import capture_folder
from tests.pressing import at_home, opened, press, shown

pytestmark = pytest.mark.fast


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("fieldkit.capture.ports", list)
    return at_home(tmp_path, monkeypatch)


async def test_earlier_captures_and_known_loggers_are_listed(file: Path) -> None:
    folder = capture_folder()
    folder.mkdir(parents=True)
    (folder / "2026-05-01.raw").write_bytes(b"some bytes")
    (folder / "2026-05-01.jsonl").write_text("")
    async with opened(file, (120, 36), page="serial") as pilot:
        text = shown(pilot)
        assert "2026-05-01.raw" in text
        assert "10 bytes," in text
        assert "INCOMPLETE" in text
        assert "Eggtimer" in text
        assert "Plug in" in text


async def test_a_capture_takes_the_place_of_the_steps(file: Path) -> None:
    async with opened(file, page="serial") as pilot:
        assert pilot.app.screen.query_one("#ready").display
        await press(pilot, "C")  # though there is no capture to continue
        assert not pilot.app.screen.query_one("#ready").display
