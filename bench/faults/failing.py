"""Every call of every command gone wrong in turn, and histories of commands with faults among them.

What a command says must be so: after an exit status of 0 the ledger is as after the command, also if a fault came;
after any other it is as before, or as after and the line does not deny it. A history is replayed: what was
acknowledged, without a fault on a ledger of its own, and the two must hold the same.
"""

import os
import random
import shutil
import signal
import time
from collections.abc import Callable, Sequence
from contextlib import chdir
from pathlib import Path

from bench.faults.calls import GROUPS, TRACEBACK, Ended, Fault, command, faults, made, run_with
from bench.faults.kills import unit
from bench.faults.ledgers import LOG, TABLE, Outcome, State, after, at_home, fieldkit, season, state
from bench.faults.session import Call, named

KEPT_FILES = ("ledger.db", "home", "sample_logs", "fieldkit", "home-backups", "ledger.db-backups")
"""What stands beside the files that a command is asked to write."""


SLOW = 3.0
"""Of a command that takes this long, with looking at its ledger, one call of each kind goes wrong. [s]"""


class Bench:
    """A desk on which one call is tried again and again; `states` are the ledger before and after it."""

    def __init__(self, folder: Path, call: Call) -> None:
        self.call, self.desk, self.notes = call, folder / "desk", folder / "notes"
        self.file = self.desk / "ledger.db"
        self.states: tuple[State, State] | None = None
        self.asked: dict[str, bytes] = {}
        self.spoken: set[str] = set()
        """What the call says if nothing is wrong: how far it is."""

    def fresh(self) -> None:
        """The desk as the call finds it."""
        shutil.rmtree(self.desk, ignore_errors=True)
        shutil.copytree(self.call.found, self.desk, symlinks=True)

    def tried(self, fault: Fault | None = None, largest: int | None = None) -> Ended:
        """The call, with a fault in it."""
        self.fresh()
        with chdir(self.desk), at_home(self.desk / "home"), unit(self.call.arguments) as arguments:
            return run_with(command(self.file, arguments), self.desk, self.notes, fault, largest)

    def learn(self) -> list[tuple[str, int]]:
        """The states before and after the call, and the system calls that it makes."""
        self.fresh()
        with at_home(self.desk / "home"):
            before = state(self.file)
        self.spoken = set(self.tried().said.splitlines())
        found = made(self.notes, self.desk)
        with at_home(self.desk / "home"):
            self.states = (before, state(self.file))
        self.asked = self.files()
        return found

    def files(self) -> dict[str, bytes]:
        """What stands beside the ledger: the files that were asked for."""
        return {
            one.name: one.read_bytes() for one in self.desk.iterdir() if one.name not in KEPT_FILES and one.is_file()
        }

    def judged(self, ended: Ended) -> tuple[str, str]:
        """What came of a trial, and what is wrong with it."""
        assert self.states is not None
        with at_home(self.desk / "home"):
            name, wrong = after(self.file, self.states)
        changes = self.states[0] != self.states[1]
        lines = [line for line in ended.said.splitlines() if line]
        if wrong:
            return name, wrong
        if torn := self.torn():
            return name, torn
        if ended.status == -signal.SIGKILL:
            return "killed, " + (name if changes else "nothing to lose"), ""
        if ended.status == TRACEBACK or "Traceback" in ended.said:
            return name, f"a traceback: {lines[-1] if lines else ''}"
        if ended.status == 0:
            return "finished anyway", "it said that it was done" if changes and name == "before" else ""
        if changes and name == "after":
            denied = any("nothing was changed" in line for line in lines)
            return "refused, and done", "it said that nothing was changed" if denied else ""
        lines = [line for line in lines if line not in self.spoken]
        return "refused in a line", "" if len(lines) <= 3 else f"refused in {len(lines)} lines"

    def torn(self) -> str:
        """The file that was asked for and is there in part; empty if each is whole or not there."""
        for name, content in self.files().items():
            whole = self.asked.get(name)
            if name.startswith("."):
                continue
            if whole is not None and len(content) < len(whole) and whole.startswith(content):
                return f"{name} is there in part"
        return ""


def every_call(folder: Path, name: str, session: Callable[[], Sequence[Call]], reads: int, others: int) -> Outcome:
    """The lines of the session that call one command, with each of their system calls gone wrong."""
    outcome = Outcome("a call fails", name)
    mine = [call for call in session() if named(call.arguments) == name]
    for number, call in enumerate(mine):
        _each(outcome, Bench(folder / str(number), call), max(1, reads // len(mine)), max(1, others // len(mine)))
        shutil.rmtree(folder / str(number), ignore_errors=True)
    if not mine:
        outcome.faults.append("no example calls it")
    return outcome


def _each(outcome: Outcome, bench: "Bench", reads: int, others: int) -> None:
    began = time.monotonic()
    found, line = bench.learn(), bench.call.line
    if time.monotonic() - began > SLOW:
        reads = others = 1
    size = bench.file.stat().st_size
    for fault in faults(found, reads, others):
        ended = bench.tried(fault)
        if ended.came:
            what, wrong = bench.judged(ended)
            outcome.saw(what, wrong and f"{line}: {fault}: {wrong}")
    writes = any(one in GROUPS["write"] for one, _ in found)
    for largest in [place * size // others for place in range(others)] if writes else []:
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
"""Commands of a history; each changes the ledger in another way."""


def history(folder: Path, steps: int, seed: int) -> Outcome:
    """A history of commands, some call of each gone wrong, and the same replayed on a ledger on which none does."""
    outcome, rng = Outcome("a call fails", f"histories of {steps} commands, replayed"), random.Random(seed)
    desk, notes, clean = folder / "desk", folder / "notes", folder / "clean" / "ledger.db"
    clean.parent.mkdir(parents=True)
    desk.mkdir()
    file = desk / "ledger.db"
    with at_home(folder / "home"):
        for one in (file, clean):
            season(one)
        for step in range(steps):
            arguments = _drawn(rng, step)
            before = state(clean)
            fault = Fault(*rng.choice(KINDS), rng.choice(("error=EIO", "error=ENOSPC", "signal=SIGKILL")))
            ended = run_with(command(file, arguments), desk, notes, fault)
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
                wrong = wrong or f"a traceback: {ended.said.strip()[-200:]}"
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
"""Calls of a history that go wrong: name and number."""


def _drawn(rng: random.Random, step: int) -> list[str]:
    values = {"number": 500 + step, "flight": rng.randrange(1, 13)}
    arguments = [part.format(**values) for part in rng.choice(HISTORY)]
    dated = ["--date-time", f"2026-05-02T{step // 60 % 24:02}:{step % 60:02}"] if arguments[0] == "add" else []
    return [*arguments, *dated]


def _put_back(clean: Path, file: Path) -> None:
    """The ledger of the replay as the other is."""
    for end in ("-journal",):
        clean.with_name(clean.name + end).unlink(missing_ok=True)
    shutil.copyfile(file, clean)
    os.sync()
