"""The flyer's card and the pad checklist in the app, by keys."""

from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import cast

import pytest
from textual.widgets import OptionList

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.planning.pad import CONTEST_MINUTES, LAUNCH
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.pad import waiting_checklist
from fieldkit.settings import BoxedMotors, Settings
from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.pad.pad_screen import PadScreen, PadTimer
from tests.pressing import at_home, opened, press, text_of, typed

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("fieldkit.services.manual_entry.LAPSES", timedelta.max)  # made at a frozen time in the past
    return at_home(tmp_path, monkeypatch)


NOW = datetime(2027, 5, 15, 10)


def test_the_timer_counts_down_and_past_its_end() -> None:
    timer = PadTimer()
    assert timer.text(NOW).startswith(f"timer {CONTEST_MINUTES}:00")
    timer.toggle(NOW)
    assert timer.text(NOW + timedelta(minutes=2, seconds=50)) == "42:10 left"
    assert timer.text(NOW + timedelta(minutes=46)) == "over by 1:00"
    timer.toggle(NOW)
    assert timer.ends is None


async def test_the_checklist_is_ticked_off_by_keys_and_the_timer_keeps_counting_while_it_is_closed(file: Path) -> None:
    async with opened(file, page="home") as pilot:
        await press(pilot, "K")
        screen = pilot.app.screen
        assert isinstance(screen, PadScreen)
        steps = screen.query_one(OptionList)
        assert steps.option_count >= len(LAUNCH) + 4
        await press(pilot, "space", "space", "t")
        assert [str(steps.get_option_at_index(at).prompt)[:3] for at in range(3)] == ["[x]", "[x]", "[ ]"]
        assert "left" in text_of(pilot, "#timer")
        await press(pilot, "escape", "K")
        assert "left" in text_of(pilot, "#timer")
        again = pilot.app.screen.query_one(OptionList)
        assert str(again.get_option_at_index(1).prompt).startswith("[x]")


async def test_the_checklist_is_that_of_the_waiting_plan(file: Path) -> None:
    with Ledger.open(file) as ledger:
        found = waiting_checklist(ledger, catalogue(), Settings())
        assert found.title == "any flight"
        plan = Flight(rocket="Astra", config="A", motor="F24-4W", dry_mass=0.322, diameter=0.066)
        predict_plans(ledger, catalogue(), [plan], save="plan")
        found = waiting_checklist(ledger, catalogue(), Settings())
    assert "Astra A on" in found.title
    assert any("motor F24-4W of AeroTech" in step for step in found.steps)
    mass = 322 + 1e3 * catalogue().resolve("F24-4W").motor.loaded_mass
    assert any(f"{mass:.0f} g are planned" in step for step in found.steps)


async def test_the_card_is_changed_in_the_app(file: Path) -> None:
    async with opened(file, page="setup") as pilot:
        pilot.app.screen.action_kind(4)  # type: ignore[attr-defined]
        await press(pilot, "down", "down", "down", "down", "enter")
        await press(pilot, "1", "down", *"2009", "down", "down", *"3ft", "down", *typed("3 x C6-5"), "ctrl+s")
        card = cast(FieldkitApp, pilot.app).resources.settings.flyer
    assert (card.certification, card.born) == (1, "2009")
    assert card.rails == pytest.approx((0.9144,))
    (boxed,) = card.box
    assert (replace(boxed, counted=""), bool(boxed.counted)) == (BoxedMotors("C6-5", 3), True)
