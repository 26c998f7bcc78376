"""SIGKILL at random times: while a command writes, and at any point in it.

The real command runs, through `fieldkit.cli.main`, until it first locks the ledger for a change (before the preceding
backup). From there it is forked, once per trial, on a fresh copy of the ledger: a long computation before it runs only
once, and every kill comes while there is something to lose. Other trials fork before the first line of the command. The
time of each SIGKILL is uniform over 1.1 times the duration of that part without a kill, as measured just before; a
trial that finished earlier is repeated and not counted.

SIGKILL ends the process and not the machine: what the operating system has accepted reaches the disk.
"""

import json
import os
import random
import shutil
import signal
import statistics
import time
import tty
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any
from unittest.mock import patch

from bench.faults.calls import answer_of
from bench.faults.ledgers import (
    LOG,
    STREAM,
    TABLE,
    Outcome,
    State,
    after,
    at_home,
    fieldkit,
    old,
    put,
    raw_step,
    season,
    state,
)
from fieldkit.capture import captures, logs_in, read_capture
from fieldkit.cli.main import main as run
from fieldkit.errors import CaptureTrouble
from fieldkit.ledger import opening
from fieldkit.ledger.backups import folder_of
from fieldkit.paths import capture_folder

MEASURED = 5
"""Number of trials without a kill, whose median duration sets the range of kill times. [1]"""
MAX_MEASURING_TIME = 10.0
"""A command that takes this long is measured once. [s]"""


@dataclass(frozen=True, slots=True)
class Case:
    """A command, the ledger it starts from, and the number of kills at any point rather than while it writes."""

    name: str
    arguments: tuple[str, ...]
    prepared: Callable[[Path], None]
    anywhere: float = 1 / 3


def _with_an_import(file: Path) -> None:
    season(file)
    assert fieldkit(file, "import", str(TABLE), str(LOG), "--set", "rocket=Comet")[0] == 0


SET_UP = ("--rocket", "Astra", "--config", "A", "--motor", "F24-4W", "--dry-mass", "322g")
ADD = ("add", *SET_UP, "--date-time", "2026-05-02T10:00", "--apogee", "935ft")
"""Includes a time: otherwise every trial would record its own, and every ledger would differ."""
CAPTURE = ("capture", "PORT", "--device", "micropeak", "--import", "--set", "rocket=Comet")
CASES = (
    Case("add", ADD, season),
    Case("import", ("import", str(TABLE), str(LOG), "--set", "rocket=Comet"), season),
    Case("capture", CAPTURE, season, 2 / 3),
    Case("undo", ("undo",), _with_an_import),
    Case("migrate", ("history",), lambda file: old(file, "m001_flights")),
    Case("accept", ("loop", "--effect", "motor_thrust"), season, 0.02),
)


def kills(case: Case, folder: Path, trials: int, seed: int) -> Outcome:
    """Kill a command repeatedly, and check the ledger after each kill; in a separate process."""
    if not trials:
        return Outcome("kill -9", case.name)
    message = answer_of(lambda: json.dumps(asdict(_kills(case, folder, trials, random.Random(seed)))))
    return (
        Outcome(**json.loads(message)) if message else Outcome("kill -9", case.name, faults=["the bench itself died"])
    )


def _kills(case: Case, folder: Path, trials: int, rng: random.Random) -> Outcome:
    folder.mkdir(parents=True, exist_ok=True)
    anywhere = round(case.anywhere * trials)
    with at_home(folder / "home"):
        bench = _Bench(case, folder / "template.db", folder / "ledger.db", rng, Outcome("kill -9", case.name))
        case.prepared(bench.template)
        bench.learn()
        bench.kill_anywhere(anywhere)
        bench.kill_while_writing(trials - anywhere)
    return bench.outcome


class Enough(BaseException):
    """Raised to leave a command after enough forks."""


