"""Runs the benchmarks and keeps what they came to: `python tools/benchmarks.py [NAME ...]`.

A file a run in `docs/benchmarks/`, named by date and commit: of every benchmark its group, the shortest and the median
of its rounds in seconds, and what it notes beside them (ratios, rates). With names only those: `start` for
`tests/bench_start.py`.
"""

import json
import os
import platform
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "docs" / "benchmarks"
NAMES = tuple(sorted(path.stem.removeprefix("bench_") for path in (ROOT / "tests").glob("bench_*.py")))


def run(name: str) -> list[dict[str, Any]]:
    """What the benchmarks of a file came to."""
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "benchmarks.json"
        options = ["-o", "addopts=", "--benchmark-only", "-p", "no:cacheprovider", f"--benchmark-json={out}"]
        command = [sys.executable, "-m", "pytest", *options, f"tests/bench_{name}.py"]
        ran = subprocess.run(command, cwd=ROOT, env=os.environ | {"OMP_NUM_THREADS": "1"})
        if not out.exists() or not out.stat().st_size:
            raise SystemExit(ran.returncode)
        return [_row(name, found) for found in json.loads(out.read_text(encoding="utf-8"))["benchmarks"]]


def _row(file: str, found: dict[str, Any]) -> dict[str, Any]:
    stats = found["stats"]
    about = {"file": file, "group": found["group"], "name": found["name"], "rounds": stats["rounds"]}
    return about | {"min_s": stats["min"], "median_s": stats["median"]} | found["extra_info"]


def machine() -> dict[str, Any]:
    """What the figures were taken on; nothing that names the machine itself."""
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.strip()
    return {
        "commit": commit,
        "at": datetime.now(UTC).isoformat(timespec="minutes"),
        "python": platform.python_version(),
        "system": platform.system(),
        "processor": _processor(),
        "cores": os.cpu_count(),
    }


def _processor() -> str:
    """The processor's own name where the system tells, else its kind."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text(encoding="utf-8").splitlines() if told.exists() else []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def main() -> None:
    """Run and keep the benchmarks named on the command line, all by default."""
    names = sys.argv[1:] or NAMES
    if unknown := set(names) - set(NAMES):
        raise SystemExit(f"found {', '.join(sorted(unknown))}, expected some of: {', '.join(NAMES)}")
    about = machine()
    rows = [row for name in names for row in run(name)]
    KEPT.mkdir(exist_ok=True)
    file = KEPT / f"{about['at'][:10]}_{about['commit']}_{'_'.join(sys.argv[1:]) or 'all'}.json"
    command = " ".join(["python", "tools/benchmarks.py", *sys.argv[1:]])
    file.write_text(json.dumps({"command": command, **about, "benchmarks": rows}, indent=1) + "\n", encoding="utf-8")
    sys.stdout.write(f"{file}\n")


if __name__ == "__main__":
    main()
