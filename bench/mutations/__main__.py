"""The mutation bench, `python -m bench.mutations`: what becomes of logs that people changed.

Each kind of table is made of `--flights` known flights (8), and every sample log of every parser is changed in each of
the ways of `bench.mutations.files`. A variant is *right* if each readout agrees with the truth, *refused* if a message
names the file, and *silently wrong* if a readout is off by more than 5% and three standard deviations: for a table from
the flight, for a sample log from what it gives unchanged. `--keep FILE` saves the counts of each kind as it finishes; a
later run with the same file resumes there. `--only` selects kinds by a word, and `--workers` is the number of
processes. Returns 1 if one is silently wrong.
"""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from bench.mutations import edited, handed_on, home_built, programs, tables, unnamed
from bench.mutations.files import FILES
from bench.mutations.tables import log_of
from bench.recorders.flights import Path as Flown
from bench.recorders.flights import draw
from bench.recorders.judge import compared
from fieldkit.analysis import Recorded
from fieldkit.errors import FieldkitError
from fieldkit.importing.read import read
from fieldkit.importing.tables.mapping import read_choice
from fieldkit.parallel import processes

KINDS = {**tables.KINDS, **handed_on.KINDS, **programs.KINDS, **edited.KINDS, **home_built.KINDS, **unnamed.KINDS}
"""Kinds of tables by what was done."""
SAMPLES = Path(__file__).parents[2] / "sample_logs"


@dataclass(slots=True)
class Count:
    """Variants of one kind by what became of them, and the silently wrong ones in words."""

    right: int = 0
    refused: int = 0
    wrong: list[str] = field(default_factory=list)


def main(arguments: list[str] | None = None) -> int:
    """Print a line for each kind, and each variant that is silently wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--workers", type=int, default=1)
    asked = parser.parse_args(arguments)
    drawn = {"flights": asked.flights, "seed": asked.seed}
    kept: dict[str, Any] = json.loads(asked.keep.read_text()) if asked.keep and asked.keep.exists() else {}
    if kept.get("drawn", drawn) != drawn:
        parser.error(f"{asked.keep} holds another bench: {kept['drawn']}")
    counts = {name: Count(**one) for name, one in kept.get("kinds", {}).items()}
    names = [name for name in (*KINDS, *FILES) if asked.only in name]
    kinds = [(name, asked.flights, asked.seed) for name in names if name not in counts]
    with processes(asked.workers) if asked.workers > 1 else nullcontext() as pool:
        found = pool.map(_counted, kinds) if pool else map(_counted, kinds)
        for (name, *_), count in zip(kinds, found, strict=True):
            counts[name] = count
            if asked.keep:
                saved = {"drawn": drawn, "kinds": {one: asdict(each) for one, each in counts.items()}}
                asked.keep.write_text(json.dumps(saved, indent=1) + "\n")
    shown = {name: counts[name] for name in names}
    for name, count in shown.items():
        sys.stdout.write(f"| {name} | {count.right} | {count.refused} | {len(count.wrong)} |\n")
        sys.stdout.writelines(f"  {line}\n" for line in count.wrong)
    right, refused, wrong = (sum(_sizes(one)[place] for one in shown.values()) for place in range(3))
    sys.stdout.write(f"| **{right + refused + wrong} variants** | {right} | {refused} | {wrong} |\n")
    return 1 if wrong else 0


def _sizes(count: Count) -> tuple[int, int, int]:
    return count.right, count.refused, len(count.wrong)


def _counted(kind: tuple[str, int, int]) -> Count:
    """The variants of one kind, of some flights and by a seed: a table of each flight, or every sample log changed."""
    name, flights, seed = kind
    count = Count()
    if name in KINDS:
        for place, path in enumerate(_paths(flights, seed)):
            sheet = KINDS[name](log_of(path, np.random.default_rng([seed, list(KINDS).index(name), place])))
            _judge(count, f"{name} {place}", sheet.text(), sheet.maps, (sheet.path or path).readouts())
    else:
        for file, truth in _samples().items():
            _judge(count, f"{name}, {file.name}", FILES[name](file.read_bytes()), (), truth)
    return count


@cache
def _paths(flights: int, seed: int) -> list[Flown]:
    """The flights of every kind of table, which differ in their noise alone."""
    return draw(np.random.default_rng(seed), flights)


@cache
def _samples() -> dict[Path, dict[str, float]]:
    """The readouts of the first flight in each sample log that has one."""
    found = ((file, _recorded(file.read_bytes(), ())[:1]) for file in sorted(SAMPLES.iterdir()))
    return {file: {name: one.value for name, one in first[0].figures.items()} for file, first in found if first}


def _recorded(log: bytes, maps: Sequence[str]) -> list[Recorded]:
    """The flights in a log; none if a message that names the file says why."""
    try:
        imported = read(log, "log.csv", lambda motor: None, None, [read_choice(maps)] if maps else [])
    except FieldkitError as error:
        if "log.csv" not in str(error):
            raise
        return []
    found = [one for one in imported.recorded if one is not None and one.figures]
    if (
        not found
        and not imported.flights
        and not any("log.csv" in str(one) for one in (*imported.rejected, *imported.notes))
    ):
        raise AssertionError("found neither a flight nor a message that names the file")
    return found


def _judge(count: Count, name: str, log: bytes, maps: Sequence[str], truth: Mapping[str, float]) -> None:
    """Count one variant by the readouts of its first flight."""
    found = _recorded(log, maps)[:1]
    grave = [miss for one in found for miss in compared(name, 0, truth, one) if miss.grave]
    if not found:
        count.refused += 1
    elif grave:
        worst = max(grave, key=lambda miss: miss.relative)
        value, sd = worst.truth + worst.error, worst.sd
        count.wrong.append(f"{name}: {worst.readout} {value:.4g} +- {sd:.2g}, true {worst.truth:.4g}")
    else:
        count.right += 1


if __name__ == "__main__":
    sys.exit(main())
