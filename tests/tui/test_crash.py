"""Unexpected errors: one line, a crash file without private data, a saved draft, and a restart in the same place."""

from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import pytest
from textual import events
from textual.geometry import Size
from textual.pilot import Pilot

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.tui import app as module
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.crash import MAX_CRASH_FILES, record
from fieldkit.tui.flights.flights_page import FlightsScreen
from fieldkit.tui.next.plan_form import PlanForm
from fieldkit.tui.widgets.table import Table
from tests.pressing import at_home, calm, hurry, opened, press, shown, typed, words

Keys = Callable[[Pilot[None]], Coroutine[Any, Any, None]]


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return at_home(tmp_path, monkeypatch)


def crash_files(file: Path) -> list[str]:
    return [one.read_text(encoding="utf-8") for one in sorted(file.parent.glob("home/crashes/*.txt"))]


def fails(*_: object) -> None:
    raise ValueError("flight 12 of Astra reached 281.3 m")


def test_a_crash_file_contains_no_private_data(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(Path(__file__).parents[2]))
    try:
        secret = "Astra"
        try:
            fails(secret)
        except ValueError as error:
            raise KeyError(secret) from error
    except KeyError as error:
        crash = record(error)
    (crash_file,) = crash_files(file)
    assert crash_file.index("ValueError") < crash_file.index("KeyError")
    assert "test_crash.py line" in crash_file
    for word in ("281.3", "reached", str(Path.home()), str(file.parent)):
        assert word not in crash_file.replace('raise ValueError("flight 12 of Astra reached 281.3 m")', "")
    assert crash.file is not None
    assert "\n" not in crash.line()


def test_only_the_newest_crash_files_are_kept(file: Path) -> None:
    for _ in range(MAX_CRASH_FILES + 3):
        record(ValueError())
    assert len(crash_files(file)) == MAX_CRASH_FILES


def test_if_no_crash_file_can_be_saved_the_line_reports_it(file: Path) -> None:
    (file.parent / "home").write_text("in the way", encoding="ascii")
    assert "no report could be saved" in record(ValueError()).line()


async def test_a_failing_key_changes_nothing_on_the_screen(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FlightsScreen, "action_sort", fails)
    async with opened(file) as pilot:
        await press(pilot, "down", "down", "s", "s")
        at = pilot.app.screen.query_one(Table).current
        assert "an error in fieldkit itself" in words(pilot)
        await press(pilot, "escape")
        assert "an error in fieldkit itself" not in words(pilot)
        assert pilot.app.screen.query_one(Table).current == at == "10"
        pilot.app.errors.clear()
    assert len(crash_files(file)) == 1  # the same place twice


async def test_failing_background_work_changes_nothing_on_the_screen(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened(file) as pilot:
        monkeypatch.setattr(pilot.app.resources.ledger.__class__, "undo", fails)
        await press(pilot, "ctrl+z", "y")
        assert "an error in fieldkit itself" in words(pilot)
        await press(pilot, "escape", "2")
        assert "Save this flight" in shown(pilot)
        pilot.app.errors.clear()
    assert len(crash_files(file)) == 1


@pytest.mark.parametrize("key", ["pagedown", "pageup", "ctrl+end", "down", "up"])
async def test_keys_pressed_before_the_palette_opens_go_to_it(file: Path, key: str) -> None:
    async with opened(file) as pilot:
        await hurry(pilot, "ctrl+p", key, key)
        await press(pilot, "escape")
        assert "12 of 12" in shown(pilot)


async def started(pilot: Pilot[None]) -> None:
    """Wait until the app shows its first page."""
    while not pilot.app.screen.query(Table):
        await pilot.pause(0.05)
    await calm(pilot)


def wider(pilot: Pilot[None]) -> None:
    """Make the terminal wider without waiting: laying out the table fails."""
    pilot.app.screen.post_message(events.Resize(Size(90, 30), Size(90, 30)))


def run_with(scripts: list[Keys], monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the app without a terminal, once for each script."""

    def without_terminal(app: FieldkitApp) -> None:
        script = scripts.pop(0)
        super(FieldkitApp, app).run(headless=True, auto_pilot=script)

    monkeypatch.setattr(FieldkitApp, "run", without_terminal)


@pytest.mark.thorough
def test_after_an_error_in_a_widget_the_app_reopens_in_the_same_place(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[str] = []
    resized = Table.on_resize

    def fails_once(*_: object) -> None:
        monkeypatch.setattr(Table, "on_resize", resized)
        fails()

    async def first(pilot: Pilot[None]) -> None:
        await started(pilot)
        await press(pilot, "2", *typed("923"), "escape", "1", "down", "down", "down")
        monkeypatch.setattr(Table, "on_resize", fails_once)
        wider(pilot)

    async def then(pilot: Pilot[None]) -> None:
        await started(pilot)
        seen.append(words(pilot))
        seen.append(pilot.app.screen.query_one(Table).current)
        await press(pilot, "escape", "2")
        seen.append(words(pilot))
        pilot.app.exit()

    run_with([first, then], monkeypatch)
    module.run(str(file))
    assert "an error in fieldkit itself, ValueError" in seen[0]
    assert seen[1] == "9"
    assert "923" in seen[2]
    assert len(crash_files(file)) == 1
    assert "Traceback" not in capsys.readouterr().err


def test_an_app_that_fails_again_and_again_gives_up_in_a_line(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def nothing(pilot: Pilot[None]) -> None:
        wider(pilot)

    scripts = [nothing] * 10
    run_with(scripts, monkeypatch)
    monkeypatch.setattr(Table, "on_resize", fails)
    with pytest.raises(FieldkitError, match="an error in fieldkit itself"):
        module.run(str(file))
    assert len(scripts) == 10 - module.MAX_RESTARTS - 1


async def test_an_app_whose_terminal_is_gone_leaves_no_crash_file(file: Path) -> None:
    """Drawing on a closed terminal is not an error in fieldkit: the app ends."""
    async with opened(file) as pilot:
        pilot.app.survive(BrokenPipeError())  # type: ignore[attr-defined]
        assert pilot.app._exit
    assert not crash_files(file)


async def test_a_form_that_closes_while_it_looks_up_a_rocket_does_not_end_the_app(file: Path) -> None:
    async with opened(file, page="next_flight") as pilot:
        await press(pilot, "p")
        form = pilot.app.screen
        assert isinstance(form, PlanForm)

        def close(plan: Flight) -> Flight:
            pilot.app.call_from_thread(form.query_one("#field-dry_mass Input").remove)
            return plan

        form.known = close
        await press(pilot, *typed("x"), "_")
        assert not form.open_fields()
        await press(pilot, "escape")
        assert not isinstance(pilot.app.screen, PlanForm)
