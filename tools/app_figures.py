"""The figures that the app keeps, each beside its limit: `python -m tools.app_figures [KEYS [SIZE ...]]`.

The keys of a cycle, how fast a key is answered and the first rows are painted, and errors and memory under KEYS random
keys (10,000 by default) in terminals of three sizes; with sizes such as `80x24` only the keys in terminals of these.
The exit status is 1 if a limit is exceeded.
"""

import sys
from collections.abc import Collection, Iterator
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.tui.test_add import CYCLE, MAX_KEYS
from tests.tui.test_random_keys import MAX_MEMORY, SEEDS, SIZES, pressed
from tools.benchmarks import run

KEYS = 10_000
REST = 5.0
"""Rest before the memory is read. [s]"""
MAX_ANSWER = 50.0
"""Maximum response time of 99% of all keys. [ms]"""
MAX_RATIO = 1.4
"""Maximum processor time until the first rows, relative to an empty app. [1]"""
Figure = tuple[str, float, float]
"""What is measured, its value, and its limit."""


def figures() -> Iterator[Figure]:
    """The figures besides those of random keys."""
    yield "keys of a cycle with ten readouts", len(CYCLE), MAX_KEYS
    yield "first rows, times an empty app", _row("app_start", "first rows")["ratio"], MAX_RATIO
    answered = _row("app", "five_thousand")["within_99%_answered_ms"]
    yield "99% of keys answered within, ms", answered, MAX_ANSWER


def under_random_keys(keys: int, sizes: Collection[str]) -> Iterator[Figure]:
    """Errors and memory under a number of keys in terminals of some sizes, or of all if none is named."""
    for seed, size in zip(SEEDS, SIZES, strict=True):
        named = f"{size[0]}x{size[1]}"
        if sizes and named not in sizes:
            continue
        terminal = f"{keys:,} random keys at {named}"
        with TemporaryDirectory() as folder:
            found = pressed(seed, keys, REST, Path(folder), size)
        errors = list(found["errors"])  # type: ignore[call-overload]  # of JSON
        sys.stdout.writelines(f"{error}\n" for error in errors)
        yield f"{terminal}, errors", len(errors), 0
        yield f"{terminal}, memory at rest, MB", float(str(found["rest"])), MAX_MEMORY


def _row(benchmark: str, name: str) -> dict[str, Any]:
    """The result of a benchmark whose name contains a text."""
    rows, _ = run(benchmark)
    return next(row for row in rows if name in row["name"])


def main() -> int:
    """Print the figures; returns the exit status."""
    keys, sizes, exceeded = int(sys.argv[1]) if sys.argv[1:] else KEYS, sys.argv[2:], 0
    for what, value, limit in chain(() if sizes else figures(), under_random_keys(keys, sizes)):
        within = value <= limit
        exceeded += not within
        sys.stdout.write(f"{'ok ' if within else 'NO '} {what}: {value:g} (at most {limit:g})\n")
        sys.stdout.flush()
    return int(exceeded > 0)


if __name__ == "__main__":
    sys.exit(main())
