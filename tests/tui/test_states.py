"""States of figures: a symbol shows them, and a color of the theme repeats it."""

from pathlib import Path

import numpy as np
import pytest
from rich.color import Color
from rich.style import Style

from fieldkit.settings import change_settings
from fieldkit.tui.next.intervals import IntervalBar, Intervals
from fieldkit.tui.themes import THEMES
from fieldkit.tui.widgets.plots import Ink, Marked, draw_density
from fieldkit.tui.widgets.states import BAD_COLOR, CAUTION_COLOR, GOOD_COLOR, MARK_COLOR, STATES, runs
from fieldkit.tui.widgets.table import Table
from tests.pressing import at_home, opened, press, shown, typed


@pytest.mark.parametrize(
    ("cell", "states"),
    [
        ("   ≈251", [CAUTION_COLOR]),
        ("✗ Estes C6", [BAD_COLOR]),
        ("◎-1.8", [GOOD_COLOR]),
        ("+11.7", []),
        (" ├──●─◆┤ ", [GOOD_COLOR]),
        (" ├──●──┤ ◆ ", [CAUTION_COLOR]),
        (" ├─◎●──┤ ", [GOOD_COLOR]),
        (" ├──◉──┤ ", [GOOD_COLOR]),
        (" ├──●──┤ ◎ ", [MARK_COLOR]),
        ("   ◆  ◎ ", [MARK_COLOR, MARK_COLOR]),
        ("◎──●──┤", [MARK_COLOR]),
        ("", []),
    ],
)
def test_a_cell_has_the_color_of_the_state_that_its_symbol_shows(cell: str, states: list[str]) -> None:
    parts = list(runs(cell, aims=True))
    assert "".join(text for text, _ in parts) == cell
    assert [color for text, color in parts if color and text.strip()] == states


def test_a_mark_that_is_no_target_has_the_color_of_marks() -> None:
    assert [color for text, color in runs(" ├─◎●──┤ ") if color] == [MARK_COLOR]


def test_a_flight_outside_its_interval_is_colored_so_in_a_list_of_intervals() -> None:
    rows = (IntervalBar("a", 1.0, 2.0, 3.0, 2.5), IntervalBar("b", 1.0, 2.0, 3.0, 5.0))
    drawn = Intervals(rows, lambda x: f"{x:g}", {})._within(60)
    colors = [str(span.style) for span in drawn.spans if "◆" in drawn.plain[span.start : span.end]]
    assert colors == [f"${GOOD_COLOR}", f"${CAUTION_COLOR}"]


@pytest.mark.parametrize("theme", list(THEMES))
def test_every_theme_has_the_colors_of_states(theme: str) -> None:
    named = THEMES[theme].to_color_system().generate()
    for color in {*STATES.values(), MARK_COLOR}:
        assert named[color]
    if theme in ("field", "terminal"):
        assert len({named[color] for color in (GOOD_COLOR, CAUTION_COLOR, BAD_COLOR)}) == 3


async def test_states_are_colored_in_a_table_and_not_under_its_cursor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = at_home(tmp_path, monkeypatch)
    async with opened(file, (120, 36), page="next_flight") as pilot:
        await press(pilot, "slash", *typed("e"), "enter", "_")
        table = pilot.app.screen.query_one(Table)
        strips = [table.render_line(y) for y in range(1, 20)]
        caution = Color.parse(pilot.app.theme_variables["warning"])
        inks = [{segment.style.color for segment in strip if segment.style} for strip in strips]
        assert "≈" in shown(pilot)
        assert any(caution in ink for ink in inks)
        cursor = table.cursor + 1 - round(table.scroll_y)
        assert len({segment.style.color for segment in table.render_line(cursor) if segment.style}) == 1


INK = Ink(80, 12, (20, 28, 37), (238, 243, 248), (143, 208, 255), (255, 198, 109), (74, 93, 112))


def test_a_density_is_filled_within_its_90_percent_and_marked_on_the_curve() -> None:
    draws = np.random.default_rng(1).normal(250.0, 20.0, 4000)
    *drawn, axis, _ = draw_density(draws, lambda x: f"{x:g}", Marked("◎", 244.0), former=draws + 30)(None, INK).split()
    assert len(drawn) == INK.height - 2
    low, high = np.quantile(draws, [0.05, 0.95])
    first, last = draws.min(), draws.max() + 30
    filled = [span for span in drawn[-1].spans if isinstance(span.style, Style) and span.style.reverse]
    width = (max(span.end for span in filled) - min(span.start for span in filled)) / INK.width
    assert width == pytest.approx((high - low) / (last - first), abs=0.1)
    assert all(line.plain.count("│") == 1 for line in drawn[-8:]), "the median, unbroken"
    (marked,) = [n for n, line in enumerate(drawn) if "◎" in line.plain]
    assert marked <= 2, "on the curve"
    dots = [column for line in drawn for column, sign in enumerate(line.plain) if sign > "⠀"]
    assert max(dots) - min(dots) > 60, "tails, and the former forecast"
    assert "┬" in axis.plain


def test_values_below_a_density_are_round_in_the_unit_that_is_shown() -> None:
    draws = np.random.default_rng(1).normal(250.0, 20.0, 4000)
    drawing = draw_density(draws, lambda x: f"{x / 0.3048:.0f}", unit=0.3048)(None, INK)
    labels = drawing.plain.splitlines()[-1].split()
    assert len(labels) > 2
    assert all(float(label) % 50 == 0 for label in labels)


@pytest.mark.parametrize("theme", THEMES)
async def test_selected_text_in_a_field_stands_out_in_every_theme(
    theme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = at_home(tmp_path, monkeypatch)
    change_settings({"theme": theme}, file.with_name("settings.json"))
    async with opened(file) as pilot:
        await press(pilot, "e", "down")
        styles = {
            segment.text.strip(): segment.style
            for strip in pilot.app.screen._compositor.render_strips()
            for segment in strip
        }
        assert styles["B"] != styles["Astra"], "its text is selected on focus"
