"""Make every system call of every command fail in turn, and run histories of commands with faults among them.

A command must report the truth. After exit status 0 the ledger is as after the command, even if there was a fault;
after any other status it is as before, or as after if the message does not deny it. A history is replayed: the
acknowledged commands, without faults, on another ledger, and both ledgers must be equal.
"""

import os
import random
import shutil
import signal
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import chdir
from pathlib import Path

from bench.faults.calls import GROUPS, HANGS, PATIENCE, TRACEBACK, Ended, Fault, command, faults, forked, made, run_with
from bench.faults.kills import unit
from bench.faults.ledgers import LOG, TABLE, Outcome, State, after, at_home, fieldkit, season, state
from bench.faults.paused import from_first_write
from bench.faults.session import Call, named, new_day, separate
from fieldkit.paths import DATA_FILES

FILES_OF_THE_START = ("ledger.db", "home", "sample_logs", "fieldkit", "docs", "home-backups", "ledger.db-backups")
"""Files that exist in addition to those a command is asked to write."""
OWN = ("settings.json", *(name for name in DATA_FILES if name not in {"captures", "crashes"}))
"""What a user has added and chosen, in the user's folder."""
EVERY = sys.maxsize

SLOW = 1.0
"""A command that takes this long is forked where it first writes, and fewer of its reads fail. [s]"""
PATIENT = 20.0
"""A command that takes so many times as long as without a fault hangs, on a busy machine too. [1]"""
MAX_READS = 64
"""Number of reads of a writing command that fail at most, spread evenly. [1]"""


class Bench:
    """A folder in which a call is run repeatedly; `states` are the ledger before and after it."""

    def __init__(self, folder: Path, call: Call) -> None:
        self.call, self.workplace, self.notes = call, folder / "workplace", folder / "notes"
        self.file = self.workplace / "ledger.db"
        self.states: tuple[State, State] | None = None
        self.asked: dict[str, bytes] = {}
        self.new: set[str] = set()
        """Requested files that the call creates."""
        self.spoken: set[str] = set()
        """Progress output of the call without faults."""
        self.prints = False
        """Whether it prints a result."""
        self.takes = 0.0
        """Duration of the call. [s]"""

    def fresh(self) -> None:
        """Reset the files for the call; the folder itself is not replaced, because a process may be in it."""
        self.workplace.mkdir(parents=True, exist_ok=True)
        for one in self.workplace.iterdir():
            if one.is_dir() and not one.is_symlink():
                shutil.rmtree(one)
            else:
                one.unlink()
        shutil.copytree(self.call.found, self.workplace, symlinks=True, dirs_exist_ok=True)

    def tried(self, fault: Fault | None = None, largest: int | None = None, *, full: bool = False) -> Ended:
        """Run the call, with an optional fault."""
        self.fresh()
        with chdir(self.workplace), at_home(self.workplace / "home"), unit(self.call.arguments) as arguments:
            work = self.call.work(self.file, arguments)
            patience = max(PATIENCE, PATIENT * self.takes)
            return run_with(work, self.workplace, self.notes, fault, largest, full=full, patience=patience)

    def learn(self) -> list[tuple[str, int]]:
        """Record the states before and after the call, and the system calls that it makes."""
        self.fresh()
        with at_home(self.workplace / "home"):
            before = state(self.file)
        found_there = self.files()
        began = time.monotonic()
        ended = self.tried()
        self.spoken, self.prints = set(ended.message.splitlines()), bool(ended.out)
        self.takes = time.monotonic() - began
        found = made(self.notes, self.workplace)
        with at_home(self.workplace / "home"):
            self.states = (before, state(self.file))
        self.asked = self.files()
        self.new = self.asked.keys() - found_there.keys()
        return found

    def from_first_write(self, most: int = EVERY) -> list[tuple[str, str]]:
        """Results of faults from the first write of the call on, at most so many of a kind, and any errors."""

        def trials() -> list[tuple[str, str]] | None:
            if forked(self.workplace, self.notes) is None:
                return None
            chosen = faults(made(self.notes, self.workplace), min(MAX_READS, most), most)
            seen = []
            for fault in chosen:
                self.fresh()
                if (ended := forked(self.workplace, self.notes, fault)) is None:
                    return None
                if ended.came:
                    what, wrong = self.judged(ended)
                    seen.append((what, wrong and f"{fault} from the first write: {wrong}"))
            return seen

        self.fresh()
        with chdir(self.workplace), at_home(self.workplace / "home"), unit(self.call.arguments) as arguments:
            return from_first_write(command(self.file, arguments), self.workplace, trials)

    def files(self) -> dict[str, bytes]:
        """Files next to the ledger: the requested ones, and what the user has added."""
        places = [one for one in self.workplace.iterdir() if one.name not in FILES_OF_THE_START]
        places += [self.workplace / "home" / name for name in OWN]
        files = (one for place in places for one in (place, *place.rglob("*")) if one.is_file())
        return {str(one.relative_to(self.workplace)): one.read_bytes() for one in files}

    def judged(self, ended: Ended) -> tuple[str, str]:
        """Result of a trial, and any error."""
        assert self.states is not None
        with at_home(self.workplace / "home"):
            name, wrong = after(self.file, self.states)
        changes = self.states[0] != self.states[1]
        lines = [line for line in ended.message.splitlines() if line]
        if wrong:
            return name, wrong
        if torn := self.torn():
            return name, torn
        if ended.status == -signal.SIGKILL:
            return "killed, " + (name if changes else "nothing to lose"), ""
        if ended.status == TRACEBACK or "Traceback" in ended.message:
            return name, f"a traceback: {lines[-1] if lines else ''}"
        if ended.status == HANGS:
            return name, "it hangs"
        if ended.status == 0:
            missing = self.new - self.files().keys()
            undone = (changes and name == "before") or missing
            return "finished anyway", f"it said that it was done {' '.join(missing)}".strip() if undone else ""
        if changes and name == "after":
            denied = any("nothing was changed" in line for line in lines)
            return "refused, and done", "it said that nothing was changed" if denied else ""
        lines = [line for line in lines if line not in self.spoken]
        return "refused in a line", "" if len(lines) <= 3 else f"refused in {len(lines)} lines"

    def judged_full(self, ended: Ended) -> tuple[str, str]:
        """Result of a trial whose output could not be written, and any error."""
        what, wrong = self.judged(ended)
        return what, wrong or (
            "its output is lost and it said that it was done" if self.prints and not ended.status else ""
        )

    def torn(self) -> str:
        """A requested file that was written only in part; empty if each is complete or missing."""
        for name, content in self.files().items():
            whole = self.asked.get(name)
            if Path(name).name.startswith("."):
                continue
            if whole is not None and len(content) < len(whole) and whole.startswith(content):
                return f"{name} is there in part"
        return ""


