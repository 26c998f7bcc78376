"""Kills on PostgreSQL: of commands, and of the server itself in the middle of a change.

The bench starts its own server on a free port of this computer, with its data in a scratch folder and the default disk
synchronization. It is killed with `pg_ctl stop -m immediate`, which ends every server process without notice, like a
crash; it recovers at the next start.
"""

import os
import random
import shutil
import signal
import socket
import statistics
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NoReturn

from sqlalchemy import MetaData, insert, select

from bench.faults.calls import TRACEBACK, leave, quiet
from bench.faults.kills import ADD, gated
from bench.faults.ledgers import LOG, TABLE, Outcome, State, fieldkit, old, state
from fieldkit.cli.main import main as run
from fieldkit.errors import LedgerError
from fieldkit.ledger.opening import connect
from fieldkit.ledger.schema import STEPS, upgrade
from fieldkit.ledger.whereabouts import location

COMMANDS = {
    "add": ADD,
    "import": ("import", str(TABLE), str(LOG), "--set", "rocket=Comet"),
    "edit": ("edit", "k1", "apogee=200m"),
    "tag": ("tag", "k1", "mine"),
    "remove": ("remove", "k1", "k2"),
    "undo": ("undo",),
    "redo": ("redo",),
    "migrate": ("history",),
}


def binaries() -> Path | None:
    """Folder of PostgreSQL's programs, None if there are none; links are resolved to the folder with all programs."""
    found = shutil.which("pg_ctl") or next(iter(sorted(Path("/usr/lib/postgresql").glob("*/bin/pg_ctl"))[::-1]), None)
    return Path(found).resolve().parent if found else None


@dataclass(frozen=True, slots=True)
class Server:
    """A PostgreSQL server started by the bench."""

    folder: Path
    port: int

    @property
    def url(self) -> str:
        """URL of a ledger on it."""
        return f"postgresql://postgres@127.0.0.1:{self.port}/postgres"

    def start(self, *, followed: bool = False) -> None:
        """Start it, and wait until it answers; if it is `followed`, a commit waits until a standby has the change."""
        options = f"-p {self.port} -c listen_addresses=127.0.0.1 -c unix_socket_directories=''"
        options += " -c synchronous_standby_names=*" if followed else ""
        self.call("pg_ctl", "-D", "data", "-l", "log", "-s", "-w", "-o", options, "start")

    def kill(self) -> None:
        """Stop it like a crash."""
        self.call("pg_ctl", "-D", "data", "-s", "-m", "immediate", "stop")

    def promote(self) -> None:
        """Make a standby replace the server that it follows."""
        self.call("pg_ctl", "-D", "data", "-s", "-w", "promote")

    def call(self, program: str, *arguments: str) -> None:
        """Run one of PostgreSQL's programs, as the user it requires."""
        command = [str((binaries() or Path()) / program), *arguments]
        if os.geteuid() == 0:  # it refuses to run as root
            command = ["runuser", "-u", "postgres", "--", *command]
        subprocess.run(command, cwd=self.folder, check=True, stdout=subprocess.DEVNULL)


def _placed(folder: Path) -> Server:
    """A server that is not started yet, in its own folder and on a free port."""
    folder.mkdir(parents=True)
    if os.geteuid() == 0:
        shutil.chown(folder, "postgres")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return Server(folder, free.getsockname()[1])


@contextmanager
def server(folder: Path) -> Iterator[Server]:
    """A server that runs until the context ends."""
    ours = _placed(folder)
    ours.call("initdb", "--no-sync", "-D", "data", "-U", "postgres", "-A", "trust", "-E", "UTF8")
    ours.start()
    try:
        yield ours
    finally:
        ours.kill()


@contextmanager
def standby(ours: Server, folder: Path) -> Iterator[Server]:
    """A server that follows another one and has every change before it is acknowledged."""
    following = _placed(folder)
    copied = ("-h", "127.0.0.1", "-p", str(ours.port), "-U", "postgres", "-c", "fast", "--no-sync")
    following.call("pg_basebackup", "-D", "data", "-R", *copied)
    following.start()
    ours.kill()
    ours.start(followed=True)
    try:
        yield following
    finally:
        following.kill()


