"""Every screen of the app explains itself."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from sys import modules
from textwrap import wrap
from typing import Any

import pytest
from textual.app import App
from textual.pilot import Pilot
from textual.screen import Screen
from textual.widgets import Input

from fieldkit import tui
from fieldkit.importing.manual_entry import QUESTIONS
from fieldkit.services.imports.mappings import TableColumns
from fieldkit.services.pad import Checklist
from fieldkit.tui.add.fields import Form
from fieldkit.tui.asking import AskingScreen
from fieldkit.tui.flights import flights_help
from fieldkit.tui.flights.log_view import LogLook, LogView
from fieldkit.tui.imports import import_help
from fieldkit.tui.imports.given_form import QUESTIONS as LACKED
from fieldkit.tui.imports.given_form import SetupForm
from fieldkit.tui.imports.mapping_form import MappingForm, MappingList
from fieldkit.tui.pad.pad_screen import PadScreen, PadTimer
from fieldkit.tui.page import PageScreen, pages
from fieldkit.tui.palette import Palette
from fieldkit.tui.widgets.dialogs import AskText, AskYes, HelpedModal, HelpScreen
from fieldkit.tui.widgets.hanging import stacked
from fieldkit.tui.widgets.table import Table
from tests.pressing import at_home, calm, opened, press

CHECK_SHAPES = False

HELP_WIDTH = 68
"""Width of a line of help at 80 columns. [cell]"""
OTHER_HELP = ((flights_help, "LOG_HELP"), (import_help, "MAPPINGS_HELP"))
"""Helps of screens that are no page."""
BASES = {AskingScreen, PageScreen, HelpedModal}
"""Screens that are only inherited from."""
TABLE = TableColumns("samples", ("Time [s]", "Alt [ft]"), ("0.0", "3"), {"time": "Time [s]"})
MODALS: dict[type[Screen[Any]], Callable[[App[None]], Screen[Any]]] = {
    AskText: lambda app: AskText("Target", "250 m", "Target apogee."),
    AskYes: lambda app: AskYes("Delete the kit?"),
    Form: lambda app: Form("A flight", QUESTIONS, {}, {}),
    LogView: lambda app: LogView([LogLook("a log", stacked([]), None)], "SI"),
    MappingForm: lambda app: MappingForm(TABLE),
    MappingList: lambda app: MappingList(str),
    PadScreen: lambda app: PadScreen(Checklist("any flight", ("weighed",)), "SI", PadTimer()),
    Palette: lambda app: Palette(),
    SetupForm: lambda app: SetupForm("A log", LACKED, {one.name: "" for one in LACKED}, {}),
}
ABOVE_PAGES = {
    "FlightScreen": ("1", "_", "enter"),
    "TagScreen": ("1", "_", "t"),
    "PlanForm": ("4", "_", "p"),
    "PlanScreen": ("4", "_", "d"),
}
"""Keys that open a screen over a page."""
EDITING = {binding.description for binding in Input.BINDINGS}
"""What Textual says of the keys with which text is edited."""


def screens() -> set[type[Screen[Any]]]:
    """Every screen that the app defines."""
    for module in walk_packages(tui.__path__, f"{tui.__name__}."):
        import_module(module.name)
    own = {name for name in modules if name.startswith(f"{tui.__name__}.")}
    return {one for one in _below(Screen) if one.__module__ in own} - BASES


def _below(screen: type[Screen[Any]]) -> set[type[Screen[Any]]]:
    return {screen, *(one for child in screen.__subclasses__() for one in _below(child))}


def explained(pilot: Pilot[None]) -> HelpScreen:
    """The help in front, which has a purpose and no key that only edits text."""
    help = pilot.app.screen
    assert isinstance(help, HelpScreen)
    assert len(help._help.about.split()) > 5
    assert EDITING & {text for _, text in help._key_list} == set()
    return help


def test_every_screen_is_walked() -> None:
    walked = {*MODALS, *(page.screen for page in pages().values()), HelpScreen}
    assert {one.__name__ for one in screens() - walked} == set(ABOVE_PAGES)


async def test_f1_explains_every_page_and_closes_its_help(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async with opened(at_home(tmp_path, monkeypatch)) as pilot:
        for page in pages().values():
            await press(pilot, "escape", str(page.number), "_", "f1")
            title = pilot.app.screen_stack[-2]
            assert isinstance(title, page.screen)
            assert explained(pilot)._title == f"Help: {title.TITLE}"
            if isinstance(table := title.focused, Table) and table.enter:
                assert ("Enter", title.ON_ENTER[1]) in explained(pilot)._key_list, "as the line of keys says"
            await press(pilot, "f1")
            assert pilot.app.screen is title


@pytest.mark.parametrize("name", ABOVE_PAGES)
async def test_f1_explains_every_screen_over_a_page(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async with opened(at_home(tmp_path, monkeypatch)) as pilot:
        await press(pilot, *ABOVE_PAGES[name], "_")
        assert type(pilot.app.screen).__name__ == name
        await press(pilot, "f1")
        explained(pilot)


async def test_f1_explains_every_dialog(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async with opened(at_home(tmp_path, monkeypatch)) as pilot:
        for screen, made in MODALS.items():
            pilot.app.push_screen(made(pilot.app))
            await calm(pilot)
            assert type(pilot.app.screen) is screen
            await press(pilot, "f1")
            explained(pilot)
            await press(pilot, "escape", "escape")
            assert not isinstance(pilot.app.screen, screen), screen


async def test_the_help_of_a_form_lists_its_keys_once_and_as_printed_on_a_keyboard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened(at_home(tmp_path, monkeypatch)) as pilot:
        await press(pilot, "2", "_", "f1")
        keys = {text: key for key, text in explained(pilot)._key_list}
        assert keys["Clear the field, left of the cursor"] == "^U"
        assert keys["Next part of the page"] == "Tab"
        assert keys["Quit"] == "^Q"
        assert len(keys) < 16


def test_every_help_begins_with_few_lines() -> None:
    abouts = [screen.ABOUT for screen in screens() if issubclass(screen, PageScreen)]
    abouts += [getattr(module, name) for module, name in OTHER_HELP]
    assert len(abouts) > 10
    assert [about for about in abouts if len(wrap(about.about, HELP_WIDTH)) > 4] == []
