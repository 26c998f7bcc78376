"""Saving an unedited form changes nothing, although it shows rounded numbers; a refused text can be edited."""

from pathlib import Path

import pytest
from textual.widgets import Input, Label

from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.planning.contest_day import Day
from fieldkit.services.contest_day import day_of, keep_day
from fieldkit.services.sites import site_of
from fieldkit.settings import change_settings
from fieldkit.tui.add.fields import Field, Form
from fieldkit.tui.widgets.dialogs import AskText, HelpScreen
from tests.pressing import at_home, opened, press, typed, words

CHECK_SHAPES = False
SIX_FEET, CONTEST_TARGET = 1.8288, 239.268
"""A rail of 6 ft and a target of 785 ft, neither of them a number with one decimal in meters. [m]"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return at_home(tmp_path, monkeypatch)


async def test_the_usual_rail_and_the_target_keep_their_exact_lengths(file: Path) -> None:
    change_settings({"rail_length": SIX_FEET, "target": CONTEST_TARGET}, file.with_name("settings.json"))
    async with opened(file, page="setup") as pilot:
        await press(pilot, "left", "down", "down", "enter")
        assert "239.3 m" in words(pilot)
        await press(pilot, "enter", "down", "enter")
        assert "1.8 m" in words(pilot)
        await press(pilot, "ctrl+s")
        settings = pilot.app.resources.settings  # type: ignore[attr-defined]
        assert (settings.rail_length, settings.target) == (SIX_FEET, CONTEST_TARGET)
        await press(pilot, "enter", "enter", *typed("5"), "ctrl+s")
        settings = pilot.app.resources.settings  # type: ignore[attr-defined]
        assert (settings.rail_length, settings.rail_angle) == (SIX_FEET, pytest.approx(0.0873, abs=1e-4))


@pytest.mark.thorough
async def test_the_contest_day_and_its_field_keep_their_exact_lengths(file: Path) -> None:
    day, site = Day(target=CONTEST_TARGET), Site("North field", size=400.05, ceiling=914.4)
    with Ledger.open(file) as ledger:
        keep_day(ledger, 2027, day)
        keep_day(ledger, 2027, site=site)
        site = site_of(ledger, "North field")
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "d", "e", "ctrl+s", "_")
        with Ledger.open(file) as ledger:
            assert (day_of(ledger, 2027), site_of(ledger, "North field")) == (day, site)
        await press(pilot, "e", "enter", "enter", *typed("60"), "ctrl+s", "_")
    with Ledger.open(file) as ledger:
        assert day_of(ledger, 2027) == Day(target=CONTEST_TARGET, cut=60.0)


@pytest.mark.parametrize(
    ("page", "keys", "text", "error"),
    [
        ("next_flight", "g", "800ftt", "found the unit 'ftt', expected one of"),
        ("import_files", "F", "zzz", "expected one of"),
        ("import_files", "o", "/no/such", "no such file or folder"),
        ("flights", "w", ".txt", "expected a name that ends in .html"),
    ],
)
async def test_a_prompt_keeps_a_text_that_cannot_be_used_with_the_error_below_it(
    file: Path, page: str, keys: str, text: str, error: str
) -> None:
    async with opened(file, page=page) as pilot:
        await press(pilot, keys, "end", *typed(text), "enter")
        assert isinstance(pilot.app.screen, AskText)
        assert pilot.app.screen.query_one(Input).value.endswith(text)
        assert error in words(pilot)
        await press(pilot, "backspace")
        assert error not in words(pilot)
        await press(pilot, "escape")
        assert not isinstance(pilot.app.screen, AskText)


async def test_a_form_names_the_key_of_its_help_which_explains_every_field(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, "e")
        assert "F1 Help" in words(pilot)
        titles = [str(field.query_one(Label).content) for field in pilot.app.screen.query(Field)]
        await press(pilot, "f1")
        assert isinstance(pilot.app.screen, HelpScreen)
        assert titles
        for title in titles:
            assert title in words(pilot)
        await press(pilot, "escape", "escape")
        assert not isinstance(pilot.app.screen, Form | HelpScreen)