@contextmanager
def recovered_server(url: str, patience: float = 60.0) -> Iterator[Callable[[], None]]:
    """Allows killing a server process in the block; call the returned function to wait until the server has recovered.

    A connection opened before detects when the server has noticed the kill, which ends that connection too: until then
    it accepts new connections as usual.
    """
    import psycopg

    probe = psycopg.connect(url, autocommit=True)

    def recovered() -> None:
        _await(lambda: not _answers(lambda: probe.execute("SELECT 1")), patience)
        _await(lambda: _answers(lambda: psycopg.connect(url).close()), patience)

    try:
        yield recovered
    finally:
        probe.close()


def _answers(ask: Callable[[], object]) -> bool:
    import psycopg

    try:
        ask()
    except psycopg.OperationalError:
        return False
    return True


def _await(so: Callable[[], bool], patience: float) -> None:
    end = time.monotonic() + patience
    while not so() and time.monotonic() < end:
        time.sleep(0.02)


def emptied(url: str) -> None:
    """Delete everything on a server."""
    import psycopg

    with psycopg.connect(url, autocommit=True) as connection:
        connection.execute("DROP SCHEMA public CASCADE")
        connection.execute("CREATE SCHEMA public")


def _prepared(name: str, url: str) -> None:
    """The ledger that a command starts from: two imports, or one at the first schema."""
    if name == "migrate":
        _of_the_first_step(url)
        return
    emptied(url)
    assert fieldkit(url, "import", str(TABLE))[0] == 0
    if name in ("undo", "redo"):
        assert fieldkit(url, *COMMANDS["import"])[0] == 0
    if name == "redo":
        assert fieldkit(url, "undo")[0] == 0


def _of_the_first_step(url: str) -> None:
    """The ledger of an old program: tables from the first migration, and the rows of a file from that time."""
    emptied(url)
    with TemporaryDirectory() as folder:
        old(Path(folder) / "ledger.db", STEPS[0])
        file, there = (connect(location(where)) for where in (Path(folder) / "ledger.db", url))
        with file.connect() as before, there.begin() as now:
            upgrade(now, STEPS[0])
            tables = MetaData()
            tables.reflect(before)
            for table in tables.sorted_tables:
                rows = [dict(row) for row in before.execute(select(table)).mappings()]
                if rows and table.name != "alembic_version":
                    now.execute(insert(table), rows)
        file.dispose()
        there.dispose()


def crashes(ours: Server, name: str, trials: int, seed: int, *, of_the_server: bool) -> Outcome:
    """Kill a command, or the server below it, at random times during its change, and check the ledger."""
    rng = random.Random(seed)
    outcome = Outcome("PostgreSQL", f"{name}, {'server' if of_the_server else 'command'} killed")
    _prepared(name, ours.url)
    before = state(ours.url)
    lengths = [_left_alone(name, ours.url) for _ in range(3)]
    done = state(ours.url)
    while outcome.tried < trials:
        _prepared(name, ours.url)
        pid = _started(ours.url, COMMANDS[name])
        time.sleep(rng.uniform(0.0, 1.1 * statistics.median(lengths)))
        if of_the_server:
            ours.kill()
        else:
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
        if of_the_server:
            ours.start()
        if os.WIFEXITED(status) and os.WEXITSTATUS(status) == 0:
            continue  # it had finished by then
        outcome.saw(*_look(ours.url, (before, done), status))
    return outcome


def _left_alone(name: str, url: str) -> float:
    """Duration of a command from its first change on. [s]"""
    _prepared(name, url)
    pid, began = _started(url, COMMANDS[name]), time.monotonic()
    os.waitpid(pid, 0)
    return time.monotonic() - began


def _started(url: str, arguments: Sequence[str]) -> int:
    """The process of a command that is about to change its ledger."""
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        _run(url, arguments, lambda: os.write(writing, b"!"))
    os.close(writing)
    os.read(reading, 1)  # also returns at end of file, when the command ends
    os.close(reading)
    return pid


def _run(url: str, arguments: Sequence[str], gate: Callable[[], object]) -> NoReturn:
    quiet()
    with gated(gate):
        leave(lambda: run(["--ledger", url, *arguments]))


def _look(url: str, states: tuple[State, State], status: int) -> tuple[str, str]:
    """Which state the ledger is in, and what is wrong with it."""
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) == TRACEBACK:
        return "traceback", "the command ended in a traceback when its server was gone"
    try:
        now = state(url)
    except LedgerError as error:
        return "lost", str(error)
    if now == states[0]:
        return "before", ""
    return ("after", "") if now == states[1] else ("half", "neither as before nor as after the command")
