"""Three flyers from their kit to the result in the app, by keys alone at 80x24: a kit that never flew, a contest
season, a certification flight."""

from datetime import timedelta
from pathlib import Path

import pytest
from textual.pilot import Pilot

from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services.saved_forecasts import list_forecasts
from tests.pressing import opened, press, text_of, typed, words

CHECK_SHAPES = False
pytestmark = pytest.mark.thorough


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A ledger without flights, in a folder of its own."""
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    monkeypatch.setattr("fieldkit.services.manual_entry.LAPSES", timedelta.max)
    folder = tmp_path / "field"
    folder.mkdir()
    monkeypatch.chdir(folder)
    (tmp_path / "home").mkdir()
    return tmp_path / "home" / "ledger.db"


async def fill(pilot: Pilot[None], **answers: str) -> None:
    """Go to fields of a form by ↓, and type their answers."""
    for name, text in answers.items():
        for _ in range(60):
            if pilot.app.focused is not None and pilot.app.focused.id == f"in-{name}":
                break
            await press(pilot, "down")
        else:
            raise AssertionError(f"no field {name}")
        await press(pilot, "ctrl+u", *typed(text))


async def card(pilot: Pilot[None], **answers: str) -> None:
    """Fill in the flyer's card, opened by the palette."""
    await press(pilot, "ctrl+p", "_", *typed("your card"), "_", "_", "enter", "_")
    await fill(pilot, **answers)
    await press(pilot, "ctrl+s", "_")


async def checks(pilot: Pilot[None]) -> str:
    """All safety checks of the landing of the motor under the cursor, in full; the Decide screen stays open."""
    await press(pilot, "d", *["right"] * 3, "_", "exclamation_mark", "_")
    return text_of(pilot, "#beside")


async def first_rocket(pilot: Pilot[None], name: str, motor: str, mass: str = "", diameter: str = "") -> None:
    """Describe a rocket with the first of the first steps."""
    assert "Describe your rocket" in words(pilot)
    await press(pilot, "enter", "_")
    await fill(pilot, rocket=name, dry_mass=mass, diameter=diameter, motor=motor)
    await press(pilot, "ctrl+s", "_", "_")


async def test_a_kit_that_never_flew(empty: Path) -> None:
    async with opened(empty, page="setup") as pilot:
        await press(pilot, "left", "left", "i")
        await press(pilot, *typed("Big Bertha"), "down", *typed("80g"), "down", *typed("42mm"), "enter", *typed("18"))
        await press(pilot, "ctrl+s", "_")
        await card(pilot, certification="none", born="2012", rails="3ft", box="3 x C6-5")
        await press(pilot, "0", "_")
        await first_rocket(pilot, "Big Bertha", "C6-5")
        await press(pilot, "f", "_", "B", "_")
        assert "80 g dry" in words(pilot)
        assert "your box" in text_of(pilot, "#count")
        assert "not flown: check it before flight" in await checks(pilot)
        await press(pilot, "escape", "_", "p")
        await fill(pilot, wind="5mph", stability_cal="1.6", parachute_diameter_mm="18in")
        await press(pilot, "ctrl+s", "_")
        assert "stability: ok" in await checks(pilot)
        await press(pilot, "w", "enter", "_", "escape", "_")
        assert Path("range_safety_sheet.pdf").exists()
        assert "by delay 5:" in text_of(pilot, "#more"), "the delay in the box"
        await press(pilot, "enter", "_")  # saves the forecast
        await press(pilot, "0", "_", "K", "_", "space", "t", "escape", "a", "_")
        await fill(pilot, apogee="420ft", duration="30s")
        await press(pilot, "ctrl+s", "_", "_")
        assert "Big Bertha" in words(pilot)
        assert "Taken from your range box: 1 x C6-5, 2 left." in words(pilot)
        await press(pilot, "4", "_", "_")
        assert "2 × C6" in words(pilot)
    with Ledger.open(empty) as ledger:
        (flight,) = ledger.flights("Big Bertha")
        states = [one.state for one in list_forecasts(ledger, catalogue(), "Big Bertha")]
    assert (flight.motor, flight.dry_mass) == ("Estes C6-5", 0.08)
    assert flight.apogee == pytest.approx(128.016)
    assert states[-1] == "flown", states


async def test_a_contest_season(empty: Path) -> None:
    async with opened(empty, page="home") as pilot:
        await first_rocket(pilot, "Team", "F39T-6", "520g", "66mm")
        await press(pilot, "f", "_", "d", "left", "left", "_")
        steps = text_of(pilot, "#answer")
        assert "a to add it, with its duration" in steps
        assert "w to write it" in steps
        assert "`fieldkit" not in steps
        for apogee, seconds in ((760, 41), (790, 39.5), (805, 38.6)):
            await press(pilot, "escape", "a", "_")
            await fill(pilot, apogee=f"{apogee}ft", timer_1_s=f"{seconds}", timer_2_s=f"{seconds}", eggs="intact")
            await press(pilot, "ctrl+s", "_", "_")
        await press(pilot, "escape", "f", "_", "d", "left", "left", "_", "e")
        await fill(pilot, cut="60", declared="2,3")
        await press(pilot, "ctrl+s", "_", "_")
        steps = text_of(pilot, "#answer")
        assert "2 of 3 declared, 1 left" in steps
        assert "chance of a score up to 60" in steps
        await press(pilot, "w", "enter", "_")
        assert Path("finals_card.pdf").read_bytes().startswith(b"%PDF")


async def test_a_certification_flight(empty: Path) -> None:
    async with opened(empty, page="home") as pilot:
        await card(pilot, certification="none", born="1990", rails="6ft", box="1 x H128W-14A")
        await first_rocket(pilot, "Level One", "H128W-14A", "1.4kg", "102mm")
        await press(pilot, "f", "_", "p")
        await fill(pilot, wind="3mph", stability_cal="2", parachute_diameter_mm="45in")
        await press(pilot, "ctrl+s", "_", "B", "_")
        seen = await checks(pilot)
        assert "only as a certification flight, with its witnesses" in seen
        assert "stability: ok" in seen
        assert "ejection speed: unsafe" in seen, "at the longest delay, which is on the bag"
        await press(pilot, "left", "left", "left", "_")
        assert "6 s, drilled" in text_of(pilot, "#answer")
        await press(pilot, "escape", "_", "p")
        await fill(pilot, delay="6")
        await press(pilot, "ctrl+s", "_", "_")
        assert "delay 6 s" in words(pilot)
        seen = await checks(pilot)
        assert "landing speed: ok" in seen
        assert "ejection speed: unsafe" not in seen
        await press(pilot, "w", "enter", "_", "escape", "_", "enter", "_", "a", "_")
        assert Path("range_safety_sheet.pdf").exists()
        await fill(pilot, apogee="980ft", duration="60s")
        await press(pilot, "ctrl+s", "_", "_")
        await card(pilot, certification="1")
        await press(pilot, "escape", "f", "_", "B", "_", "slash", *typed("i284w"), "enter", "_")
        seen = await checks(pilot)
        assert "certification: ok" in seen
