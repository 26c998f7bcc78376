"""The real recordings, which are not part of the repository but next to it if available."""

from pathlib import Path

import pytest

LOGS = Path(__file__).parents[3] / "shared" / "logs"


def recorded(name: str) -> bytes:
    """The bytes of a recording; skips the test if it is missing."""
    file = LOGS / name
    if not file.is_file():
        pytest.skip(f"needs the recording {name}, which is no part of this repository")
    return file.read_bytes()
