"""`python -m bench.infer SETS`: errors of `fieldkit infer` in the true Cd of flights from another simulator.

Each set's history goes into a separate ledger, and Cd is inferred from each single flight. The bench's devices are
unbiased, with noise. Nothing of the product is imported.
"""

import csv
import math
import sys
import tempfile
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from statistics import NormalDist, median
from typing import Any

from bench.commands import read_labels, run, sets_parser

FLIGHTS = 3
"""Number of flights used from the start of each set; more flights of a rocket would have the same true Cd. [1]"""
NORMAL_95 = NormalDist().inv_cdf(0.95)


def inferred(command: Sequence[str], table: Path) -> list[dict[str, Any]]:
    """The output of `fieldkit infer` for the first flights of a table. Raises CommandFailed."""
    with table.open(encoding="utf-8", newline="") as rows:
        first = [row["flight_id"] for row in islice(csv.DictReader(rows), FLIGHTS)]
    with tempfile.TemporaryDirectory() as home:
        run(command, Path(home), "import", str(table))
        flights: list[dict[str, Any]] = run(command, Path(home), "infer", *first)["flights"]
    return flights


def misses(flights: Sequence[dict[str, Any]], truth: float) -> Iterator[tuple[float, float, float]]:
    """Error of log Cd, its stated standard deviation, and alpha, for each flight with a Cd. [1]"""
    for one in flights:
        if one["cd"] and math.isfinite(one["cd"]):
            sd = math.sqrt(math.log1p((one["cd_sd"] / one["cd"]) ** 2))
            yield math.log(one["cd"] / truth) - sd**2 / 2, sd, one["alpha"]


def line(name: str, found: Sequence[tuple[float, float, float]]) -> str:
    """A row of the table: medians, the fraction inside 90% intervals, and the mean log density of the truth."""
    errors = [error for error, _, _ in found]
    inside = sum(abs(error) < NORMAL_95 * sd for error, sd, _ in found) / len(found)
    size, bias = median(map(abs, errors)), median(errors)
    score = sum(-0.5 * (error / sd) ** 2 - math.log(sd) for error, sd, _ in found) / len(found)
    alpha = median(one for *_, one in found)
    return f"{name:24} {len(found):7} {bias:+7.1%} {size:7.1%} {inside:7.0%} {score:7.2f} {alpha:7.3f}"


def main() -> int:
    """Evaluate every set of a folder, and print a line for each kind of readouts."""
    options = sets_parser(__doc__).parse_args()
    found: dict[str, list[tuple[float, float, float]]] = {}
    for label in read_labels(options.sets, options.limit):
        flights = inferred(options.command, options.sets / f"{label['set']}.csv")
        kind = "apogee" if label["readouts"] == "apogee" else "more readouts"
        found.setdefault(kind, []).extend(misses(flights, label["true"]["cd"]))
    columns = ("flights", "bias", "|error|", "in 90%", "score", "alpha")
    sys.stdout.write(f"{'log Cd':24} " + " ".join(f"{name:>7}" for name in columns) + "\n")
    sys.stdout.writelines(line(name, rows) + "\n" for name, rows in sorted(found.items()))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
