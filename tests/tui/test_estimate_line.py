"""The Add page while a flight is entered: Cd, alpha and the next apogee follow each readout."""

import re
from pathlib import Path

import pytest

from fieldkit.services.typed_flight import TypedFlight
from fieldkit.tui.add.estimate_line import EstimateLine
from tests.pressing import frozen, hurry, opened, press, season, text_of, typed

CHECK_SHAPES = False


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    frozen(monkeypatch)
    season(tmp_path / "ledger.db")
    return tmp_path / "ledger.db"


def figures(line: str) -> tuple[float, float]:
    """Cd and the next apogee of a line, or of intervals."""
    found = re.search(r"Cd [├─●┤≈ ]*([\d.]+) \(.*thrust .*apogee [├─●┤≈ ]*([\d.]+)", line, re.DOTALL)
    assert found, line
    return float(found[1]), float(found[2])


async def test_figures_change_with_each_typed_readout(file: Path) -> None:
    async with opened(file, (120, 40)) as pilot:
        await press(pilot, "a")
        before = figures(text_of(pilot, "#estimate"))
        await press(pilot, *typed("240m"), "enter")
        lower = figures(text_of(pilot, "#estimate"))
        await press(pilot, *typed("230mph"), "enter")
        faster = figures(text_of(pilot, "#estimate"))
    assert before != lower != faster


@pytest.mark.parametrize(("width", "bars"), [(80, 0), (160, 3)])
async def test_a_wide_screen_draws_the_intervals(file: Path, width: int, bars: int) -> None:
    async with opened(file, (width, 40)) as pilot:
        await press(pilot, "a")
        line = text_of(pilot, "#estimate")
    assert line.count("●") == bars
    assert all(figures(line))


async def test_missing_input_is_named_and_figures_appear_once_it_is_entered(file: Path) -> None:
    async with opened(file, (120, 40)) as pilot:
        await press(pilot, "a")
        page = pilot.app.screen
        mass = page.query_one("#in-dry_mass")
        page.set_focus(mass)
        await press(pilot, "ctrl+u")
        assert text_of(pilot, "#estimate") == "Next Cd and apogee: needs mass"
        await press(pilot, *typed("448"))
        assert figures(text_of(pilot, "#estimate"))


async def test_of_keys_in_a_row_only_the_last_requests_an_estimate(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    estimate = TypedFlight.estimate
    monkeypatch.setattr(TypedFlight, "estimate", lambda self, flight: asked.append(flight) or estimate(self, flight))
    async with opened(file, (120, 40)) as pilot:
        await press(pilot, "a")
        monkeypatch.setattr("fieldkit.tui.add.estimate_line.PAUSE", 0.3)
        asked.clear()
        await hurry(pilot, *"281m")
        assert [round(flight.apogee, 1) for flight in asked] == [281.0]
        assert figures(str(pilot.app.screen.query_one(EstimateLine).content))
