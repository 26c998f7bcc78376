"""`python -m bench.forward SETS`: coverage of forecasts forward in time, before and after their correction.

Each set's history and later flights go into a separate ledger, and `fieldkit score` forecasts every flight from the
earlier ones with the plain model. The effect in a set is not declared, so the model is wrong in most of them. Nothing
of the product is imported.
"""

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bench.commands import read_labels, run, sets_parser


def score_set(command: Sequence[str], folder: Path, name: str) -> dict[str, Any]:
    """The output of `fieldkit score` for all flights of a set. Raises CommandFailed."""
    with tempfile.TemporaryDirectory() as home:
        run(command, Path(home), "import", str(folder / f"{name}.csv"), str(folder / f"{name}_future.csv"))
        found: dict[str, Any] = run(command, Path(home), "score")
    return found


def say(line: str) -> None:
    """Print a line of the table without buffering."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main() -> int:
    """Score every set of a folder and print a line for each and for all."""
    options = sets_parser(__doc__).parse_args()
    labels = read_labels(options.sets, options.limit)
    rows: list[dict[str, Any]] = []
    say(f"{'set':8} {'hidden':32} {'flights':>7} {'median error':>12} {'corrected':>9} {'before':>6} {'after':>6}")
    for label in labels:
        found = score_set(options.command, options.sets, label["set"])
        late = [row for row in found["flights"] if row["corrected"]]
        rows += late
        before, after = (_coverage(late, which) for which in ("model", "corrected"))
        error = found["errors"][0]["median_share"]
        size = len(found["flights"])
        say(f"{label['set']:8} {label['scenario']:32} {size:7} {error:12.1%} {len(late):9} {before:6.0%} {after:6.0%}")
    before, after = (_coverage(rows, which) for which in ("model", "corrected"))
    say(f"all: {len(rows)} corrected; {before:.1%} inside before, {after:.1%} after")
    return 0


def _coverage(rows: Sequence[dict[str, Any]], which: str) -> float:
    """Fraction of flights inside the model's interval or the corrected one. [1]"""
    ends = [row["corrected"] if which == "corrected" else (row["p05"], row["p95"]) for row in rows]
    inside = [low <= row["flown"] <= high for row, (low, high) in zip(rows, ends, strict=True)]
    return sum(inside) / len(inside) if inside else float("nan")


if __name__ == "__main__":
    sys.exit(main())
