"""The whole fault bench: `python -m bench.faults`, which writes docs/faults.md; `--quick` runs a few trials of
everything.

It runs for about two hours, one of which is two laptops working at a realistic pace. `nice -n 19` leaves the cores to
others, and `--keep FOLDER` resumes an interrupted run. `--minutes` stops after the part that is running at that time,
and `--only` runs the parts whose names start with a text; these two do not write the page.
"""

import argparse
import json
import math
import os
import platform
import shutil
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from functools import cache, partial
from pathlib import Path
from tempfile import mkdtemp

from bench.faults import (
    calls,
    damage,
    discs,
    failing,
    histories,
    kills,
    laptops,
    servers,
    session,
    statements,
    writers,
)
from bench.faults.ledgers import LOG, ROOT, TABLE, Outcome, at_home, fieldkit

PAGE = ROOT / "docs" / "faults.md"
SEED = 8
MEMORY = Path("/dev/shm")
"""A file system in memory, if there is one: processes are killed, not the machine, so the results do not depend on what
has reached a disk, and waiting for a disk would take most of the time."""
HOURLY_KILLS = 12
"""Number of times per hour that the server of two laptops is killed. [1]"""

Part = tuple[str, Callable[[], Outcome]]


def parts(scratch: Path, *, killed: int, others: int, hours: float) -> Iterator[Part]:
    """Every part of the bench, run one after the other; `killed` is the total number of kills, `others` the size of
    each other part.

    `hours` is how long two laptops work at a realistic pace. [h]
    """
    _warm(scratch / "warm")
    folders = (scratch / str(number) for number in range(1000))
    share, rest = divmod(killed, len(kills.CASES))
    for place, case in enumerate(kills.CASES):
        number = share + (place < rest)
        yield f"kill_{case.name}", partial(kills.kills, case, next(folders), number, SEED + place)
    if discs.can_mount():
        yield "full_disc", partial(discs.full_disc, next(folders), step=max(1, 64 // others))
        yield "read_only", partial(discs.read_only, next(folders))
    else:
        missing = Outcome("full disk, read-only file system", "skipped: mounting a small file system takes root")
        yield "discs", lambda: missing
    yield from _of_calls(scratch / "calls", others)
    yield "two_commands", partial(writers.two_commands, next(folders), others // 4)
    yield "app_and_command", partial(writers.app_and_command, next(folders), others // 4)
    yield "restores", partial(histories.restores_beside_writers, next(folders), 5, 2 * others, max(2, others // 4))
    yield "clock_backwards", partial(writers.clock_backwards, next(folders), 15)
    yield "old_schemas", partial(writers.old_schemas, next(folders))
    yield "cut_short", partial(damage.cut_short, next(folders), others, SEED)
    yield "bits_flipped", partial(damage.bits_flipped, next(folders), 2 * others, SEED)
    yield from _of_a_server(scratch / "server", max(3, others // 16), hours)


def _of_calls(folder: Path, others: int) -> Iterator[Part]:
    """System calls that fail, for every command of the tree."""
    if not calls.can_trace():
        yield "calls", lambda: Outcome("a call fails", "skipped: there is no strace on this machine")
        return

    @cache
    def found() -> list[session.Call]:
        with at_home(folder / "desk" / "home"):
            return session.calls(folder)

    for number, name in enumerate(session.commands()):
        if name in session.LEFT_OUT:
            left = Outcome("a call fails", f"{name}: not tried, {session.LEFT_OUT[name]}")
            yield f"fails_{name}", partial(lambda outcome: outcome, left)
        else:
            there = folder / "trials" / str(number)
            yield f"fails_{name}", partial(failing.every_call, there, name, found, others, others)
    yield "fails_histories", partial(failing.history, folder / "histories", 2 * others, SEED)


def _of_a_server(folder: Path, trials: int, hours: float) -> Iterator[Part]:
    if not servers.binaries():
        yield "postgres", lambda: Outcome("PostgreSQL", "skipped: there is no PostgreSQL on this machine")
        return
    with servers.server(folder) as ours:
        for of_the_server in (False, True):
            for name in servers.COMMANDS:
                part = partial(servers.crashes, ours, name, trials, SEED, of_the_server=of_the_server)
                yield f"postgres_{name}_{'server' if of_the_server else 'command'}", part
        commands, beside = min(laptops.HOUR, 80 * trials), folder.with_name
        yield "postgres_laptops", partial(laptops.mixed_work, ours, beside("laptops"), 2, commands, trials, SEED)
        if hours:
            commands, kills = round(hours * laptops.HOUR), max(1, round(HOURLY_KILLS * hours))
            work = partial(laptops.mixed_work, ours, beside("club"), 2, commands, kills, SEED, laptops.EVERY)
            yield "postgres_club", work
        for seed in range(trials // 3):
            yield (
                f"postgres_failover_{seed}",
                partial(laptops.failed_over, ours, beside(f"over{seed}"), 2, commands, seed),
            )
        yield "postgres_statements", partial(statements.process_killed, ours.url, range(1, 2 + 2 * trials))


def tried(part: Callable[[], Outcome], file: Path) -> Outcome:
    """Result of a part, computed now or saved in this file by an earlier run."""
    if not file.exists():
        _save(file, asdict(replace(part(), commit=_commit())))
    return Outcome(**json.loads(file.read_text(encoding="utf-8")))


def _save(file: Path, document: object) -> None:
    """Write a result; an interrupted run leaves none rather than half of one."""
    new = file.with_suffix(".new")
    new.write_text(json.dumps(document), encoding="utf-8")
    new.replace(file)


def resumed(keep: Path, sizes: Mapping[str, float]) -> str:
    """Why results in a folder cannot be resumed with these sizes, empty if they can."""
    keep.mkdir(parents=True, exist_ok=True)
    file = keep / "sizes"
    if not file.exists():
        _save(file, sizes)
    if (found := json.loads(file.read_text(encoding="utf-8"))) != sizes:
        return f"{keep}: found results of {found}, expected {dict(sizes)} or another folder"
    return ""


def _commit() -> str:
    """The commit that is checked out, empty if git cannot determine it."""
    command = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()


def _warm(folder: Path) -> None:
    """Import what commands import, once, because every process of the bench is a fork of this one."""
    folder.mkdir()
    writers.old_schemas(folder)
    fieldkit(folder / "ledger.db", "import", str(TABLE), str(LOG), "--set", "rocket=Comet")


def page(found: Sequence[Outcome], command: str, others: int) -> str:
    """The summary, in Markdown."""
    killed = sum(one.tried for one in found if one.part == "kill -9")
    faults = [fault for one in found for fault in one.faults]
    rows = [
        f"| {one.part} | {one.case} | {one.tried or ''} | {_counts(one)} | {len(one.faults)} | {one.commit} |"
        for one in found
    ]
    system = f"Python {platform.python_version()}, SQLite {sqlite3.sqlite_version}, {platform.system()}"
    if commits := list(dict.fromkeys(one.commit for one in found if one.commit)):
        system += f"; of the commits {', '.join(commits)}"
    text = (ROOT / "bench" / "faults" / "page.md").read_text(encoding="utf-8")
    listed = "\n".join(f"- {fault}" for fault in faults[:50]) or "None."
    return text.format(
        command=command, killed=killed, faults=len(faults), rows="\n".join(rows), listed=listed,
        system=system, measured=kills.MEASURED, slow=f"{failing.SLOW:g}",
        reads=failing.MAX_READS, others=others, every=f"{laptops.EVERY:g}",
    )  # fmt: skip


def _counts(one: Outcome) -> str:
    return ", ".join(f"{what}: {number}" for what, number in sorted(one.counts.items()))


@contextmanager
def _scratch() -> Iterator[Path]:
    """A folder in memory if possible, deleted at the end by this process and not by its forks."""
    folder, own = Path(mkdtemp(prefix="faults", dir=MEMORY if MEMORY.is_dir() else None)), os.getpid()
    folder.chmod(0o755)  # the server runs as another user
    try:
        yield folder
    finally:
        if os.getpid() == own:
            shutil.rmtree(folder, ignore_errors=True)


def main() -> int:
    """Run the bench and write the page; the exit status is nonzero if anything was lost."""
    parser = argparse.ArgumentParser(prog="python -m bench.faults", description=__doc__)
    parser.add_argument("--kills", type=int, default=1000, help="how many processes are killed")
    parser.add_argument("--others", type=int, default=96, help="the size of each other part")
    parser.add_argument("--quick", action="store_true", help="a little of everything, and no page")
    parser.add_argument("--keep", type=Path, help="a folder for the result of each part, to resume from")
    parser.add_argument("--out", type=Path, default=PAGE, help="where the page goes")
    parser.add_argument("--minutes", type=float, default=math.inf, help="how long to run, with --keep")
    parser.add_argument(
        "--hours", type=float, default=1.0, help="how long two laptops work on one server at their pace"
    )
    parser.add_argument("--only", default="", help="try the parts whose names begin so, with --keep")
    given = parser.parse_args()
    ends = time.monotonic() + 60 * given.minutes
    if given.quick:
        given.kills, given.others, given.hours = 24, 8, 0.0
    found: list[Outcome] = []
    with _scratch() as scratch, at_home(scratch / "home"):
        keep: Path = given.keep or scratch / "kept"
        if wrong := resumed(keep, {"kills": given.kills, "others": given.others, "hours": given.hours}):
            parser.error(wrong)
        for name, part in parts(scratch, killed=given.kills, others=given.others, hours=given.hours):
            if not name.startswith(given.only):
                continue
            if time.monotonic() > ends:
                break
            outcome = tried(part, keep / f"{name}.json")
            found.append(outcome)
            sys.stderr.write(f"{outcome.part}, {outcome.case}: {_counts(outcome)}; {len(outcome.faults)} faults\n")
            for fault in outcome.faults[:5]:
                sys.stderr.write(f"  {fault}\n")
    if time.monotonic() > ends:
        return 1
    if not given.quick and not given.only:
        sizes = "" if (given.kills, given.others) == (1000, 96) else f" --kills {given.kills} --others {given.others}"
        sizes += "" if given.hours == 1.0 else f" --hours {given.hours:g}"
        given.out.write_text(page(found, f"python -m bench.faults{sizes}", given.others), encoding="utf-8")
    return any(one.faults for one in found)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
