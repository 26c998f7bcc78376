"""Runs the benchmarks and saves the results: `python tools/benchmarks.py [NAME ...]`.

Each run writes a file in `docs/benchmarks/`, named by date and commit, with the group of every benchmark, the shortest
and the median of its rounds in seconds, and other figures (ratios, rates). A name selects a benchmark: `start` runs
`tests/benchmarks/bench_start.py`. `--page` only writes `docs/speed.md` from the latest saved run of each.
"""

import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tools.markdown import commit

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "benchmarks"
PAGE = ROOT / "docs" / "speed.md"
NAMES = tuple(sorted(path.stem.removeprefix("bench_") for path in (ROOT / "tests" / "benchmarks").glob("bench_*.py")))


def run(name: str) -> tuple[list[dict[str, Any]], int]:
    """The results of a file's benchmarks, without failed ones, and pytest's exit status."""
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "benchmarks.json"
        options = ["-o", "addopts=", "--benchmark-only", "-p", "no:cacheprovider", f"--benchmark-json={out}"]
        command = [sys.executable, "-m", "pytest", *options, f"tests/benchmarks/bench_{name}.py"]
        ran = subprocess.run(command, cwd=ROOT, env=os.environ | {"OMP_NUM_THREADS": "1"})
        if not out.exists() or not out.stat().st_size:
            raise SystemExit(ran.returncode)
        rows = [_row(name, found) for found in json.loads(out.read_text(encoding="utf-8"))["benchmarks"]]
        return rows, ran.returncode


def _row(file: str, found: dict[str, Any]) -> dict[str, Any]:
    stats = found["stats"]
    about = {"file": file, "group": found["group"], "name": found["name"], "rounds": stats["rounds"]}
    return about | {"min_s": stats["min"], "median_s": stats["median"]} | found["extra_info"]


def machine() -> dict[str, Any]:
    """The commit and the type of machine, without its name."""
    return {
        "commit": commit(),
        "at": datetime.now(UTC).isoformat(timespec="minutes"),
        "python": platform.python_version(),
        "system": platform.system(),
        "processor": _processor(),
        "cores": os.cpu_count(),
    }


def _processor() -> str:
    """The name of the processor if the system reports it, or else its type."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def latest() -> dict[str, dict[str, Any]]:
    """The latest saved run of each file of benchmarks, with only the rows of that file."""
    found: dict[str, dict[str, Any]] = {}
    for path in RESULTS.glob("*.json"):
        kept = json.loads(path.read_text(encoding="utf-8"))
        for name in {row["file"] for row in kept["benchmarks"]}:
            if name not in found or found[name]["at"] < kept["at"]:
                found[name] = kept | {"benchmarks": [row for row in kept["benchmarks"] if row["file"] == name]}
    return dict(sorted(found.items()))


ABOUT = """# Speed

Processor seconds, the shortest of several rounds, with their ratio to a baseline from the same run. Ratios differ less
between machines than seconds. The command above each table repeats the measurement and saves it in `docs/benchmarks/`;
`python tools/benchmarks.py --page` writes this page from the latest run of each, of a series the smallest and the
largest, or the slowest and the fastest. A key is *answered* when the screen first shows a change after it, in
wall-clock time, and *done* when everything that it computes is shown, in processor time."""


def page(runs: dict[str, dict[str, Any]]) -> Iterator[str]:
    """The latest runs as Markdown, one table each, without benchmarks that only assert or no longer exist."""
    yield ABOUT
    for name, kept in runs.items():
        source = (ROOT / "tests" / "benchmarks" / f"bench_{name}.py").read_text(encoding="utf-8")
        heading = " ".join(source.split('"""')[1].split())
        yield from ("", f"## {heading.partition(':')[0].partition('. ')[0]}", "")
        about = f"{kept['at'][:10]}, commit {kept['commit']}, {kept['processor']}, Python {kept['python']}"
        yield from (f"`python tools/benchmarks.py {name}`, {about}:", "")
        rows = [row for row in kept["benchmarks"] if f"def {row['name'].partition('[')[0]}(" in source]
        rows = [row for row in _extremes(_ends(rows)) if not _is_unit(row, rows)]
        cells = [HEAD, *(_cells(row) for row in rows if row.keys() & {"ratio", *RATES})]
        filled = [place for place in range(len(HEAD)) if any(line[place] for line in cells[1:])]
        head, *lines = (f"| {' | '.join(line[place] for place in filled)} |" for line in cells)
        yield from (head, "|---" * len(filled) + "|", *lines)


def _is_unit(row: dict[str, Any], rows: list[dict[str, Any]]) -> bool:
    """Whether a row only repeats the unit of another row of its series, whose ratio gives it."""
    series = re.sub(r"\d+", "", row["name"])
    others = [one for one in rows if one is not row and re.sub(r"\d+", "", one["name"]) == series]
    return row.get("ratio") == 1 and any(one.get("beside") == row.get("beside") for one in others)


