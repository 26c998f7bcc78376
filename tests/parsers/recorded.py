"""The real recordings, which lie beside the repository if there are any and are no part of it."""

from pathlib import Path

import pytest

LOGS = Path(__file__).parents[3] / "shared" / "logs"


def recorded(name: str) -> bytes:
    """The bytes of a recording; skips the test that asks if it is not there."""
    file = LOGS / name
    if not file.is_file():
        pytest.skip(f"needs the recording {name}, which is no part of this repository")
    return file.read_bytes()
