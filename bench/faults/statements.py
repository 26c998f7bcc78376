"""Kill -9 of PostgreSQL's backend process between two statements of a change, for every kind of change.

The server then ends all its processes and recovers, as after a crash. Before the commit, nothing may have changed.
"""

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from sqlalchemy import Connection, event

from bench.faults.ledgers import Outcome, state
from bench.faults.servers import emptied, recovered_server
from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger import Ledger, Renewal
from fieldkit.rocket import Configuration

FIRST, SECOND = (Flight(flight_id=id, rocket="Astra", apogee=100.0) for id in "12")
Change = Callable[[Ledger], object]
CHANGES: dict[str, Change] = {
    "add": lambda ledger: ledger.add([IncomingFlight(SECOND, Original.of(b"another log"))]),
    "edit": lambda ledger: ledger.edit("1", apogee=110.0),
    "edit all": lambda ledger: ledger.edit_all(["1"], "config", config="B"),
    "tag": lambda ledger: ledger.tag("1", "mine", "weak_launch"),
    "untag": lambda ledger: ledger.untag("1", "off_axis"),
    "renew": lambda ledger: ledger.renew([Renewal("1", FIRST, FIRST.with_changes(duration=40.0))]),
    "remove": lambda ledger: ledger.remove("1"),
    "undo": lambda ledger: ledger.undo(),
    "redo": lambda ledger: ledger.redo(),
    "a model": lambda ledger: ledger.keep_version("Astra", {"effect": "wear"}),
    "another model": lambda ledger: ledger.activate("Astra", None),
    "a prediction": lambda ledger: ledger.keep_prediction({"p50": 2.0}, digest="d2", rocket="Astra"),
    "a start": lambda ledger: ledger.keep_design(Configuration("Comet", "A", 0.3)),
    "a draft": lambda ledger: ledger.keep_draft("add", {"apogee": "924ft"}),
}


def process_killed(url: str, counts: Iterable[int]) -> Outcome:
    """Kill the backend process of each change after a number of its statements, until there are no more statements."""
    outcome = Outcome("PostgreSQL", "every change, the server's process killed between its statements")
    emptied(url)
    with Ledger.open(url) as ledger:
        _furnish(ledger)
        for name, change in CHANGES.items():
            before = state(url)
            for count in counts:
                with recovered_server(url) as recovered:
                    with _killed_after(ledger, count) as killed:
                        message = _failure(ledger, change)
                    if not killed:
                        outcome.faults += [f"{name}: refused: {message}"] if message else []
                        break
                    recovered()
                outcome.saw(*_judged(state(url) == before, message, f"{name}, after {count} statements"))
    return outcome


def _judged(as_before: bool, message: str, what: str) -> tuple[str, str]:
    """Which state the ledger is in, and what is wrong with it."""
    if not message:
        return "done", f"{what}: went through without its server"
    return ("before", "") if as_before else ("half", f"{what}: not as before")


def _failure(ledger: Ledger, change: Change) -> str:
    """The error of a ledger that cannot be changed, empty if the change succeeded."""
    try:
        change(ledger)
    except LedgerError as error:
        return str(error)
    return ""


def _furnish(ledger: Ledger) -> None:
    """Add a record of each kind, so that each change has what it needs; the last one is undone."""
    ledger.add([IncomingFlight(FIRST, Original.of(b"a log"))])
    ledger.keep_version("Astra", {"effect": "wind"})
    ledger.keep_prediction({"p50": 1.0}, digest="d1", rocket="Astra")
    ledger.keep_design(Configuration("Astra", "A", 0.3))
    ledger.keep_draft("add", {"apogee": "923ft"})
    ledger.tag("1", "off_axis")
    ledger.edit("1", notes="high")
    ledger.undo()


@contextmanager
def _killed_after(ledger: Ledger, count: int) -> Iterator[list[int]]:
    """Kill the server's backend process of a change after `count` statements; yields the id of the killed process."""
    killed, left = [], count

    def kill(connection: Connection) -> None:
        nonlocal left
        left -= 1
        if not left:
            behind = connection.connection.driver_connection
            killed.append(behind.info.backend_pid)  # type: ignore[union-attr]  # it is connected
            os.kill(killed[0], signal.SIGKILL)

    with _writing(ledger, "after_cursor_execute", kill):
        yield killed


@contextmanager
def _writing(ledger: Ledger, what: str, heard: Callable[[Connection], object]) -> Iterator[None]:
    """Call a function at an event of the ledger's writing connections."""

    def hear(connection: Connection, *_: object) -> None:
        if connection.get_execution_options().get("writes"):
            heard(connection)

    event.listen(ledger._engine, what, hear)
    try:
        yield
    finally:
        event.remove(ledger._engine, what, hear)
