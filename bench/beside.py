"""`python -m bench.beside SETS`: quick verdicts beside those of the search, and errors forward in time.

The error that `loop` states for forecasts forward in time is compared with that of the same flights as `score` replays
them, each forecast from the earlier flights alone.

Each set's history goes into a separate ledger. Nothing of the product is imported.
"""

import sys
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import fmean, median

from bench.commands import read_labels, run, sets_parser


def beside(command: Sequence[str], table: Path, rocket: str) -> tuple[str, str, float]:
    """The quick verdict and that of the search; and the stated error forward in time without a correction, relative to
    that of the same flights replayed [1]. Raises CommandFailed."""
    with tempfile.TemporaryDirectory() as home:
        ask = partial(run, command, Path(home))
        ask("import", str(table))
        quick, whole = (ask("loop", "--rocket", rocket, how) for how in ("--quick", "--dry-run"))
        replayed = ask("score", "--rocket", rocket)["flights"]
    stated = whole["forward"]
    misses = [abs(one["flown"] - one["p50"]) for one in replayed][-stated["n_flights"] :]
    return quick["verdict"]["effect"], whole["verdict"]["effect"], stated["before"]["mae_m"] / fmean(misses)


def main() -> int:
    """Print a row for each set, and both comparisons over all."""
    given, out = sets_parser(__doc__).parse_args(), sys.stdout.write
    found = []
    for label in read_labels(given.sets, given.limit):
        found.append(beside(given.command, given.sets / f"{label['set']}.csv", label["rocket"]))
        out("{} {}: quick {}, search {}, stated error {:.2f}\n".format(label["set"], label["label"], *found[-1]))
        sys.stdout.flush()
    ratios = [ratio for *_, ratio in found]
    low, *_, high = sorted(ratios)
    same = sum(set(quick.split("+")) == set(whole.split("+")) for quick, whole, _ in found)
    out(f"same verdict: {same} of {len(found)}\n")
    out(f"stated error over that replayed: median {median(ratios):.2f}, {low:.2f} to {high:.2f}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
