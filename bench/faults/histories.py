"""Histories of several processes on one ledger, checked as in Jepsen: nothing acknowledged may be lost.

Each writer records acknowledged changes in its own file, after the acknowledgment. At the end every such flight must be
in the ledger, or in a backup that a restore made of the ledger it replaced; nothing may be there twice.
"""

import multiprocessing
import sqlite3
import time
from collections import Counter
from contextlib import closing
from pathlib import Path
from unittest.mock import patch

from bench.faults.ledgers import Outcome, fieldkit, season, unsound
from fieldkit.ledger import backups

BACKUPS_RETAINED = 10_000
"""Number of backups retained here, so that rotation is not mistaken for a loss. [1]"""


def restores_beside_writers(folder: Path, writers: int, each: int, restores: int) -> Outcome:
    """Processes add flights as fast as they can, while another restores the first backup repeatedly."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "ledger.db"
    season(file)
    outcome = Outcome("histories", f"{writers} writers beside {restores} restores")
    with patch.object(backups, "MAX_BACKUPS", BACKUPS_RETAINED):
        assert fieldkit(file, "tag", "1", "mine")[0] == 0  # the backup to be restored is made before this change
        context = multiprocessing.get_context("fork")
        running = [context.Process(target=_add, args=(file, place, each)) for place in range(writers)]
        running.append(context.Process(target=_restore, args=(file, restores)))
        for process in running:
            process.start()
        for process in running:
            process.join()
        if any(process.exitcode for process in running):
            outcome.faults.append("a process died")
        return _judged(outcome, file, _acknowledged(folder))


def _add(file: Path, writer: int, each: int) -> None:
    with file.with_name(f"writer-{writer}.txt").open("a", encoding="ascii") as acknowledged:
        for number in range(each):
            id = f"{writer}-{number}"
            if fieldkit(file, "add", "--rocket", "Astra", "--flight-id", id, "--apogee", "100m")[0] == 0:
                acknowledged.write(f"{id}\n")
                acknowledged.flush()


def _restore(file: Path, restores: int) -> None:
    for _ in range(restores):
        time.sleep(0.05)
        status, _, message = fieldkit(file, "backups", "restore", "1", "--yes")
        assert status == 0, message


def _acknowledged(folder: Path) -> list[str]:
    return [
        id
        for acknowledged in sorted(folder.glob("writer-*.txt"))
        for id in acknowledged.read_text(encoding="ascii").split()
    ]


def _flights(file: Path) -> list[str]:
    with closing(sqlite3.connect(file)) as raw:
        return [id for (id,) in raw.execute("SELECT flight_id FROM flights")]


def _judged(outcome: Outcome, file: Path, acknowledged: list[str]) -> Outcome:
    copies = backups.backups(file)
    held = [_flights(one) for one in (file, *(copy.file for copy in copies))]
    outcome.tried = len(acknowledged)
    there = {id for flights in held for id in flights}
    if lost := [id for id in acknowledged if id not in there]:
        outcome.faults.append(
            f"{len(lost)} of {len(acknowledged)} acknowledged flights are nowhere: {', '.join(lost[:5])}"
        )
    if twice := [id for flights in held for id, times in Counter(flights).items() if times > 1]:
        outcome.faults.append(f"there twice: {', '.join(twice[:5])}")
    if same := [number for number, times in Counter(one.number for one in copies).items() if times > 1]:
        outcome.faults.append(f"copies of the same number: {same}")
    outcome.faults += [f"{one.name}: {found}" for one in (file, *(c.file for c in copies)) if (found := unsound(one))]
    outcome.counts = {
        "acknowledged": len(acknowledged),
        "in the ledger at the end": len(set(acknowledged) & set(held[0])),
    }
    return outcome
