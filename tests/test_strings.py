"""The list of user-facing text for translators."""

import pytest

from tools.strings import ROOT, listed, strings, template_strings

pytestmark = pytest.mark.fast
CHECK_SHAPES = False


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("fieldkit/tui/screens/home.py", "No flights yet. a to add the first one"),
        ("fieldkit/cli/motors.py", "Total impulse range, in N s."),
        ("fieldkit/tui/screens/loop.py", "Accept"),
        ("models/effects/wear.py", "wear"),
        ("fieldkit/services/sites.py", "{...}: found a {...} of {...} m, expected a length above zero"),
    ],
)
def test_help_screens_and_refusals_are_listed(file: str, text: str) -> None:
    assert text in [found for _, found in strings(ROOT / file)]


def test_docstrings_types_and_style_sheets_are_not_listed() -> None:
    texts = [text for _, text in strings(ROOT / "fieldkit/tui/screens/home.py")]
    assert [text for text in texts if "{" in text and ":" in text and ";" in text] == []
    assert not any("first steps" in text and text.startswith("Home:") for text in texts)


def test_texts_of_templates_are_listed_without_tags_and_values() -> None:
    texts = [text for _, text in template_strings(ROOT / "fieldkit/presentation/report/loop/page.html")]
    assert "How to find out" in texts
    assert "Flown minus forecast apogee of each held-out flight" in texts
    assert not any("<" in text or "{{" in text or "max-width" in text for text in texts)


def test_every_line_names_its_place() -> None:
    lines = list(listed(("models",)))
    assert len(lines) > 50
    assert all(line.split(":")[1].isdigit() for line in lines)
