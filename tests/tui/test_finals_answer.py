"""The table of finals on the Decide screen, in the window of the day."""

from pathlib import Path

import pytest
from textual.widgets import Static

from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.planning.contest_day import Day
from fieldkit.services.contest_day import keep_day
from tests.pressing import at_home, opened, press, text_of, typed

CHECK_SHAPES = False


@pytest.mark.thorough
async def test_finals_have_a_table_for_each_target(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = at_home(tmp_path, monkeypatch)
    with Ledger.open(file) as ledger:
        assert keep_day(ledger, 2027, Day(window=(41.0, 44.0)))
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "left", "exclamation_mark")
        shown = str(pilot.app.screen.query_one("#answer", Static).content)
        checks = text_of(pilot, "#under")
        assert "Points of a flight by the target [m], fewer are better" in text_of(pilot, "#title")
        assert pilot.app.screen.query_one("#first").display
    assert "window 41 to 44 s" in shown
    assert "never 800" in shown
    assert "field size: unknown" in checks
    assert "contest mass: ok" in checks
    rows = [line.split() for line in shown.splitlines() if line.strip()[:3].isdecimal() and len(line.split()) == 8]
    assert [row[0] for row in rows] == [str(feet) for feet in range(775, 826, 5) if feet != 800]
    masses = [float(row[1]) for row in rows]
    assert masses == sorted(masses, reverse=True)
    loaded = catalogue().resolve("AeroTech F39T").motor.loaded_mass * 1e3
    assert all(abs(float(row[3]) - float(row[1]) - loaded) < 1 for row in rows)


@pytest.mark.thorough
async def test_a_season_has_its_steps_with_the_declared_flights(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = at_home(tmp_path, monkeypatch)
    with Ledger.open(file) as ledger:
        assert keep_day(ledger, 2027, Day(cut=60.0, declared=("1",)))
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "slash", *typed("aerotech f39"), "enter", "_", "d", "left", "left")
        shown = str(pilot.app.screen.query_one("#answer", Static).content)
        assert "Score at the end of qualification, as in step 6" in text_of(pilot, "#title")
    steps = [line for line in shown.splitlines() if line[:1].isdecimal()]
    assert len(steps) == 7
    assert steps[5].startswith("6. qualification: 1 of 3 declared")
    assert "chance of a score up to 60" in shown
    assert "± " in shown.partition("mass and parachute together")[2]
