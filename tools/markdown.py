"""Parts of the generated pages in `docs/`."""

import json
import subprocess
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

WRITTEN_BY = "This page is written by `python tools/manual.py`."
MEASURED = Path(__file__).parents[1] / "docs" / "measured"
"""Results of long measurements, each file with its command."""


def prose(*parts: str) -> Iterator[str]:
    """A paragraph."""
    yield textwrap.fill(" ".join(parts), 120, break_long_words=False, break_on_hyphens=False)
    yield ""


def table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """A table in Markdown."""
    yield "| " + " | ".join(headers) + " |"
    yield "|" + "---|" * len(headers)
    yield from ("| " + " | ".join(row) + " |" for row in rows)
    yield ""


def commit() -> str:
    """The short name of the checkout's commit."""
    command = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, cwd=MEASURED, check=True, capture_output=True, text=True).stdout.strip()


def measured(name: str) -> dict[str, Any] | None:
    """The measurement with a name; None if there is none."""
    path = MEASURED / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def percent(fraction: float | None, digits: int = 1) -> str:
    """A fraction in percent, `-` for none."""
    return "-" if fraction is None else f"{100 * fraction:.{digits}f}%"
