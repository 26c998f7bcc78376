"""`python -m bench.score SETS`: run the product on every set, then look at the labels.

Nothing of the product is imported but the sharing out of work: it is a command with JSON on its output, as the
contract has it. A set's history goes into a ledger of its own, `loop` gives the verdict, and `predict --flights` the
errors on the flights that came later, with the model before and after. `--keep FOLDER` keeps each set's result as it
comes, and a second run goes on from there; `--cluster` runs the sets on Dask's workers, which need this checkout.
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
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bench.altimeter import RESOLUTION
from bench.make import IMPERIAL
from fieldkit.work import done, workers

WORTH_IT = 0.2
"""Part of the error that knowing the effect must take away for a set to count as decidable."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Of predicted apogees on the future flights."""

    mae: float
    bias: float
    covered: int
    flights: int


@dataclass(frozen=True, slots=True)
class Result:
    """What the product said of one set, beside its label; `error` if it said nothing."""

    name: str
    scenario: str
    label: str
    reach: float
    """Part of the error that knowing the truth takes away, as the bench's own simulator has it. [1]"""
    ideal: float
    """Error on the future flights that the bench's own simulator leaves with the truth known. [m]"""
    verdict: str = ""
    also: tuple[str, ...] = ()
    confidence: float = float("nan")
    before: Errors | None = None
    after: Errors | None = None
    given: Errors | None = None
    """With the true effect given to the product, whatever it made of the flights."""
    seconds: float = float("nan")
    error: str = ""
    level: int = 0
    top: tuple[str, ...] = field(default=())
    """The best candidates, best first."""

    @property
    def gain(self) -> float:
        """Part of the error on the future flights that the fit of the true effect takes away. [1]"""
        return 1 - self.given.mae / self.before.mae if self.given and self.before else 0.0

    @property
    def decidable(self) -> bool:
        """Whether what is missing matters: to the product's fit of it, or in truth where nothing known is it."""
        return (self.reach if self.label == "unexplained" else self.gain) >= WORTH_IT

    @property
    def named(self) -> bool:
        """Whether the verdict is the label."""
        return effects(self.verdict) == effects(self.label)

    @property
    def right(self) -> bool:
        """Whether the verdict is the label, or names it as one that these flights cannot tell apart."""
        return effects(self.label) in {effects(name) for name in (self.verdict, *self.also)}


def effects(name: str) -> frozenset[str]:
    """The effects that a verdict names, in no order."""
    return frozenset(name.split("+"))


def score(folder: Path, label: Mapping[str, Any], command: Sequence[str], timeout: float) -> Result:
    """Run the product on one set."""
    known: dict[str, Any] = {
        "name": label["set"],
        "scenario": label["scenario"],
        "label": label["label"],
        "reach": 1 - label["ideal_mae_m"] / label["blind_mae_m"],
        "ideal": label["ideal_future_mae_m"],
        "level": label["level"],
    }
    with tempfile.TemporaryDirectory() as scratch:
        ledger = Path(scratch) / "ledger.db"

        def run(*arguments: str) -> Any:
            return _json([*command, "--ledger", str(ledger), *arguments, "--json"], timeout)

        try:
            taken = run("import", str(folder / f"{label['set']}.csv"))
            if taken["rejected"]:
                return Result(**known, error=f"import rejected {taken['rejected'][0]}")
            started = os.times().elapsed
            said = run("loop", "--rocket", label["rocket"])
            seconds = os.times().elapsed - started
            later = folder / f"{label['set']}_future.csv"
            planned = _planned(later, Path(scratch) / "planned.csv")

            def forecast(model: str) -> Errors:
                return _errors(run("predict", "--flights", str(planned), "--model", model)["predictions"], later)

            before, after, given = forecast("before"), forecast("after"), None
            if label["label"] not in ("none", "unexplained") and _could_be(said, label["label"]):
                run("loop", "--rocket", label["rocket"], "--effect", label["label"])
                given = forecast("after")
        except (OSError, ValueError, KeyError, TypeError, subprocess.SubprocessError) as trouble:
            return Result(**known, error=f"{type(trouble).__name__}: {trouble}"[:400])
    verdict = said["verdict"]
    return Result(
        **known,
        verdict=verdict["effect"],
        also=tuple(verdict.get("also", ())),
        confidence=float(verdict["confidence"]),
        before=before,
        after=after,
        given=given,
        seconds=seconds,
        top=tuple(candidate["effect"] for candidate in said["candidates"][:4]),
    )


