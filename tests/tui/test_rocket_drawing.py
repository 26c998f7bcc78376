"""A rocket is drawn to the scale of its dimensions."""

import pytest

from fieldkit.tui.setup.setup_card import caption, centers, drawing, shape

pytestmark = pytest.mark.fast

CHECK_SHAPES = False


def test_a_thicker_rocket_is_drawn_thicker_and_both_have_the_requested_width() -> None:
    slim, stout = shape(1.2, 0.04, 60), shape(0.4, 0.1, 60)
    assert slim.radius < stout.radius == pytest.approx(60 * 0.1 / 0.4 / 2)
    assert {line.cell_length for line in drawing(1.2, 0.04, 60) + drawing(0.4, 0.1, 60)} == {60}


def test_the_nose_ends_in_a_point_and_fins_are_at_the_tail() -> None:
    tail, *_, tip = shape(0.9, 0.066, 60).heights
    assert 0 < tip < shape(0.9, 0.066, 60).heights[30] < tail
    lines = drawing(0.9, 0.066, 60)
    assert len(lines) < 12
    assert [line.plain[0] for line in lines] != [line.plain[59] for line in lines]
    filled = [sum("reverse" in str(span.style) for span in line.spans) for line in lines]
    assert filled[len(lines) // 2] > 50 > filled[0], "solid along the axis, only fins at the edge"


def test_assumed_dimensions_are_reported() -> None:
    assert "a sketch" in caption(None)
    assert caption(0.9) == ""
    assert shape(None, 0.066, 60) == shape(12 * 0.066, 0.066, 60)


def test_the_center_of_pressure_of_a_stable_rocket_is_marked_behind_that_of_gravity() -> None:
    marks = centers(0.5, 0.75, 57)
    assert marks == " " * 11 + "CP ▲" + " " * 13 + "▲ CG"
    assert centers(0.75, 0.5, 57).split() == ["CG", "▲", "▲", "CP"]
    assert centers(0.5, 0.5, 57).count("▲") == 1