@dataclass(slots=True)
class _Bench:
    """A case under test; `states` are the ledger before and after its command."""

    case: Case
    template: Path
    file: Path
    rng: random.Random
    outcome: Outcome
    states: Sequence[State] = ()
    lengths: list[float] = field(default_factory=list)

    def learn(self) -> None:
        """Record the states before and after the command."""
        put(self.template, self.file)
        before = state(self.file)
        put(self.template, self.file)
        with unit(self.case.arguments) as arguments:
            status, _, message = fieldkit(self.file, *arguments)
        assert status == 0, message
        self.states = (before, state(self.file))

    def kill_anywhere(self, trials: int) -> None:
        """Kill at any time after the first line of the command."""
        for delay in self._moments(trials):
            shutil.rmtree(capture_folder(), ignore_errors=True)
            with unit(self.case.arguments) as arguments:
                if self._forked(delay):
                    run(["--ledger", str(self.file), *arguments])
                    os._exit(0)

    def kill_while_writing(self, trials: int) -> None:
        """Run the command up to its first change, and kill it after that."""
        if not trials:
            return
        went_on = False

        def gate() -> None:
            nonlocal went_on
            if went_on:
                return
            went_on = True
            for delay in self._moments(trials):
                if self._forked(delay):
                    return
            raise Enough

        put(self.template, self.file)
        with unit(self.case.arguments) as arguments, gated(gate), suppress(Enough):
            run(["--ledger", str(self.file), *arguments])
            os._exit(0)

    def _moments(self, trials: int) -> Iterator[float | None]:
        """Time of the kill in each trial, on a fresh ledger; None for trials that are only measured. [s]"""
        self.lengths.clear()
        while len(self.lengths) < MEASURED and sum(self.lengths) < MAX_MEASURING_TIME:
            self._fresh()
            yield None
        length = statistics.median(self.lengths)
        wanted = self.outcome.tried + trials
        while self.outcome.tried < wanted:
            self._fresh()
            yield self.rng.uniform(0.0, 1.1 * length)

    def _fresh(self) -> None:
        put(self.template, self.file)
        if self.rng.random() < 0.5:  # otherwise a backup exists, and the command makes none
            shutil.rmtree(folder_of(self.file), ignore_errors=True)

    def _forked(self, delay: float | None) -> bool:
        """Fork; True in the fork. The parent kills it after a delay and checks the ledger."""
        pid = os.fork()
        if not pid:
            return True
        began = time.monotonic()
        if delay is not None:
            time.sleep(delay)
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
        if delay is None:
            self.lengths.append(time.monotonic() - began)
        elif os.WIFSIGNALED(status):
            self.outcome.saw(*self._look())
        return False

    def _look(self) -> tuple[str, str]:
        hot = self.file.with_name(f"{self.file.name}-journal").exists()
        step = raw_step(self.file)
        name, wrong = after(self.file, self.states)
        if self.case.name == "migrate" and not wrong:
            name = "before" if step == "m001_flights" else "after"
        name += ", rolled back by SQLite's journal" if hot else ""
        return name, wrong or next(filter(None, map(_torn, captures(capture_folder()))), "")


def _torn(file: Path) -> str:
    """What is wrong with a capture whose program was killed: bytes that the unit never sent, or an unread record.

    If the record is incomplete, there may be nothing to read yet.
    """
    record = STREAM.read_bytes()
    try:
        raw = read_capture(file).raw
        if record in raw:
            logs_in(file)
    except CaptureTrouble as error:
        return str(error)
    return "" if raw in record * 9 else f"{file.name}: holds bytes that were never sent"


@contextmanager
def gated(gate: Callable[[], object]) -> Iterator[None]:
    """Call `gate` whenever a command is about to change its ledger."""
    keep, write = opening.keep_backup, opening.writing

    def keeping(engine: Any, **options: Any) -> str:
        engine.dispose()
        gate()
        return keep(engine, **options)

    def writing(engine: Any, **options: Any) -> AbstractContextManager[Any]:
        engine.dispose()
        gate()
        return write(engine, **options)

    with patch.object(opening, "keep_backup", keeping), patch.object(opening, "writing", writing):
        yield


@contextmanager
def unit(arguments: Sequence[str]) -> Iterator[list[str]]:
    """A command's arguments; `PORT` among them becomes a terminal on which a logger sends its record repeatedly."""
    if "PORT" not in arguments:
        yield list(arguments)
        return
    logger, terminal = os.openpty()
    tty.setraw(terminal)
    speaking = os.fork()
    if not speaking:
        _speak(logger)
    try:
        yield [os.ttyname(terminal) if one == "PORT" else one for one in arguments]
    finally:
        os.kill(speaking, signal.SIGKILL)
        os.waitpid(speaking, 0)
        os.close(logger)
        os.close(terminal)


def _speak(logger: int) -> None:
    record = STREAM.read_bytes()
    while True:
        for start in range(0, len(record), 32):
            os.write(logger, record[start : start + 32])
            time.sleep(0.002)
        time.sleep(3.0)
