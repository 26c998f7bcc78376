"""`python -m bench.score SETS`: run the product on every set, then compare with the labels.

Only the code for parallel jobs is imported from the product, which is run as a command with JSON output. A set's
history goes into a separate ledger; `loop` gives the verdict, and `predict --flights` the errors on later flights, with
the model before and after. `--keep FOLDER` saves each set's result when it is done, so that a second run resumes;
`--cluster` runs the sets on Dask workers, which need this checkout.
"""

import argparse
import csv
import json
import os
import shlex
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bench.altimeter import RESOLUTION
from bench.commands import CommandFailed, read_labels, run
from bench.make import IMPERIAL
from bench.result import Errors, Result, effects, false_names
from bench.tables import summary, table
from fieldkit.parallel import done, workers


def score(
    folder: Path, label: Mapping[str, Any], command: Sequence[str], timeout: float, forecasts: bool = True
) -> Result:
    """Run the product on one set: its verdict, and unless `forecasts` is false its errors on later flights."""
    known: dict[str, Any] = {
        "name": label["set"],
        "scenario": label["scenario"],
        "label": label["label"],
        "reach": 1 - label["ideal_mae_m"] / label["blind_mae_m"],
        "ideal": label["ideal_future_mae_m"],
        "level": label["level"],
    }
    with tempfile.TemporaryDirectory() as scratch:
        ask = partial(run, command, Path(scratch), timeout=timeout)
        try:
            taken = ask("import", str(folder / f"{label['set']}.csv"))
            if taken["rejected"]:
                return Result(**known, error=f"import rejected {taken['rejected'][0]}")
            started = os.times().elapsed
            answer = ask("loop", "--rocket", label["rocket"])
            seconds = os.times().elapsed - started
            later = folder / f"{label['set']}_future.csv"
            planned = _planned(later, Path(scratch) / "planned.csv")

            def forecast(model: str) -> Errors:
                return _errors(ask("predict", "--flights", str(planned), "--model", model)["predictions"], later)

            def with_given(name: str) -> Errors:
                ask("loop", "--rocket", label["rocket"], "--effect", name)
                return forecast("after")

            before, after = (forecast(model) if forecasts else None for model in ("before", "after"))
            given, without = None, {}
            if forecasts and label["label"] not in ("none", "unexplained") and _could_be(answer, label["label"]):
                given = with_given(label["label"])
                parts = sorted(effects(label["label"]))
                if len(parts) == 2:
                    without = {part: with_given(other).mae for part, other in zip(parts, reversed(parts), strict=True)}
        except (OSError, ValueError, KeyError, TypeError, subprocess.SubprocessError, CommandFailed) as trouble:
            return Result(**known, error=f"{type(trouble).__name__}: {trouble}"[:400])
    verdict = answer["verdict"]
    return Result(
        **known,
        verdict=verdict["effect"],
        also=tuple(verdict.get("also", ())),
        confidence=float(verdict["confidence"]),
        before=before,
        after=after,
        given=given,
        without=without,
        seconds=seconds,
        top=tuple(candidate["effect"] for candidate in answer["candidates"][:4]),
        false=false_names(answer, label),
        probabilities=answer.get("probabilities", {}).get("effects", {}),
    )


@dataclass(frozen=True, slots=True)
class Set:
    """A set with everything needed to score it on another machine, and the command."""

    label: Mapping[str, Any]
    tables: Mapping[str, str]
    command: Sequence[str]
    timeout: float
    forecasts: bool = True


def score_set(one: Set) -> bytes:
    """The result of a set, as JSON."""
    with tempfile.TemporaryDirectory() as scratch:
        for name, text in one.tables.items():
            (Path(scratch) / name).write_text(text, encoding="utf-8", newline="")
        return json.dumps(asdict(score(Path(scratch), one.label, one.command, one.timeout, one.forecasts))).encode()


def _result(content: bytes) -> Result:
    kept = json.loads(content)
    errors = {name: Errors(**kept[name]) if kept[name] else None for name in ("before", "after", "given")}
    return Result(**{**kept, **errors, **{name: tuple(kept[name]) for name in ("also", "top", "false")}})


def to_score(
    folder: Path, labels: Sequence[Mapping[str, Any]], command: Sequence[str], timeout: float, forecasts: bool = True
) -> dict[str, Set]:
    """The sets by their names."""
    found = {}
    for label in labels:
        names = [f"{label['set']}{part}.csv" for part in ("", "_future")]
        tables = {name: (folder / name).read_bytes().decode() for name in names}
        found[str(label["set"])] = Set(label, tables, command, timeout, forecasts)
    return found


