"""The ledgers that the bench damages, and the conditions that must be true after it."""

import os
import shutil
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

from fieldkit.cli.main import main as run
from fieldkit.ledger import Ledger
from fieldkit.ledger.backups import backups

ROOT = Path(__file__).parents[2]
FLIGHTS = ROOT / "fieldkit" / "data" / "reference_flights.csv"
TABLE = ROOT / "sample_logs" / "flight_table__a_breezy_afternoon.csv"
LOG = ROOT / "sample_logs" / "perfectflite__drogue_and_main.pf2"
STREAM = ROOT / "sample_logs" / "micropeak__a_small_flight.mpd"
OLD = ROOT / "tests" / "ledger" / "old_ledgers"


@dataclass(slots=True)
class Outcome:
    """Results of one part of the bench: trials by kind, and every fault."""

    part: str
    case: str
    tried: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def saw(self, what: str, fault: str = "") -> None:
        """Count one trial."""
        self.tried += 1
        self.counts[what] = self.counts.get(what, 0) + 1
        if fault:
            self.faults.append(fault)


def season(file: Path) -> None:
    """A ledger of the twelve reference flights."""
    assert fieldkit(file, "import", str(FLIGHTS))[0] == 0


def old(file: Path, step: str) -> None:
    """A ledger written by a program with an older schema."""
    file.unlink(missing_ok=True)
    with closing(sqlite3.connect(file)) as raw:
        raw.executescript((OLD / f"{step}.sql").read_text(encoding="utf-8"))


def fieldkit(ledger: Path | str, *arguments: str) -> tuple[int, str, str]:
    """Run a command in this process: exit status, standard output and standard error."""
    out, err = StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = run(["--ledger", str(ledger), *arguments])
    return status, out.getvalue(), err.getvalue()


State = dict[str, Any]


def state(ledger: Path | str) -> State:
    """The content of a ledger, without clock times and file names."""
    with Ledger.open(ledger) as opened:
        rockets = opened.names("rocket")
        return {
            "flights": opened.flights(),
            "logs": [opened.log(id) for id in opened.ids(opened.flights())],
            "history": [(one.number, one.command, one.what.split(" from ")[0], one.undone) for one in opened.history()],
            "versions": [(one.rocket, one.number, one.active) for name in rockets for one in opened.versions(name)],
            "predictions": [(one.rocket, one.flight_id, one.digest) for one in opened.predictions()],
        }


def raw_step(file: Path) -> str:
    """The schema version of a file, read before fieldkit opens it."""
    with closing(sqlite3.connect(file)) as raw:
        return str(raw.execute("SELECT version_num FROM alembic_version").fetchone()[0])


def unsound(file: Path) -> str:
    """What SQLite finds wrong with a file; empty if nothing."""
    try:
        with closing(sqlite3.connect(file)) as raw:
            found = [row[0] for row in raw.execute("PRAGMA integrity_check")]
            broken = raw.execute("PRAGMA foreign_key_check").fetchall()
    except sqlite3.DatabaseError as error:  # too damaged to be checked
        return str(error)
    return "" if found == ["ok"] and not broken else f"{found} {broken}"


def after(file: Path, states: Sequence[State]) -> tuple[str, str]:
    """Which of the states a ledger is in, `before` or `after`, and what is wrong with it, empty if nothing.

    It must open and be sound, as must its newest two backups, and all of its content must equal one of these states.
    """
    try:
        now = state(file)
    except Exception as error:  # for whatever reason, the ledger does not open
        return "lost", f"{type(error).__name__}: {error}"
    copies = [one.file for one in backups(file)[:2]]
    wrong = next((f"{one.name}: {found}" for one in (file, *copies) if (found := unsound(one))), "")
    name = next((name for name, one in zip(("before", "after"), states, strict=True) if one == now), "half")
    return name, wrong or ("neither as before nor as after the command" if name == "half" else "")


def put(template: Path, file: Path) -> None:
    """Copy a ledger to a path and delete the journal of an earlier one; backups stay."""
    file.with_name(f"{file.name}-journal").unlink(missing_ok=True)
    shutil.copyfile(template, file)


@contextmanager
def at_home(folder: Path) -> Iterator[None]:
    """Use a folder of the bench for the user's data."""
    before = {name: os.environ.get(name) for name in ("FIELDKIT_HOME", "FIELDKIT_LEDGER")}
    os.environ["FIELDKIT_HOME"] = str(folder)
    os.environ.pop("FIELDKIT_LEDGER", None)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
