"""The whole fault bench: `python -m bench.faults`, which writes docs/faults.md; `--quick` runs a few trials of
everything.

It runs for about an hour: two laptops at a realistic pace on a server of their own, and beside them all other parts.
`nice -n 19` leaves the cores to others, `--keep FOLDER` resumes an interrupted run, and `--only` runs the parts whose
names start with a text and writes no page. The page describes one commit: it is written only if the checkout matches
that commit at the start and at the end, and results in a folder are resumed only by the same commit.
"""

import argparse
import json
import multiprocessing
import os
import platform
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from tempfile import mkdtemp

from bench.faults import (
    calls,
    clocks,
    damage,
    discs,
    failing,
    histories,
    hostile,
    kills,
    laptops,
    servers,
    session,
    statements,
    writers,
)
from bench.faults.ledgers import LOG, ROOT, TABLE, Outcome, at_home, fieldkit

PAGE = ROOT / "docs" / "faults.md"
CALLS = "a call fails"
"""The part in which system calls of a command fail."""
SEED = 8
KILLS = 60
"""Number of kills for the page. [1]"""
OTHERS = 8
"""Size of each other part for the page. [1]"""
MEMORY = Path("/dev/shm")
"""A file system in memory, if there is one: processes are killed, not the machine, so the results do not depend on what
has reached a disk, and waiting for a disk would take most of the time."""
HOURLY_KILLS = 12
"""Number of times per hour that the server of two laptops is killed. [1]"""

Part = tuple[str, Callable[[], Outcome]]


