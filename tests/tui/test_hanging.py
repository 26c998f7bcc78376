"""Long lines are wrapped within their column, and nothing is lost."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual.css.styles import Styles
from textual.style import Style
from textual.visual import RenderOptions

from fieldkit.safe_text import printable
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import Hanging, hanging, stacked

pytestmark = pytest.mark.fast

WIDTH = 40


def drawn(block: Hanging, width: int = WIDTH) -> list[str]:
    options = RenderOptions(lambda _: Style(), Styles())
    strips = block.render_strips(width, None, Style(), options)
    assert len(strips) == block.get_height(Styles(), width)
    return [strip.text.rstrip() for strip in strips]


def test_a_wrapped_value_continues_below_its_beginning() -> None:
    card = cards.lines("Air", [("air", "1.2 kg/m³ at the pad, as it is on a standard day")], 6)
    assert drawn(card) == ["Air", "air     1.2 kg/m³ at the pad, as it is", "        on a standard day"]


def test_a_wrapped_line_is_indented_to_its_name_its_spaces_or_slightly_right() -> None:
    words = "what runs on and on until it has to be broken"
    named, blank, bare = (drawn(hanging([lead + words]))[1] for lead in ("  air    ", "    ", ""))
    assert [len(line) - len(line.lstrip()) for line in (named, blank, bare)] == [9, 4, 2]


def test_an_address_longer_than_its_line_begins_beside_its_name_and_breaks_after_a_slash() -> None:
    card = cards.lines("", [("page", "http://nar.example/SandT/pdf/Estes/half_A3T.pdf")])
    assert drawn(card) == ["page  http://nar.example/SandT/pdf/", "      Estes/half_A3T.pdf"]


def test_a_narrow_column_is_not_wasted_on_spaces() -> None:
    card = cards.lines("", [("Average acceleration", "a figure of which there is much to say")], 20)
    assert drawn(card, 30)[1].startswith("  ")
    assert not drawn(card, 30)[1].startswith("   ")


def test_blocks_are_separate() -> None:
    assert drawn(stacked([hanging(["one"]), hanging(["two"])])) == ["one", "", "two"]


@given(st.text(), st.integers(8, 60))
def test_no_letter_is_lost_or_outside_of_the_column(text: str, width: int) -> None:
    letters = "".join("".join(drawn(hanging([text]), width)).split())
    assert letters == "".join(printable(text).split())
