"""The recorder bench, `python -m bench.recorders`: print how well every kind of recorder is read.

`--flights` is the number of flights of each kind (20), `--only` selects kinds with a word in their names, and `--worst`
is the number of largest errors to print. `--keep FILE` saves each kind of recorder as it finishes; a later run with the
same file resumes there, and `--workers` is the number of processes.
"""

import argparse
import json
import sys
from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bench.recorders.judge import Cell, Miss, cells, judged, table
from bench.recorders.models import RECORDERS
from fieldkit.parallel import processes


def main(arguments: list[str] | None = None) -> int:
    """Print the table and the largest errors. Returns 1 if a log was rejected."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--worst", type=int, default=20)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--workers", type=int, default=1)
    asked = parser.parse_args(arguments)
    kept: dict[str, Any] = json.loads(asked.keep.read_text()) if asked.keep and asked.keep.exists() else {}
    drawn = {"flights": asked.flights, "seed": asked.seed}
    if kept.get("drawn", drawn) != drawn:
        parser.error(f"{asked.keep} holds another bench: {kept['drawn']}")
    recorders = kept.get("recorders", {})
    kinds = [(name, asked.flights, asked.seed) for name in RECORDERS if asked.only in name and name not in recorders]
    with processes(asked.workers) if asked.workers > 1 else nullcontext() as pool:
        for (name, *_), found in zip(kinds, pool.map(_read, kinds) if pool else map(_read, kinds), strict=True):
            recorders[name] = found
            if asked.keep:
                asked.keep.write_text(json.dumps({"drawn": drawn, "recorders": recorders}, indent=1) + "\n")
    shown = {name: recorders[name] for name in RECORDERS if name in recorders}
    rows = {name: {one: Cell(**cell) for one, cell in kind["readouts"].items()} for name, kind in shown.items()}
    refused = [line for kind in shown.values() for line in kind["refused"]]
    misread = [Miss(**one) for kind in shown.values() for one in kind["grave"]]
    worst = (
        f"{one.recorder} {one.flight} {one.readout}: {one.truth + one.error:.4g} +- {one.sd:.2g}, true {one.truth:.4g}"
        for one in sorted(misread, key=lambda one: -abs(one.sds))[: asked.worst]
    )
    sys.stdout.write("\n".join([*table(rows), "", *refused, *worst]) + "\n")
    return 1 if refused else 0


def _read(kind: tuple[str, int, int]) -> dict[str, Any]:
    """What became of the flights of one kind of recorder, by their number and a seed."""
    name, flights, seed = kind
    misses, refused = judged(name, RECORDERS[name], flights, seed)
    readouts = {readout: asdict(cell) for readout, cell in cells(misses, flights).items()}
    return {"readouts": readouts, "grave": [asdict(one) for one in misses if one.grave], "refused": refused}


if __name__ == "__main__":
    sys.exit(main())