def results(sets: Mapping[str, Set], keep: Path | None, jobs: int, cluster: str) -> Iterator[Result]:
    """The result of each set when it is done, from threads of this process or workers of a cluster."""
    with ExitStack() as stack:
        folder = keep or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        pool = stack.enter_context(workers(cluster) if cluster else ThreadPoolExecutor(jobs))
        yield from (_result(content) for _, content in done(score_set, sets, folder, pool))


def _could_be(verdict: Mapping[str, Any], label: str) -> bool:
    """Whether the product lists a label's effects as possible for these flights."""
    return effects(label) <= {candidate["effect"] for candidate in verdict["candidates"]}


def _planned(later: Path, path: Path) -> Path:
    """The later flights without their readouts."""
    hidden = set(RESOLUTION)
    for suffix, (other, _) in IMPERIAL.items():
        hidden |= {name.removesuffix(suffix) + other for name in RESOLUTION if name.endswith(suffix)}
    with later.open(encoding="utf-8", newline="") as source, path.open("w", encoding="utf-8", newline="") as file:
        reader = csv.DictReader(source)
        writer = csv.DictWriter(file, [n for n in reader.fieldnames or () if n not in hidden], extrasaction="ignore")
        writer.writeheader()
        writer.writerows(reader)
    return path


def _errors(predictions: Sequence[Mapping[str, Any]], later: Path) -> Errors:
    """Errors of predictions, matched to the measured flights by their id."""
    with later.open(encoding="utf-8", newline="") as source:
        rows = list(csv.DictReader(source))
    predicted = {str(p["flight_id"]): p["apogee_m"] for p in predictions}
    apogee = np.array(
        [float(row["apogee_m"]) if "apogee_m" in row else float(row["apogee_ft"]) * 0.3048 for row in rows]
    )
    found = [predicted[row["flight_id"]] for row in rows]
    error = np.array([p["p50"] for p in found]) - apogee
    low, high = (np.array([p[end] for p in found]) for end in ("p05", "p95"))
    outside = np.maximum(low - apogee, 0.0) + np.maximum(apogee - high, 0.0)
    interval = float((high - low + 20 * outside).mean())
    return Errors(float(np.abs(error).mean()), float(error.mean()), int((outside == 0).sum()), len(rows), interval)


def main() -> None:
    """Read the command line, score, print the table, save the results as JSON."""
    parser = argparse.ArgumentParser(prog="python -m bench.score", description=__doc__)
    parser.add_argument("sets", type=Path)
    parser.add_argument("--command", default="fieldkit", help="how the product is called")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--cluster", default="", help="Dask's workers: local, local:4, or a scheduler's address")
    parser.add_argument("--keep", type=Path, help="a folder for the results of sets, to resume from")
    parser.add_argument("--timeout", type=float, default=180.0, help="seconds for one call")
    parser.add_argument("--verdicts", action="store_true", help="without forecasts of later flights")
    parser.add_argument("--scenario", nargs="*", help="only these")
    parser.add_argument("--limit", type=int, help="only the first so many sets of each scenario")
    parser.add_argument("--first", type=int, help="only the first so many sets of all")
    parser.add_argument("--out", type=Path, help="where the results go as JSON")
    given = parser.parse_args()
    labels = read_labels(given.sets, given.first)
    seen: Counter[str] = Counter()
    chosen = []
    for label in labels:
        seen[label["scenario"]] += 1
        if label["scenario"] in (given.scenario or [label["scenario"]]) and (
            given.limit is None or seen[label["scenario"]] <= given.limit
        ):
            chosen.append(label)
    found = []
    sets = to_score(given.sets, chosen, shlex.split(given.command), given.timeout, not given.verdicts)
    for result in results(sets, given.keep, given.jobs, given.cluster):
        found.append(result)
        mark = result.error or ("right" if result.right else "wrong")
        sys.stderr.write(f"{result.name} {result.scenario}: {result.verdict} {mark}\n")
        if given.out:
            in_order = sorted(found, key=lambda one: list(sets).index(one.name))
            given.out.write_text(json.dumps([asdict(one) for one in in_order], indent=1) + "\n")
    sys.stdout.write(f"{table(found)}\n\n{summary(found)}\n")


if __name__ == "__main__":
    main()
