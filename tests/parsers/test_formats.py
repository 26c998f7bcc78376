"""The table of formats lists the installed parsers, and counts the real recordings."""

import re
from collections import Counter
from pathlib import Path

import pytest

from fieldkit.importing.recognize import claims, parsers
from tests.parsers.real_logs import LOGS
from tests.samples import SAMPLES, owner

PAGE = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
ROWS = {row[0]: row[1:] for row in re.findall(r"^\| `(\w+)` \| (.+) \| (\d+) \| (.+) \|$", PAGE, flags=re.MULTILINE)}


def test_the_table_has_a_row_for_every_parser_by_its_title() -> None:
    assert {name: row[0] for name, row in ROWS.items()} == {name: parser.title for name, parser in parsers().items()}


def test_every_format_has_a_sample() -> None:
    assert {owner(sample) for sample in SAMPLES} == set(ROWS)


@pytest.mark.skipif(not LOGS.is_dir(), reason="the real logs are not beside this checkout")
def test_the_table_counts_the_real_recordings_that_each_parser_claims() -> None:
    claimed = Counter(name for log in LOGS.iterdir() if log.is_file() for name in claims(log.read_bytes()))
    assert {name: int(row[1]) for name, row in ROWS.items() if row[1] != "0"} == dict(claimed)


def test_a_simulation_is_reported_as_one() -> None:
    simulations = {name for name, row in ROWS.items() if row[2].startswith("simulations")}
    assert simulations == {name for name, parser in parsers().items() if "simulation" in parser.title}