@dataclass(frozen=True, slots=True)
class Set:
    """A set with all that is needed to score it on another machine, and by which command."""

    label: Mapping[str, Any]
    tables: Mapping[str, str]
    command: Sequence[str]
    timeout: float


def score_set(one: Set) -> bytes:
    """The result of a set, as JSON."""
    with tempfile.TemporaryDirectory() as scratch:
        for name, text in one.tables.items():
            (Path(scratch) / name).write_text(text, encoding="utf-8", newline="")
        return json.dumps(asdict(score(Path(scratch), one.label, one.command, one.timeout))).encode()


def _result(content: bytes) -> Result:
    kept = json.loads(content)
    errors = {name: Errors(**kept[name]) if kept[name] else None for name in ("before", "after", "given")}
    return Result(**{**kept, **errors, "also": tuple(kept["also"]), "top": tuple(kept["top"])})


def _sets(folder: Path, labels: Sequence[Mapping[str, Any]], command: Sequence[str], timeout: float) -> dict[str, Set]:
    """The sets by their names."""
    found = {}
    for label in labels:
        names = [f"{label['set']}{part}.csv" for part in ("", "_future")]
        tables = {name: (folder / name).read_bytes().decode() for name in names}
        found[str(label["set"])] = Set(label, tables, command, timeout)
    return found


def results(sets: Mapping[str, Set], keep: Path | None, jobs: int, cluster: str) -> Iterator[Result]:
    """The result of each set as it comes: by threads of this process, or by the workers of a cluster."""
    with ExitStack() as stack:
        folder = keep or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        pool = stack.enter_context(workers(cluster) if cluster else ThreadPoolExecutor(jobs))
        yield from (_result(content) for _, content in done(score_set, sets, folder, pool))


def _could_be(said: Mapping[str, Any], label: str) -> bool:
    """Whether the product holds that these flights could show the effects of a label."""
    return effects(label) <= {candidate["effect"] for candidate in said["candidates"]}


def _json(command: Sequence[str], timeout: float) -> Any:
    done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    if done.returncode:
        raise ValueError(f"{shlex.join(command[-6:])}: {done.stderr.strip()[-300:]}")
    return json.loads(done.stdout)


def _planned(later: Path, path: Path) -> Path:
    """The future flights without what was read off the altimeter."""
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
    inside = [p["p05"] <= y <= p["p95"] for p, y in zip(found, apogee, strict=True)]
    return Errors(float(np.abs(error).mean()), float(error.mean()), int(sum(inside)), len(rows))


