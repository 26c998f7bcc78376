"""Random keys cause no unexpected error, and the memory of the app stays bounded."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.effort import THOROUGH
from tests.pressing import ROOT, season

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
SEEDS = (1, 2, 3)
"""Seeds that found bugs: 2 closed the palette twice, and listed a flight while it was removed."""
MAX_MEMORY = 250
"""Maximum memory during 10,000 keys. [MB] About 145 of it are used before the first key: Python, Textual, SQLAlchemy,
numpy. The peak, a search on the Loop page, depends a little on the load of the machine."""


SIZES = ((80, 24), (120, 36), (40, 15))
"""Terminals: the smallest that is designed for, a usual one, and one that is too small. [cell]"""


def pressed(seed: int, keys: int, rest: float, folder: Path, size: tuple[int, int]) -> dict[str, object]:
    """The result of this number of keys on a season, in a separate process."""
    season(folder / "ledger.db")
    command = [
        sys.executable,
        "-m",
        "tests.tui.random_keys",
        str(seed),
        str(keys),
        str(rest),
        str(folder / "ledger.db"),
        *map(str, size),
    ]
    environment = os.environ | {
        "FIELDKIT_HOME": str(folder / "home"),
        "PYTHONPATH": str(ROOT),
        "OPENBLAS_NUM_THREADS": "1",
    }
    ended = subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, object] = json.loads(ended.stdout.splitlines()[-1])
    return found


@pytest.mark.thorough
@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
def test_some_random_keys_cause_no_error(size: tuple[int, int], tmp_path: Path) -> None:
    assert pressed(1, 150 if THOROUGH else 50, 1.0, tmp_path, size)["errors"] == []


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "size"), zip(SEEDS, SIZES, strict=True))
def test_random_keys_cause_no_error_and_no_memory_leak(seed: int, size: tuple[int, int], tmp_path: Path) -> None:
    found = pressed(seed, 10_000, 5.0, tmp_path, size)
    assert found["errors"] == []
    assert int(str(found["most"])) <= MAX_MEMORY, found
