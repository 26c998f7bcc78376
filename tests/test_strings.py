"""The list of user-facing text for translators."""

import re
from pathlib import Path

import pytest
from typer.core import TyperGroup
from typer.main import get_command

from fieldkit.cli.main import app
from tests.vocabulary import known_words, unlisted
from tools.strings import ROOT, catalog, listed, strings, template_strings

pytestmark = pytest.mark.fast
CHECK_SHAPES = False
SHOWN = re.compile(r"<text[^>]*>([^<]*)</text>")
"""A text in the picture of a page."""


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("fieldkit/tui/home/home_page.py", "No flights yet. a to add the first one"),
        ("fieldkit/cli/motors.py", "Highest total impulse of a motor, in N s."),
        ("fieldkit/tui/loop/loop_page.py", "Accept"),
        ("models/effects/wear.py", "wear"),
        ("fieldkit/services/sites.py", "{...}, {...}: found {...}, expected {...}"),
    ],
)
def test_help_screens_and_refusals_are_listed(file: str, text: str) -> None:
    assert text in [found for _, found in strings(ROOT / file)]


def test_the_help_of_every_command_is_listed_and_no_other_docstring() -> None:
    texts = {text for file in (ROOT / "fieldkit/cli").glob("*.py") for _, text in strings(file)}
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    assert [name for name, one in group.commands.items() if " ".join((one.help or "").split()) not in texts] == []
    assert "Rockets of the ledger." not in texts


def test_docstrings_types_and_style_sheets_are_not_listed() -> None:
    texts = [text for _, text in strings(ROOT / "fieldkit/tui/home/home_page.py")]
    assert [text for text in texts if "{" in text and ":" in text and ";" in text] == []
    assert not any("first steps" in text and text.startswith("Home:") for text in texts)


def test_texts_of_templates_are_listed_without_tags_and_values() -> None:
    texts = [text for _, text in template_strings(ROOT / "fieldkit/presentation/report/loop/page.html")]
    assert "How to find out" in texts
    assert "Flown minus forecast apogee of each held-out flight" in texts
    assert not any("<" in text or "{{" in text or "max-width" in text for text in texts)


def test_every_line_names_its_file_and_line() -> None:
    lines = list(listed(("models",)))
    assert len(lines) > 50
    assert all(line.split(":")[1].isdigit() for line in lines)


DATA = """
    afbb cato cats comet decoded designs fault http lightning oog reloadable sandt sirius sketch tsp
"""
"""Other words on the pages in the pictures: rockets, tags, a web page, motors, loggers and their lines, kinds of
files."""
OF_TEXTUAL = "focus selected super"
"""Words of keys that the library itself binds and describes."""


def test_the_pictures_of_pages_show_no_word_that_a_translator_would_miss() -> None:
    """Words that are cut at the edge of a cell count as the word that they begin or end."""
    known = " ".join(known_words())
    found = {
        word: file.name
        for file in sorted((ROOT / "tests/tui/__snapshots__/test_pictures").glob("*.svg"))
        for word in unlisted(" ".join(SHOWN.findall(file.read_text(encoding="utf-8"))), DATA + OF_TEXTUAL)
        if not re.search(rf"\b{word}|{word}\b", known)
    }
    assert not found


def test_a_word_without_a_text_is_found() -> None:
    assert unlisted("Saved flight 13, gobbledygook") == ["gobbledygook"]
    assert unlisted("gobbledygook", "--rocket Gobbledygook") == []


def test_the_catalog_has_each_text_once_with_all_its_locations(tmp_path: Path) -> None:
    lines = list(catalog())
    ids = [line for line in lines if line.startswith("msgid ")]
    assert len(ids) == len(set(ids)) > 1500
    at = lines.index('msgid "Highest total impulse of a motor, in N s."')
    assert lines[at - 1].startswith("#: fieldkit/cli/motors.py:")
    counts = lines.index('msgid_plural "{0} flights"')
    assert lines[counts - 1 : counts + 3] == [
        'msgid "{0} flight"',
        'msgid_plural "{0} flights"',
        'msgstr[0] ""',
        'msgstr[1] ""',
    ]


def test_translators_tools_can_read_the_catalog(tmp_path: Path) -> None:
    pofile = pytest.importorskip("babel.messages.pofile")
    file = tmp_path / "fieldkit.pot"
    file.write_text("\n".join(catalog()) + "\n", encoding="utf-8")
    with file.open("rb") as stream:
        found = pofile.read_po(stream, abort_invalid=True)
    texts = {message.id if isinstance(message.id, str) else message.id[0]: message for message in found if message.id}
    assert texts["rocket: found nothing, expected the rocket's name"].locations[0][0] == "fieldkit/cli/add.py"
    assert "python-brace-format" in texts["{0} flight"].flags
