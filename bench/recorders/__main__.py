"""The recorder bench: `python -m bench.recorders`, which prints how well every kind of recorder is read.

`--flights` of each kind (20), `--only` those with a word in their names, `--worst` so many of the gravest misses.
"""

import argparse
import sys

from bench.recorders.judge import Miss, judged, table
from bench.recorders.models import RECORDERS


def main() -> int:
    """Print the table and the gravest misses; 1 where a log was refused."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--worst", type=int, default=20)
    asked = parser.parse_args()
    misses: list[Miss] = []
    refused: list[str] = []
    for name, recorder in RECORDERS.items():
        if asked.only in name:
            found, wrong = judged(name, recorder, asked.flights, asked.seed)
            misses += found
            refused += wrong
    lines = [*table(misses, asked.flights), "", *refused]
    grave = sorted((one for one in misses if one.grave), key=lambda one: -abs(one.sds))
    lines += [
        f"{one.recorder} {one.flight} {one.readout}: {one.truth + one.error:.4g} +- {one.sd:.2g}, true {one.truth:.4g}"
        for one in grave[: asked.worst]
    ]
    sys.stdout.write("\n".join(lines) + "\n")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