def _extremes(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of rows with rates that differ only in a word, the slowest and the fastest."""
    rates: dict[str, list[int]] = {}
    for row in rows:
        rates.setdefault(row["name"].partition("[")[0], []).append(row.get("flights_per_second", 0))
    return [
        row
        for row in rows
        if len(every := rates[row["name"].partition("[")[0]]) == 1
        or not all(every)
        or row["flights_per_second"] in (min(every), max(every))
    ]


def _ends(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of rows that differ only in a number, the first and the last; the others are in the saved run."""
    series = [re.sub(r"\d+", "", row["name"]) for row in rows]
    first = {name: place for place, name in reversed(list(enumerate(series)))}
    last = {name: place for place, name in enumerate(series)}
    return [
        row for place, (row, name) in enumerate(zip(rows, series, strict=True)) if place in (first[name], last[name])
    ]


RATES = {"flights_per_second": "flights", "megabytes_per_second": "MB"}
LABELS = {
    "start": "until {0}",
    "a_key_is_answered_with_five_thousand_flights": "a key, with 5,000 flights",
    "a_question": "{0}, ledger of {1:,} flights",
    "the_command_flights": "{0:,} flights, {1}",
    "a_command_on_one_rocket": "`{0}`, {1:,} flights",
    "flights_inferred_together": "flights inferred at once: {0:,}",
    "help": "`fieldkit --help`",
    "a_command": "`fieldkit {0}`",
    "a_prediction": "`fieldkit predict`, {0}",
    "the_least_that_it_could_be": "{0}",
}
"""Names of rows that the name of the benchmark, without `test_`, does not give; numbered parts are its parameters."""
QUESTIONS = {
    "list all": "list all flights",
    "of one rocket": "list the flights of one rocket",
    "by a tag": "list the flights with a tag",
    "by an id": "find a flight by its id",
    "add one": "add a flight",
}
PARAMETERS = {"still": "still air", "windy": "wind", "24": "first 24 rows", "None": "all rows", **QUESTIONS}
"""What parameters mean."""


HEAD = ("what", "seconds", "relative to", "rate or response times")
"""The columns of a table; one without a figure is not in it."""


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    what, _, given = row["name"].removeprefix("test_").rstrip("]").partition("[")
    relative = re.sub(r"^.* of (\d+ flights)$", r"\1", row.get("beside", ""))
    return (
        _label(what, given),
        f"{row['min_s']:.3g}",
        f"{row['ratio']:.3g} × {relative}" if "ratio" in row else "",
        "; ".join([*_within(row), *(f"{row[key]:,} {unit} per second" for key, unit in RATES.items() if key in row)]),
    )


def _label(what: str, given: str) -> str:
    """What a benchmark measures, in words, with its parameters."""
    given = re.sub(r"libraries\d+", "", given)  # they are named beside the ratio
    parts = [PARAMETERS.get(part, part) for part in given.split("-")] if not given.startswith("fieldkit") else [given]
    numbers = [int(part) if part.isdigit() else part for part in parts]
    if what in LABELS:
        return LABELS[what].format(*numbers)
    return ", ".join([what.replace("_", " ").replace("papers", "paper's"), *filter(None, parts)])


def _within(row: dict[str, Any]) -> Iterator[str]:
    """The time within which each percentage of the rounds ended, if a benchmark reports it."""
    times: dict[str, list[str]] = {}
    for key, value in row.items():
        if key.startswith("within_"):
            _, percent, what, _ = key.split("_")
            times.setdefault(what, []).append(f"{percent} within {value:g} ms")
    yield from (f"{what}: {', '.join(shown)}" for what, shown in times.items())


def main() -> int:
    """Run the benchmarks named on the command line, by default all, and save them. Returns pytest's worst status."""
    if sys.argv[1:] == ["--page"]:
        PAGE.write_text("\n".join(page(latest())) + "\n", encoding="utf-8")
        return 0
    names = sys.argv[1:] or NAMES
    if unknown := set(names) - set(NAMES):
        raise SystemExit(f"found {', '.join(sorted(unknown))}, expected some of: {', '.join(NAMES)}")
    about = machine()
    runs = [run(name) for name in names]
    RESULTS.mkdir(exist_ok=True)
    file = RESULTS / f"{about['at'][:10]}_{about['commit']}_{'_'.join(sys.argv[1:]) or 'all'}.json"
    command = " ".join(["python", "tools/benchmarks.py", *sys.argv[1:]])
    rows = [row for found, _ in runs for row in found]
    file.write_text(json.dumps({"command": command, **about, "benchmarks": rows}, indent=1) + "\n", encoding="utf-8")
    sys.stdout.write(f"{file}\n")
    return max(status for _, status in runs)


if __name__ == "__main__":
    sys.exit(main())
