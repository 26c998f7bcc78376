"""Locks, companions and modes that nobody would want: every command ends, does its work or says why not, and writes
nothing where it should not.

Root may write anything, so the commands run without that capability.
"""

import ctypes
import fcntl
import os
from collections.abc import Callable, Mapping
from pathlib import Path

from bench.faults.calls import HANGS, TRACEBACK, command, run_with
from bench.faults.kills import ADD
from bench.faults.ledgers import ROOT, Outcome, after, at_home, fieldkit, season, state
from fieldkit.paths import LOCK_NAME

COMMANDS: tuple[tuple[str, ...], ...] = (
    ("flights",),
    ADD,
    ("tag", "1", "mine"),
    ("undo",),
    ("kits", "Big Bertha", "--dry-mass", "80g", "--diameter", "41.6mm"),
    ("units", "US"),
    ("motors", "--import", str(ROOT / "bench" / "faults" / "samples" / "own.eng")),
    ("backups", "restore", "1", "--yes"),
)
TARGET = b"a file of somebody else"
_CAN_WRITE_ANYTHING = 0b110
"""The capabilities CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH of Linux, as bits."""
_CAPABILITIES_VERSION = 0x20080522


def _link_to(place: Callable[[Path], Path]) -> Callable[[Path], None]:
    return lambda file: file.symlink_to(place(file))


def _held(file: Path) -> None:
    """A lock that this process holds until the file of the number beside it is closed."""
    number = os.open(file, os.O_RDWR | os.O_CREAT)
    fcntl.flock(number, fcntl.LOCK_EX)
    file.with_name("holder").write_text(str(number))


OBJECTS: Mapping[str, Callable[[Path], None]] = {
    "a folder": lambda file: file.mkdir(),
    "a pipe": lambda file: os.mkfifo(file),
    "a link to another file": _link_to(lambda file: file.parents[1] / "target"),
    "a link to nothing": _link_to(lambda file: file.parents[1] / "nothing"),
    "a link to itself": _link_to(lambda file: file),
    "a link to a full device": _link_to(lambda _: Path("/dev/full")),
    "unreadable": lambda file: file.touch(mode=0),
}
"""What a path of a lock or a companion may be, and how it is made."""
PLACES = (
    f"home/{LOCK_NAME}",
    "data/ledger.db-journal",
    "home/settings.json",
    "home/kits.toml",
    "home/motors/own.eng",
    "data/ledger.db-backups",
)
MODES = (
    ("data/ledger.db", 0),
    ("data/ledger.db", 0o444),
    ("data", 0),
    ("data", 0o555),
    ("home", 0),
    ("home", 0o555),
    ("data/ledger.db-backups", 0),
    ("data/ledger.db-backups", 0o555),
)
"""Paths and what everyone may do with them."""


def objects(folder: Path) -> Outcome:
    """Every object at every place, and a lock that another program never gives back."""
    outcome = Outcome("hostile files", f"{', '.join(OBJECTS)} in place of {', '.join(PLACES)}; a held lock")
    for number, (what, made) in enumerate((*OBJECTS.items(), ("held", _held))):
        for place in PLACES if what != "held" else PLACES[:1]:

            def hostile(root: Path, place: str = place, made: Callable[[Path], None] = made) -> None:
                _removed(root / place)
                (root / place).parent.mkdir(exist_ok=True)
                made(root / place)

            for turn, arguments in enumerate(COMMANDS):
                there = folder / f"{number}-{PLACES.index(place)}-{turn}"
                _try(outcome, there, hostile, arguments, f"{place} is {what}")
    return outcome


def modes(folder: Path) -> Outcome:
    """Every command with every mode."""
    listed = ", ".join(f"{place} {mode:03o}" for place, mode in MODES)
    outcome = Outcome("hostile modes", listed)
    for number, (place, mode) in enumerate(MODES):
        for turn, arguments in enumerate(COMMANDS):

            def hostile(root: Path, place: str = place, mode: int = mode) -> None:
                (root / place).mkdir(exist_ok=True) if place.endswith("backups") else None
                (root / place).chmod(mode)

            _try(outcome, folder / f"{number}-{turn}", hostile, arguments, f"{place} has the mode {mode:03o}")
    return outcome


def _try(
    outcome: Outcome, folder: Path, hostile: Callable[[Path], None], arguments: tuple[str, ...], what: str
) -> None:
    """One command in a folder that was made hostile."""
    home, file = folder / "home", folder / "data" / "ledger.db"
    for one in (home, file.parent):
        one.mkdir(parents=True)
    target = folder / "target"
    target.write_bytes(TARGET)
    with at_home(home):
        season(file)
        assert fieldkit(file, "tag", "2", "mine")[0] == 0
        before = state(file)
        hostile(folder)
        ended = run_with(_without_rights(command(file, arguments)), folder, folder / "notes", largest=1 << 40)
        _made_harmless(folder, home)
        name, wrong = after(file, (before, before))
    lines = [line for line in ended.message.splitlines() if line and not line.startswith(("note:", "warning:"))]
    if ended.status == 0 or name == "half":
        wrong = ""  # it did its work; what it did is compared where nothing is hostile
    if ended.status == HANGS:
        wrong = "it hangs"
    elif ended.status == TRACEBACK or "Traceback" in ended.message:
        wrong = f"a traceback: {lines[-1] if lines else ''}"
    elif ended.status and (name == "half" or not 1 <= len(lines) <= 3):
        wrong = wrong or ("it was refused and changed something" if name == "half" else f"{len(lines)} lines")
    if target.read_bytes() != TARGET or (folder / "nothing").exists():
        wrong = wrong or "it wrote where a link leads"
    outcome.saw("refused in a line" if ended.status else "done", wrong and f"{' '.join(arguments)}: {what}: {wrong}")


def _made_harmless(folder: Path, home: Path) -> None:
    """Allow everything again, release a held lock and remove hostile objects, so that the ledger can be read."""
    if (home / "holder").exists():
        os.close(int((home / "holder").read_text()))
    for place, _ in MODES:
        if (folder / place).exists():
            (folder / place).chmod(0o755)
    for place in PLACES:
        there = folder / place
        if there.is_symlink() or not (there.is_file() or place.endswith("backups")):
            _removed(there)


def _removed(place: Path) -> None:
    """Delete a file, a link, or a folder with files."""
    if place.is_dir() and not place.is_symlink():
        for one in place.iterdir():
            one.unlink()
        place.rmdir()
    else:
        place.unlink(missing_ok=True)


def _without_rights(work: Callable[[], int]) -> Callable[[], int]:
    """Some work by a root user who may not write what its mode forbids."""

    def done() -> int:
        if os.geteuid() == 0:
            libc = ctypes.CDLL(None, use_errno=True)
            header = (ctypes.c_uint32 * 2)(_CAPABILITIES_VERSION, 0)
            sets = (ctypes.c_uint32 * 6)()
            assert libc.capget(header, sets) == 0
            sets[0] &= ~_CAN_WRITE_ANYTHING
            assert libc.capset(header, sets) == 0
        return work()

    return done
