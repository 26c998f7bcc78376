"""The published logs next to the checkout, if available: facts about real files to check."""

from pathlib import Path

import pytest

from fieldkit.importing import Note, Reading
from fieldkit.importing.recognize import parser_for

LOGS = Path(__file__).parents[3] / "shared" / "logs"
real = pytest.mark.skipif(not LOGS.is_dir(), reason="the published logs are not beside the checkout")


def reading(name: str) -> Reading:
    """The one flight of a published log."""
    (found,) = (item for item in _found(name) if isinstance(item, Reading))
    return found


def damage(name: str) -> list[str]:
    """The damage in a published log, one line each."""
    return [str(item) for item in _found(name) if not isinstance(item, Reading | Note)]


def _found(name: str) -> list[object]:
    log = (LOGS / name).read_bytes()
    return list(parser_for(log).read(log))