def parts(scratch: Path, *, killed: int, others: int, calls_each: int) -> Iterator[Part]:
    """Every part of the bench but `club`, run one after the other; `killed` is the total number of kills, `others` the
    size of each other part, `calls_each` the number of a command's calls of each kind that fail, at most."""
    folders = (scratch / str(number) for number in range(1000))
    each, rest = divmod(killed, len(kills.CASES))
    for place, case in enumerate(kills.CASES):
        number = each + (place < rest)
        yield f"kill_{case.name}", partial(kills.kills, case, next(folders), number, SEED + place)
    if discs.can_mount():
        yield "full_disc", partial(discs.full_disc, next(folders), step=max(1, 64 // others))
        yield "read_only", partial(discs.read_only, next(folders))
    else:
        missing = Outcome("full disk, read-only file system", "skipped: mounting a small file system takes root")
        yield "discs", lambda: missing
    yield from _of_calls(scratch / "calls", others, calls_each)
    yield "two_commands", partial(writers.two_commands, next(folders), others // 4)
    yield "apps_and_commands", partial(writers.apps_and_commands, next(folders), others // 4)
    yield "restores", partial(histories.restores_beside_writers, next(folders), 5, 2 * others, max(2, others // 4))
    yield "clock_set_back", partial(clocks.set_back, next(folders))
    yield "zones", partial(clocks.zones, next(folders))
    yield "old_schemas", partial(writers.old_schemas, next(folders))
    yield "concurrent_migrations", partial(writers.concurrent_migrations, next(folders), 4)
    yield "hostile_files", partial(hostile.objects, next(folders))
    yield "hostile_modes", partial(hostile.modes, next(folders))
    yield "cut_short", partial(damage.cut_short, next(folders), others, SEED)
    yield "bits_flipped", partial(damage.bits_flipped, next(folders), 2 * others, SEED)
    yield from _of_a_server(scratch / "server", max(3, others // 16))


def _of_calls(folder: Path, others: int, most: int) -> Iterator[Part]:
    """System calls that fail, for every command of the tree."""
    if not calls.can_trace():
        yield "calls", lambda: Outcome("a call fails", "skipped: there is no strace on this machine")
        return

    @cache
    def found() -> list[session.Call]:
        with at_home(folder / "workplace" / "home"):
            return session.calls(folder)

    for number, name in enumerate(session.commands()):
        if name in session.LEFT_OUT:
            left = Outcome("a call fails", f"{name}: not tried, {session.LEFT_OUT[name]}")
            yield f"fails_{name}", partial(lambda outcome: outcome, left)
            continue
        there = folder / "trials" / str(number)
        if name in session.SEPARATE:
            yield f"fails_{name}", partial(failing.in_its_own_process, there, name, others, most)
        else:
            yield f"fails_{name}", partial(failing.every_call, there, name, found, others, most)
    new_day = folder / "new_day"
    yield "fails_on_a_new_day", partial(failing.on_a_new_day, new_day, others, most)
    yield "fails_histories", partial(failing.history, folder / "histories", 2 * others, SEED)


def _of_a_server(folder: Path, trials: int) -> Iterator[Part]:
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
        for seed in range(trials // 3):
            yield (
                f"postgres_failover_{seed}",
                partial(laptops.failed_over, ours, beside(f"over{seed}"), 2, commands, seed),
            )
        yield "postgres_statements", partial(statements.process_killed, ours.url, range(1, 2 + 2 * trials))


def club(folder: Path, hours: float) -> Outcome:
    """Two laptops that work on a server of their own at a realistic pace, for `hours` [h]."""
    commands, killed = round(hours * laptops.HOUR), max(1, round(HOURLY_KILLS * hours))
    with at_home(folder / "home"), servers.server(folder / "server") as ours:
        return laptops.mixed_work(ours, folder / "work", 2, commands, killed, SEED, laptops.EVERY)


@contextmanager
def beside(part: Callable[[], Outcome], file: Path) -> Iterator[Callable[[], Outcome]]:
    """A part that runs in a process of its own during the block; call the returned function to wait for its result.

    The process ends with the block. Raises RuntimeError if it ended without a result.
    """

    def work() -> None:
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that a server is stopped too
        tried(part, file)

    process = multiprocessing.get_context("fork").Process(target=work)
    process.start()

    def result() -> Outcome:
        process.join()
        if process.exitcode:
            raise RuntimeError(f"{file.stem}: ended with exit status {process.exitcode}")
        return tried(part, file)

    try:
        yield result
    finally:
        process.terminate()
        process.join()


def tried(part: Callable[[], Outcome], file: Path) -> Outcome:
    """Result of a part, computed now or saved in this file by an earlier run."""
    if not file.exists():
        _save(file, asdict(part()))
    return Outcome(**json.loads(file.read_text(encoding="utf-8")))


def _save(file: Path, document: object) -> None:
    """Write a result; an interrupted run leaves none rather than half of one."""
    new = file.with_suffix(".new")
    new.write_text(json.dumps(document), encoding="utf-8")
    new.replace(file)


def resumed(keep: Path, run: Mapping[str, object]) -> str:
    """Why results in a folder cannot be resumed by a run of this commit and these sizes, empty if they can."""
    keep.mkdir(parents=True, exist_ok=True)
    file = keep / "run"
    if not file.exists():
        _save(file, run)
    if (found := json.loads(file.read_text(encoding="utf-8"))) != run:
        return f"{keep}: found results of {found}, expected {dict(run)} or another folder"
    return ""


def commit(root: Path = ROOT) -> str:
    """The commit that is checked out; empty if a file of the checkout differs from it, or if there is none.

    The page itself does not count, as it is what the bench writes.
    """
    changed = _git(root, "status", "--porcelain", "--", ".", f":!{PAGE.relative_to(ROOT)}")
    return "" if changed is None or changed else _git(root, "rev-parse", "--short", "HEAD") or ""


def _git(root: Path, *arguments: str) -> str | None:
    """Output of git; None if it failed."""
    done = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True)
    return None if done.returncode else done.stdout.strip()


def _warm(folder: Path) -> None:
    """Import what commands import, once, because every process of the bench is a fork of this one."""
    folder.mkdir()
    writers.old_schemas(folder)
    fieldkit(folder / "ledger.db", "import", str(TABLE), str(LOG), "--set", "rocket=Comet")


def page(found: Sequence[Outcome], command: str, of: str, others: int, calls_each: int = failing.EVERY) -> str:
    """The summary, in Markdown; `of` is the tested commit."""
    limited = "" if calls_each == failing.EVERY else f", at most {calls_each} of each kind, spread evenly"
    killed = sum(one.tried for one in found if one.part == "kill -9")
    faults = [fault for one in found for fault in one.faults]
    rows = [
        f"| {one.part} | {one.case} | {one.tried or ''} | {_counts(one)} | {len(one.faults)} |"
        for one in _by_command(found)
    ]
    system = f"Python {platform.python_version()}, SQLite {sqlite3.sqlite_version}, {platform.system()}"
    text = (ROOT / "bench" / "faults" / "page.md").read_text(encoding="utf-8")
    listed = "\n".join(f"- {fault}" for fault in faults[:50]) or "None."
    return text.format(
        command=command, commit=of, killed=killed, faults=len(faults), rows="\n".join(rows), listed=listed,
        system=system, measured=kills.MEASURED, slow=f"{failing.SLOW:g}",
        reads=min(failing.MAX_READS, calls_each), limited=limited, others=others,
    )  # fmt: skip


def _by_command(found: Sequence[Outcome]) -> Iterator[Outcome]:
    """The results with those of commands whose calls fail in one row, after the commands that were not tried."""
    failing_calls = [one for one in found if one.part == CALLS and one.tried]
    yield from (one for one in found if one.part != CALLS or not one.tried)
    if failing_calls:
        counts = sum((Counter(one.counts) for one in failing_calls), Counter[str]())
        faults = [fault for one in failing_calls for fault in one.faults]
        commands = f"{len(failing_calls)} commands and histories of commands"
        yield Outcome(CALLS, commands, sum(one.tried for one in failing_calls), dict(counts), faults)


def _counts(one: Outcome) -> str:
    return "; ".join(f"{what}: {number}" for what, number in sorted(one.counts.items()))


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


def run(scratch: Path, keep: Path, given: argparse.Namespace) -> list[Outcome]:
    """Results of the chosen parts; each is saved in the folder `keep` when it is done."""
    _warm(scratch / "warm")
    found: list[Outcome] = []
    with ExitStack() as stack:
        hour = None
        if given.hours and servers.binaries() and "club".startswith(given.only):
            hour = stack.enter_context(beside(partial(club, scratch / "club", given.hours), keep / "club.json"))
        for name, part in parts(scratch, killed=given.kills, others=given.others, calls_each=given.calls):
            if name.startswith(given.only):
                found.append(_printed(tried(part, keep / f"{name}.json")))
        if hour is not None:
            found.append(_printed(hour()))
    return found


def _printed(outcome: Outcome) -> Outcome:
    """Print a result as progress, with the processor time so far, without that of `club` and of servers."""
    now, used = time.strftime("%H:%M:%S"), sum(os.times()[:4])
    what = f"{outcome.part}, {outcome.case}: {_counts(outcome)}; {len(outcome.faults)} faults"
    sys.stderr.write(f"{now}, {used:.0f} s of processor time: {what}\n")
    for fault in outcome.faults[:5]:
        sys.stderr.write(f"  {fault}\n")
    return outcome


def main() -> int:
    """Run the bench and write the page; the exit status is nonzero if anything was lost."""
    parser = argparse.ArgumentParser(prog="python -m bench.faults", description=__doc__)
    parser.add_argument("--kills", type=int, default=KILLS, help="how many processes are killed")
    parser.add_argument("--others", type=int, default=OTHERS, help="the size of each other part")
    parser.add_argument(
        "--calls", type=int, default=failing.EVERY, help="how many calls of each kind fail in a command (default: all)"
    )
    parser.add_argument("--quick", action="store_true", help="a little of everything, and no page")
    parser.add_argument("--keep", type=Path, help="a folder for the result of each part, to resume from")
    parser.add_argument("--out", type=Path, default=PAGE, help="where the page goes")
    parser.add_argument(
        "--hours", type=float, default=1.0, help="how long two laptops work on one server at their pace"
    )
    parser.add_argument("--only", default="", help="try the parts whose names begin so, and write no page")
    given = parser.parse_args()
    if given.quick:
        given.kills, given.others, given.hours = 24, OTHERS, 0.0
    paged, of = not given.quick and not given.only, commit()
    if paged and not of:
        parser.error("the page is of one commit: found changed files or no commit; --quick and --only write no page")
    with _scratch() as scratch, at_home(scratch / "home"):
        keep: Path = given.keep or scratch / "kept"
        sizes = {"kills": given.kills, "others": given.others, "calls": given.calls, "hours": given.hours}
        if wrong := resumed(keep, {"commit": of, **sizes}):
            parser.error(wrong)
        found = run(scratch, keep, given)
    if paged and commit() != of:
        parser.error(f"no page: the files are no longer those of commit {of}")
    if paged:
        usual = {"kills": KILLS, "others": OTHERS, "calls": failing.EVERY, "hours": 1.0}
        options = "".join(f" --{name} {size:g}" for name, size in sizes.items() if size != usual[name])
        given.out.write_text(
            page(found, f"python -m bench.faults{options}", of, given.others, given.calls), encoding="utf-8"
        )
    return any(one.faults for one in found)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
