"""Full disks and read-only file systems, with a small tmpfs mounted for each, which requires root."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bench.faults.ledgers import LOG, TABLE, Outcome, after, fieldkit, put, season, state

SIZE = 1 << 20
"""Size of the mounted file system. [byte]"""
PAGE = 4096
"""Page size of a tmpfs: its free space is a multiple of it. [byte]"""


def can_mount() -> bool:
    """Whether this process may mount a file system."""
    return hasattr(os, "geteuid") and os.geteuid() == 0 and Path("/bin/mount").exists()


@contextmanager
def mounted(folder: Path) -> Iterator[Path]:
    """A small in-memory file system, mounted at a folder. Raises CalledProcessError if not allowed."""
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)], check=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def full_disc(folder: Path, step: int = 4) -> Outcome:
    """Import onto a disk with 0, `step`, 2 `step`, ... free pages, until an import succeeds with its backup."""
    outcome = Outcome("full disk", "import")
    arguments = ("import", str(TABLE), str(LOG), "--set", "rocket=Comet")
    with mounted(folder / "small") as small:
        template, file, filler = folder / "template.db", small / "ledger.db", small / "filler"
        season(template)
        put(template, file)
        before = state(file)
        assert fieldkit(file, *arguments)[0] == 0
        states = (before, state(file))
        for free in range(0, SIZE // PAGE, step):
            _empty(small)
            put(template, file)
            _fill(filler, free * PAGE)
            status, _, message = fieldkit(file, *arguments)
            filler.unlink()
            _judge(outcome, file, states, status, message, "the disk is full")
            if not status and "warning" not in message:
                break
    return outcome


def read_only(folder: Path) -> Outcome:
    """Every kind of command on a file system that has become read-only."""
    outcome = Outcome("read-only file system", "flights, add, undo, import")
    with mounted(folder / "fixed") as fixed:
        file = fixed / "ledger.db"
        season(file)
        before = state(file)
        subprocess.run(["mount", "-o", "remount,ro", str(fixed)], check=True)
        for arguments in (
            ("flights",),
            ("undo",),
            ("import", str(TABLE)),
            ("add", "--rocket", "Astra", "--apogee", "100m"),
        ):
            status, out, message = fieldkit(file, *arguments)
            if arguments == ("flights",):
                outcome.saw("read", "" if not status and "Astra" in out else f"flights: {message}")
            else:
                _judge(outcome, file, (before, before), status, message, "the ledger is read-only")
    return outcome


def _judge(outcome: Outcome, file: Path, states: tuple[object, object], status: int, message: str, why: str) -> None:
    """Check that a command did its work or reports the reason in one line, and that the ledger matches its status."""
    name, wrong = after(file, states)  # type: ignore[arg-type]
    if status and why not in message:
        wrong = wrong or f"found {message!r}, expected {why!r}"
    lines = [line for line in message.splitlines() if not line.startswith(("note:", "warning:"))]
    if status and len(lines) != 1:
        wrong = wrong or f"found {len(lines)} lines"
    if status and name == "after" and states[0] != states[1]:
        wrong = wrong or "it was refused and is there"
    outcome.saw(
        "refused in a line" if status else "done, no room for a backup" if "warning" in message else "done", wrong
    )


def _empty(small: Path) -> None:
    subprocess.run(["find", str(small), "-mindepth", "1", "-delete"], check=True)


def _fill(filler: Path, free: int) -> None:
    """Fill a disk except for `free` bytes."""
    room = os.statvfs(filler.parent)
    filler.write_bytes(bytes(max(0, room.f_bavail * room.f_frsize - free)))
