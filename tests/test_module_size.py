"""No module is too long for a reader."""

from pathlib import Path

import pytest

pytestmark = pytest.mark.fast
CHECK_SHAPES = False

ROOT = Path(__file__).parents[1]
MAX_LINES = 300


def test_no_module_is_longer_than_a_reader_can_keep_in_mind() -> None:
    folders = ("fieldkit", "parsers", "models", "studies", "bench", "tools")
    lengths = {file: len(file.read_bytes().splitlines()) for name in folders for file in (ROOT / name).rglob("*.py")}
    assert len(lengths) > 500
    too_long = [f"{file.relative_to(ROOT)}: {lines}" for file, lines in lengths.items() if lines > MAX_LINES]
    assert not too_long, "split along a seam: " + ", ".join(too_long)