def every_call(folder: Path, name: str, session: Callable[[], Sequence[Call]], few: int, most: int = EVERY) -> Outcome:
    """The lines of the session for one command, with each of their system calls failing.

    `few` limits the calls of each kind in lines that only read, take long or wait for a logger, `most` in all lines.
    """
    outcome = Outcome("a call fails", name)
    mine = [call for call in session() if named(call.arguments) == name]
    for number, call in enumerate(mine):
        _each(outcome, Bench(folder / str(number), call), few, most)
        shutil.rmtree(folder / str(number), ignore_errors=True)
    if not mine:
        outcome.faults.append("no example calls it")
    return outcome


def on_a_new_day(folder: Path, few: int, most: int = EVERY) -> Outcome:
    """Calls that make the first backup of a day, with each of their system calls failing, as in `every_call`."""
    outcome = Outcome("a call fails", "add and capture with the backup of a new day")
    with at_home(folder / "home"):
        some = new_day(folder / "found")
    for number, call in enumerate(some):
        _each(outcome, Bench(folder / str(number), call), few, most)
    return outcome


def in_its_own_process(folder: Path, name: str, few: int, most: int = EVERY) -> Outcome:
    """A command of `SEPARATE`, with each of its system calls failing, as in `every_call`."""
    outcome = Outcome("a call fails", name)
    with at_home(folder / "home"):
        (call,) = separate(folder / "found", name)
    _each(outcome, Bench(folder / "0", call), few, most)
    return outcome


