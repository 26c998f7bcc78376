"""Numbers on the app's pages are in the units that the user chose."""

import re
from pathlib import Path
from unittest.mock import patch

import pytest

from fieldkit.ledger import Ledger
from fieldkit.services.imports import bring_in
from tests.effort import part
from tests.pressing import at_home, looked_at, opened, press, shown, typed, words
from tests.user_units import foreign_figures

CHECK_SHAPES = False
LOG = Path(__file__).parents[2] / "sample_logs/perfectflite__drogue_and_main.pf2"

PAGES: dict[str, list[str]] = {
    "home": ["0"],
    "flights": ["1"],
    "flight": ["1", "enter"],
    "log": ["1", "enter", "l"],
    "add": ["2"],
    "import": ["3"],
    "next": ["4", "_"],
    "columns": ["4", "c", "_"],
    "plan": ["4", "p"],
    "delay": ["4", "d", "_"],
    "ballast": ["4", "g", *typed("800ft"), "enter", "_", "d", "right", "_"],
    "contest": ["4", "d", "right", "right", "_"],
    "landing": ["4", "d", *["right"] * 3, "_"],
    "effects": ["5", "_", "left", "_", "right"],
    "loop": ["5", "S", "_"],
    "setup": ["6", "_"],
}
"""Keys that open each page."""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A ledger with flights of two rockets, one of them with a log."""
    ledger_file = at_home(tmp_path, monkeypatch)
    with Ledger.open(ledger_file) as ledger:
        bring_in(ledger, [LOG], lambda name: None, defaults={"rocket": "Comet", "motor": "F24-4W", "dry_mass": 0.3})
    return ledger_file


@pytest.mark.thorough
async def test_pages_show_no_metric_figures_and_no_options_to_a_user_of_us_units(file: Path) -> None:
    found = []
    with patch("fieldkit.tui.loop.loop_page.look", lambda resources, rocket, on_progress: looked_at()):
        async with opened(file, (140, 60), page="home") as pilot:
            await press(pilot, "N")
            for page, keys in part([*PAGES.items()], 2):
                await press(pilot, *keys)
                found += [f"{page}: {line}" for line in foreign_figures(shown(pilot), "US")]
                if page in ("next", "contest", "landing"):
                    await press(pilot, "exclamation_mark", "_")
                found += [f"{page}: {line}" for line in shown(pilot).splitlines() if re.search(r"(^|[\s(])--\w", line)]
                await press(pilot, "escape", "escape", "escape")
    assert not found, "\n".join(found)


async def test_the_further_figures_of_a_plan_and_a_contest_day_are_typed_in_the_users_units(file: Path) -> None:
    async with opened(file, (80, 40), page="next_flight") as pilot:
        await press(pilot, "N", "p", *["up"], *["down"] * 15)
        assert "Parachute in Descent speed mph Drogue speed mph" in words(pilot)
        await press(pilot, *typed("18"), "down", *typed("5m/s"), "ctrl+s", "_", "p", *["down"] * 15)
        assert "Parachute 18in in Descent speed 5m/s m/s Drogue speed mph" in words(pilot)
        await press(pilot, "escape", "d", "_", "e", *["down"] * 4, *typed("26"), "ctrl+s", "_", "e")
        assert "Rocket length 26.00 in in" in words(pilot)


async def test_the_add_page_names_the_key_that_switches_units_once_no_field_takes_it(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        assert "N Units" not in words(pilot), "in a field it is a letter"
        await press(pilot, "f1")
        assert "Esc, then N, switches to feet, mph and ounces" in words(pilot)
        await press(pilot, "escape", "escape")
        assert "N Units" in words(pilot)
        await press(pilot, "N")
        assert pilot.app.resources.settings.units == "US"  # type: ignore[attr-defined]
