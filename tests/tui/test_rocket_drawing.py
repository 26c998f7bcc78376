"""A rocket is drawn to the scale of its dimensions."""

import pytest

from fieldkit.tui.setup.setup_card import caption, centers, drawing

pytestmark = pytest.mark.fast

CHECK_SHAPES = False


def body(lines: list[str], place: int) -> int:
    """Number of filled half cells at a distance from the tail."""
    column = [line.ljust(80)[place] for line in lines]
    return sum({"█": 2, " ": 0}.get(cell, 1) for cell in column)


def test_a_thicker_rocket_is_drawn_thicker_and_both_have_the_requested_width() -> None:
    slim, stout = drawing(1.2, 0.04, 60), drawing(0.4, 0.1, 60)
    assert max(map(len, slim)) == max(map(len, stout)) == 60
    assert body(stout, 30) > body(slim, 30) > 0
    assert body(stout, 30) == pytest.approx(60 * 0.1 / 0.4, abs=2)


def test_the_nose_ends_in_a_point_and_fins_are_at_the_tail() -> None:
    lines = drawing(0.9, 0.066, 60)
    assert 0 < body(lines, 59) <= body(lines, 30) < body(lines, 0)
    assert len(lines) < 12


def test_assumed_dimensions_are_reported() -> None:
    assert "a sketch" in caption(None)
    assert caption(0.9) == ""
    assert drawing(None, 0.066, 60) == drawing(12 * 0.066, 0.066, 60)


def test_the_center_of_pressure_of_a_stable_rocket_is_marked_behind_that_of_gravity() -> None:
    marks = centers(0.5, 0.75, 57)
    assert marks == " " * 11 + "CP ▲" + " " * 13 + "▲ CG"
    assert centers(0.75, 0.5, 57).split() == ["CG", "▲", "▲", "CP"]
    assert centers(0.5, 0.5, 57).count("▲") == 1