def _each(outcome: Outcome, bench: "Bench", few: int, most: int) -> None:
    found, line = bench.learn(), bench.call.line
    size = bench.file.stat().st_size
    writes = any(one in GROUPS["write"] for one, _ in found)
    waits, slow = "PORT" in bench.call.arguments or bench.call.separate, bench.takes > SLOW
    some = few if waits or slow or not writes else MAX_READS
    for fault in faults(found, min(some, most), min(few if waits else 0 if slow else EVERY, most)):
        ended = bench.tried(fault)
        if ended.came:
            what, wrong = bench.judged(ended)
            outcome.saw(what, wrong and f"{line}: {fault}: {wrong}")
    if writes and slow and not waits:
        for what, wrong in bench.from_first_write(most):
            outcome.saw(what, wrong and f"{line}: {wrong}")
    what, wrong = bench.judged_full(bench.tried(full=True))
    outcome.saw(f"output full: {what}", wrong and f"{line}: output full: {wrong}")
    shorts = max(1, few // 4) if slow else few
    for largest in [place * size // shorts for place in range(shorts)] if writes else []:
        what, wrong = bench.judged(bench.tried(largest=largest))
        outcome.saw(f"short: {what}", wrong and f"{line}: no file above {largest} bytes: {wrong}")


HISTORY = (
    ("add", "--rocket", "Astra", "--config", "A", "--motor", "F24-4W", "--dry-mass", "322g", "--apogee", "{number}ft"),
    ("import", str(TABLE)),
    ("import", str(LOG), "--set", "rocket=Comet"),
    ("edit", "3", "apogee={number}ft"),
    ("tag", "4", "mine{number}"),
    ("untag", "4", "mine{number}"),
    ("remove", "{flight}"),
    ("undo",),
    ("redo",),
    ("model", "--rocket", "Astra", "--use", "0"),
    ("sites", "North field", "--elevation", "{number}m"),
)
"""Commands of a history; each makes a different kind of change."""


def history(folder: Path, steps: int, seed: int) -> Outcome:
    """A history of commands, with some calls failing, and its replay on a ledger without faults."""
    outcome, rng = Outcome("a call fails", f"histories of {steps} commands, replayed"), random.Random(seed)
    workplace, notes, clean = folder / "workplace", folder / "notes", folder / "clean" / "ledger.db"
    clean.parent.mkdir(parents=True)
    workplace.mkdir()
    file = workplace / "ledger.db"
    with at_home(folder / "home"):
        for one in (file, clean):
            season(one)
        for step in range(steps):
            arguments = _drawn(rng, step)
            before = state(clean)
            fault = Fault(*rng.choice(KINDS), rng.choice(("error=EIO", "error=ENOSPC", "signal=SIGKILL")))
            ended = run_with(command(file, arguments), workplace, notes, fault)
            now = state(file)
            fieldkit(clean, *arguments)
            done = state(clean)
            applied = now == done
            if not applied:
                _put_back(clean, file)  # it was not done: both continue from the same state
            wrong = "" if applied or now == before else "neither as before nor as replayed"
            if ended.status == 0 and not applied:
                wrong = wrong or "acknowledged, and not in the replay"
            if ended.status == TRACEBACK:
                wrong = wrong or f"a traceback: {ended.message.strip()[-200:]}"
            what = "acknowledged" if ended.status == 0 else "killed" if ended.status < 0 else "refused"
            outcome.saw(
                f"{what}, {'replayed' if applied else 'as before'}",
                wrong and f"{' '.join(arguments)}: {fault}: {wrong}",
            )
    return outcome


KINDS: Sequence[tuple[str, int]] = (
    *(("pwrite64", number) for number in range(1, 25)),
    *(("fdatasync", number) for number in range(1, 7)),
    *(("fsync", number) for number in range(1, 5)),
    *(("unlink", number) for number in range(1, 4)),
    *(("pread64", number) for number in range(1, 80, 4)),
)
"""Calls of a history that fail: name and number."""


def _drawn(rng: random.Random, step: int) -> list[str]:
    values = {"number": 500 + step, "flight": rng.randrange(1, 13)}
    arguments = [part.format(**values) for part in rng.choice(HISTORY)]
    dated = ["--date-time", f"2026-05-02T{step // 60 % 24:02}:{step % 60:02}"] if arguments[0] == "add" else []
    return [*arguments, *dated]


def _put_back(clean: Path, file: Path) -> None:
    """Set the ledger of the replay to the other ledger."""
    for end in ("-journal",):
        clean.with_name(clean.name + end).unlink(missing_ok=True)
    shutil.copyfile(file, clean)
    os.sync()
