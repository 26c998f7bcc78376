"""Kills in earnest, a few of each kind; `python -m bench.faults` has the thousand."""

import os
import signal
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from sqlalchemy import Connection, event

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, Renewal, Start, journal

if not hasattr(os, "fork"):
    pytest.skip("the bench forks what it kills; Windows has no fork", allow_module_level=True)

from bench.faults import damage, kills, ledgers, servers

FIRST, SECOND = (Flight(flight_id=id, rocket="Astra", apogee=100.0) for id in "12")


@pytest.mark.parametrize("name", ["add", "migrate", pytest.param("undo", marks=pytest.mark.slow)])
def test_a_killed_command_leaves_the_ledger_as_before_or_as_after(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kills, "MEASURED", 1)
    case = next(case for case in kills.CASES if case.name == name)
    outcome = kills.kills(case, tmp_path / "kills", 3, seed=1)
    assert outcome.tried == 3
    assert outcome.faults == []


def test_the_bench_sees_a_half_written_change(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    states = []
    with Ledger.open(file) as ledger:
        for flight in (FIRST, SECOND):
            ledger.add([flight])
            states.append(ledgers.state(file))
    assert ledgers.after(file, states) == ("after", "")
    with closing(sqlite3.connect(file)) as raw:
        raw.execute("DELETE FROM journal WHERE number = 2")
        raw.commit()
    assert ledgers.after(file, states) == ("half", "neither as before nor as after the command")


def test_bits_that_flip_are_seen_or_harmless(tmp_path: Path) -> None:
    assert damage.bits_flipped(tmp_path / "bits", 3, seed=1).faults == []
    assert damage.cut_short(tmp_path / "cut", 6, seed=1).faults == []


@pytest.fixture(scope="module")
def server() -> Iterator[servers.Server]:
    """A PostgreSQL server that may be killed."""
    if not servers.binaries():
        pytest.skip("there is no PostgreSQL on this machine")
    memory = "/dev/shm" if Path("/dev/shm").is_dir() else None
    with tempfile.TemporaryDirectory(dir=memory) as scratch:
        Path(scratch).chmod(0o755)  # the server is another user
        with servers.server(Path(scratch) / "server") as ours:
            yield ours


@pytest.fixture
def url(server: servers.Server) -> str:
    """Where an empty ledger may be made on it."""
    servers.emptied(server.url)
    return server.url


WRITES: dict[str, Callable[[Ledger], object]] = {
    "add": lambda ledger: ledger.add([SECOND], log=b"another log"),
    "edit": lambda ledger: ledger.edit("1", apogee=110.0),
    "edit all": lambda ledger: ledger.edit_all(["1"], "config", config="B"),
    "tag": lambda ledger: ledger.tag("1", "mine", "weak_launch"),
    "untag": lambda ledger: ledger.untag("1", "off_axis"),
    "renew": lambda ledger: ledger.renew([Renewal("1", FIRST.with_changes(duration=40.0), None)]),
    "remove": lambda ledger: ledger.remove("1"),
    "undo": lambda ledger: ledger.undo(),
    "redo": lambda ledger: ledger.redo(),
    "a model": lambda ledger: ledger.keep_version("Astra", {"effect": "wear"}),
    "another model": lambda ledger: ledger.activate("Astra", None),
    "a prediction": lambda ledger: ledger.keep_prediction({"p50": 2.0}, digest="d2", rocket="Astra"),
    "a start": lambda ledger: ledger.keep_start(Start("Comet", "A", 0.3)),
    "a draft": lambda ledger: ledger.keep_draft("add", {"apogee": "924ft"}),
}


@pytest.mark.postgres
@pytest.mark.parametrize("statements", [range(4, 5), pytest.param(range(1, 30), marks=pytest.mark.slow)])
def test_each_change_whose_server_process_is_killed_in_its_midst_never_was(url: str, statements: range) -> None:
    with Ledger.open(url) as ledger:
        _furnish(ledger)
        for name, write in WRITES.items():
            before = ledgers.state(url)
            for count in statements:
                with killed_after(ledger, count) as killed:
                    said = failure(ledger, write)
                if not killed:
                    break
                assert "127.0.0.1" in said
                servers.recovered(url)
                assert ledgers.state(url) == before, f"{name}, after {count} statements"
            assert killed or (count > 4 and not said), name
        assert not failure(ledger, WRITES["add"])


def failure(ledger: Ledger, write: Callable[[Ledger], object]) -> str:
    """What a ledger says when it cannot be changed, empty where it was."""
    try:
        write(ledger)
    except LedgerError as error:
        return str(error)
    return ""


def _furnish(ledger: Ledger) -> None:
    """Something of each kind, so that each change has what it needs; the last one is undone."""
    ledger.add([FIRST], log=b"a log")
    ledger.keep_version("Astra", {"effect": "wind"})
    ledger.keep_prediction({"p50": 1.0}, digest="d1", rocket="Astra")
    ledger.keep_start(Start("Astra", "A", 0.3))
    ledger.keep_draft("add", {"apogee": "923ft"})
    ledger.tag("1", "off_axis")
    ledger.edit("1", notes="high")
    ledger.undo()


@contextmanager
def killed_after(ledger: Ledger, count: int) -> Iterator[list[int]]:
    """Kill the server's process behind a change after so many statements; the number of the one that was killed."""
    killed, left = [], count

    def kill(connection: Connection) -> None:
        nonlocal left
        left -= 1
        if not left:
            killed.append(connection.connection.driver_connection.info.backend_pid)
            os.kill(killed[0], signal.SIGKILL)

    with writing(ledger, "after_cursor_execute", kill):
        yield killed


@contextmanager
def writing(ledger: Ledger, what: str, heard: Callable[[Connection], object]) -> Iterator[None]:
    """Call a function at an event of the ledger's connections that change something."""

    def hear(connection: Connection, *_: object) -> None:
        if connection.get_execution_options().get("writes"):
            heard(connection)

    event.listen(ledger._engine, what, hear)
    try:
        yield
    finally:
        event.remove(ledger._engine, what, hear)


@pytest.mark.postgres
def test_a_server_that_dies_in_mid_transaction_loses_that_change_alone(
    server: servers.Server, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Ledger.open(url) as ledger:
        ledger.add([FIRST])
        enter = journal._enter

        def as_the_server_dies(*arguments: object, **values: object) -> None:
            server.kill()
            enter(*arguments, **values)  # type: ignore[arg-type]

        monkeypatch.setattr(journal, "_enter", as_the_server_dies)
        with pytest.raises(LedgerError, match=r"127\.0\.0\.1") as error:
            ledger.add([SECOND])
        assert "\n" not in str(error.value)
        monkeypatch.setattr(journal, "_enter", enter)
        server.start()
        assert ledger.flights() == [FIRST]
        ledger.add([SECOND])
        assert [change.number for change in ledger.history()] == [1, 2]
