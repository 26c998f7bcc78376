"""Numbers on the app's pages are in the units that the user chose."""

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
async def test_pages_show_no_metric_figures_to_a_user_of_us_units(file: Path) -> None:
    found = []
    with patch("fieldkit.tui.loop.loop_page.look", lambda resources, rocket, on_progress: looked_at()):
        async with opened(file, (140, 60), page="home") as pilot:
            await press(pilot, "N")
            for page, keys in part([*PAGES.items()], 2):
                await press(pilot, *keys)
                found += [f"{page}: {line}" for line in foreign_figures(shown(pilot), "US")]
                await press(pilot, "escape", "escape", "escape")
    assert not found, "\n".join(found)


async def test_the_add_page_names_the_key_that_switches_units_once_no_field_takes_it(file: Path) -> None:
    async with opened(file, page="add") as pilot:
        assert "N Units" not in words(pilot), "in a field it is a letter"
        await press(pilot, "f1")
        assert "Esc, then N, switches to feet, mph and ounces" in words(pilot)
        await press(pilot, "escape", "escape")
        assert "N Units" in words(pilot)
        await press(pilot, "N")
        assert pilot.app.resources.settings.units == "US"  # type: ignore[attr-defined]