def table(results: Sequence[Result]) -> str:
    """A row per scenario and one for all, in Markdown; errors in metres over the future flights."""
    lines = [
        "| scenario | sets | named | right | decidable | right there | before | after | given | ideal "
        "| coverage before | after | said instead |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for scenario in [*dict.fromkeys(sorted(r.scenario for r in results)), "all"]:
        chosen = [r for r in results if scenario in (r.scenario, "all")]
        lines.append(_row(scenario, chosen, confusions=scenario != "all"))
    return "\n".join(lines)


def _row(scenario: str, results: Sequence[Result], confusions: bool) -> str:
    decidable = [r for r in results if r.decidable]
    said = Counter(r.verdict or "error" for r in results if not r.right).most_common(4) if confusions else []
    cells = [
        scenario,
        str(len(results)),
        _rate(r.named for r in results),
        _rate(r.right for r in results),
        str(len(decidable)),
        _rate(r.right for r in decidable),
        _mean(results, lambda r: r.before.mae if r.before else None),
        _mean(results, lambda r: r.after.mae if r.after else None),
        _mean(results, lambda r: r.given.mae if r.given else None),
        _mean(results, lambda r: r.ideal),
        _coverage([r.before for r in results]),
        _coverage([r.after for r in results]),
        ", ".join(f"{name} {count}" for name, count in said),
    ]
    return f"| {' | '.join(cells)} |"


def _rate(right: Iterable[bool]) -> str:
    values = list(right)
    return f"{100 * sum(values) / len(values):.0f} %" if values else ""


def _mean(results: Sequence[Result], value: Callable[[Result], float | None]) -> str:
    values = [v for r in results if (v := value(r)) is not None]
    return f"{np.mean(values):.1f}" if values else ""


def _coverage(errors: Sequence[Errors | None]) -> str:
    found = [e for e in errors if e]
    return f"{100 * sum(e.covered for e in found) / sum(e.flights for e in found):.0f} %" if found else ""


def summary(results: Sequence[Result]) -> str:
    """The figures that decide: decidable sets, false alarms, part of the possible gain."""
    said = [r for r in results if r.before and r.after]
    effect = [r for r in said if r.label not in ("none", "unexplained")]
    decidable = [r for r in effect if r.decidable]
    nulls = [r for r in said if r.label == "none"]
    lines = [
        f"right verdicts where the fit of the true effect takes away at least {WORTH_IT:.0%} of the error: "
        f"{sum(r.right for r in decidable)} of {len(decidable)}, "
        f"{sum(r.right for r in decidable if '+' not in r.label)} of {sum('+' not in r.label for r in decidable)} "
        "of them with one effect",
        f"false alarms on nulls: {sum(r.verdict != 'none' for r in nulls)} of {len(nulls)}, "
        f"{sum(r.verdict == 'unexplained' for r in nulls)} of them as unexplained",
        f"wrong effect named where nobody's effect was: "
        f"{sum(r.verdict not in ('none', 'unexplained') for r in said if r.label == 'unexplained')} "
        f"of {sum(r.label == 'unexplained' for r in said)}",
    ]
    possible = sum(r.before.mae - r.given.mae for r in decidable if r.before and r.given)
    made = sum(r.before.mae - r.after.mae for r in decidable if r.before and r.after)
    if possible > 0:
        lines.append(f"part of the possible gain made there: {made / possible:.0%}")
    lines.append(f"sets with an error: {len(results) - len(said)}")
    if said:
        lines.append(f"loop: {np.median([r.seconds for r in said]):.1f} s in the median")
    return "\n".join(lines)


def main() -> None:
    """Read the command line, score, print the table, keep the results as JSON."""
    parser = argparse.ArgumentParser(prog="python -m bench.score", description=__doc__)
    parser.add_argument("sets", type=Path)
    parser.add_argument("--command", default="fieldkit", help="how the product is called")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--cluster", default="", help="Dask's workers: local, local:4, or a scheduler's address")
    parser.add_argument("--keep", type=Path, help="a folder for the results of sets as they come, to go on from")
    parser.add_argument("--timeout", type=float, default=180.0, help="seconds for one call")
    parser.add_argument("--scenario", nargs="*", help="only these")
    parser.add_argument("--limit", type=int, help="only the first so many sets of each scenario")
    parser.add_argument("--first", type=int, help="only the first so many sets of all")
    parser.add_argument("--out", type=Path, help="where the results go as JSON")
    given = parser.parse_args()
    labels = json.loads((given.sets / "labels.json").read_text())[: given.first]
    seen: Counter[str] = Counter()
    chosen = []
    for label in labels:
        seen[label["scenario"]] += 1
        if label["scenario"] in (given.scenario or [label["scenario"]]) and (
            given.limit is None or seen[label["scenario"]] <= given.limit
        ):
            chosen.append(label)
    found = []
    sets = _sets(given.sets, chosen, shlex.split(given.command), given.timeout)
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
