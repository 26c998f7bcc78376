"""What is decided for a motor on the page Next: delay, ballast and contest points, by keys, with every safety line."""

from pathlib import Path

import pytest

from tests.pressing import frozen, opened, press, season, told, typed, words

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    frozen(monkeypatch)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))
    season(tmp_path / "ledger.db")
    return tmp_path / "ledger.db"


async def test_delay_ballast_and_contest_of_a_motor_by_keys(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "4", "slash", *typed("aerotech f39"), "enter", "_", "d")
        assert "Astra B on AeroTech F39T: coasts" in told(pilot, "#answer")
        assert "field size: unknown" in told(pilot, "#answer")
        await press(pilot, "right")
        assert "No target yet" in told(pilot, "#answer")
        await press(pilot, "right")
        assert "season 2027" in words(pilot)
        assert "calibrated on 1 flight" in told(pilot, "#answer")
        assert "contest mass: ok" in told(pilot, "#answer")
        await press(pilot, "comma")
        assert "season 2026" in words(pilot)
        await press(pilot, "escape", "g", *typed("800ft"), "enter", "d", "right")
        assert "target 244 m (800 ft)" in told(pilot, "#answer")
        assert "the range safety officer decides" in told(pilot, "#answer")


async def test_safety_stands_on_the_page_next_whatever_its_size(file: Path) -> None:
    async with opened(file) as pilot:
        await press(pilot, "4", "slash", *typed("f24"), "enter")
        seen = words(pilot)
        for name in ("rail exit speed", "ejection speed", "ground wind", "ceiling", "thrust to weight", "class"):
            assert name in seen
        await press(pilot, "p", *["down"] * 12, *typed("warm"), "ctrl+s")
        assert "motor_temperature_c: found 'warm'" in words(pilot)
