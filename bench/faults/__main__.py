"""The whole fault bench: `python -m bench.faults`, which writes docs/faults.md; `--quick` tries everything a little.

It runs for about ten minutes; `nice -n 19` leaves the cores to others.
"""

import argparse
import os
import platform
import shutil
import sqlite3
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import mkdtemp

from bench.faults import damage, discs, kills, servers, writers
from bench.faults.ledgers import LOG, ROOT, TABLE, Outcome, at_home, fieldkit

PAGE = ROOT / "docs" / "faults.md"
SEED = 8
MEMORY = Path("/dev/shm")
"""A file system in memory, where there is one: what is killed is a process and not the machine, so that nothing hangs
on what has reached a disc, and waiting for one would be most of the time."""


def outcomes(scratch: Path, *, killed: int, others: int) -> Iterator[Outcome]:
    """Every part of the bench, one after the other; `killed` kills in all, `others` the size of each other part."""
    _warm(scratch / "warm")
    folders = (scratch / str(number) for number in range(1000))
    share, rest = divmod(killed, len(kills.CASES))
    for place, case in enumerate(kills.CASES):
        yield kills.kills(case, next(folders), share + (place < rest), SEED + place)
    if discs.can_mount():
        yield discs.full_disc(next(folders), step=max(1, 64 // others))
        yield discs.read_only(next(folders))
    else:
        yield Outcome("full disc, read-only file system", "skipped: mounting a small file system takes root")
    yield writers.two_commands(next(folders), others // 4)
    yield writers.app_and_command(next(folders), others // 4)
    yield writers.clock_backwards(next(folders), 15)
    yield writers.old_schemas(next(folders))
    yield damage.cut_short(next(folders), others, SEED)
    yield damage.bits_flipped(next(folders), 2 * others, SEED)
    if not servers.binaries():
        yield Outcome("PostgreSQL", "skipped: there is no PostgreSQL on this machine")
        return
    with servers.server(scratch / "server") as ours:
        for of_the_server in (False, True):
            for name in servers.COMMANDS:
                yield servers.crashes(ours, name, max(1, others // 16), SEED, of_the_server=of_the_server)


def _warm(folder: Path) -> None:
    """Import what commands import, once: every process of the bench is a fork of this one."""
    folder.mkdir()
    writers.old_schemas(folder)
    fieldkit(folder / "ledger.db", "import", str(TABLE), str(LOG), "--set", "rocket=Comet")


def page(found: Sequence[Outcome], command: str, seconds: float) -> str:
    """The summary, in Markdown."""
    killed = sum(one.tried for one in found if one.part == "kill -9")
    faults = [fault for one in found for fault in one.faults]
    rows = [f"| {one.part} | {one.case} | {one.tried or ''} | {_counts(one)} | {len(one.faults)} |" for one in found]
    system = f"Python {platform.python_version()}, SQLite {sqlite3.sqlite_version}, {platform.system()}"
    text = (ROOT / "bench" / "faults" / "page.md").read_text(encoding="utf-8")
    listed = "\n".join(f"- {fault}" for fault in faults[:50]) or "None."
    return text.format(
        command=command, killed=killed, faults=len(faults), rows="\n".join(rows), listed=listed,
        system=system, minutes=f"{seconds / 60:.0f}", measured=kills.MEASURED,
    )  # fmt: skip


def _counts(one: Outcome) -> str:
    return ", ".join(f"{what}: {number}" for what, number in sorted(one.counts.items()))


def main() -> int:
    """Run the bench, write the page, and say by the exit status whether anything was lost."""
    parser = argparse.ArgumentParser(prog="python -m bench.faults", description=__doc__)
    parser.add_argument("--kills", type=int, default=1000, help="how many processes are killed")
    parser.add_argument("--others", type=int, default=96, help="the size of each other part")
    parser.add_argument("--quick", action="store_true", help="a little of everything, and no page")
    parser.add_argument("--out", type=Path, default=PAGE, help="where the page goes")
    given = parser.parse_args()
    if given.quick:
        given.kills, given.others = 24, 8
    where = MEMORY if MEMORY.is_dir() else None
    scratch, found, began = Path(mkdtemp(prefix="faults", dir=where)), [], time.monotonic()
    scratch.chmod(0o755)  # the server is another user
    with at_home(scratch / "home"):
        for outcome in outcomes(scratch, killed=given.kills, others=given.others):
            found.append(outcome)
            sys.stderr.write(f"{outcome.part}, {outcome.case}: {_counts(outcome)}; {len(outcome.faults)} faults\n")
            for fault in outcome.faults[:5]:
                sys.stderr.write(f"  {fault}\n")
    shutil.rmtree(scratch, ignore_errors=True)
    if not given.quick:
        options = (
            "" if given.kills == 1000 and given.others == 96 else f" --kills {given.kills} --others {given.others}"
        )
        given.out.write_text(
            page(found, f"python -m bench.faults{options}", time.monotonic() - began), encoding="utf-8"
        )
    return any(one.faults for one in found)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
