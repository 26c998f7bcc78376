"""Clocks that are set back and time zones that change between commands: the ledger must be as with a steady clock.

The same commands run on two ledgers, one of them with a steady clock in UTC. After each command both must be equal but
for the recorded times, so order, undo, retries and the rotation of backups may not depend on what a clock shows.
"""

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from datetime import UTC, datetime, timedelta, tzinfo
from itertools import count, cycle
from pathlib import Path
from unittest.mock import patch

from bench.faults.kills import ADD
from bench.faults.ledgers import LOG, TABLE, Outcome, fieldkit, season, state

COMMANDS: Sequence[tuple[str, ...]] = (
    ("import", str(TABLE)),
    ("import", str(LOG), "--set", "rocket=Comet"),
    ADD,
    ("edit", "3", "apogee=250m"),
    ("tag", "4", "mine"),
    ("predict", "--rocket", "Astra", "--config", "A", "--motor", "F24-4W"),
    ("undo",),
    ("redo",),
    ("remove", "5"),
    ("flights",),
    ("history",),
    ("predictions",),
    ("backups",),
    ("backups", "restore", "1", "--yes"),
    ADD,
    ("undo",),
)
ZONES = ("UTC", "Pacific/Kiritimati", "Pacific/Pago_Pago", "Antarctica/Troll", "Asia/Kathmandu", "Nowhere/Unknown")
"""Zones from 14 h before UTC to 11 h after it, with 45 minutes or 2 h of summer time, and one that does not exist."""
FIRST = datetime(2026, 5, 1, tzinfo=UTC)


class Backwards(datetime):
    """A clock that goes back by a day at every reading."""

    passed = count()

    @classmethod
    def now(cls, tz: tzinfo | None = None) -> "Backwards":
        """The day before its last reading."""
        moment = FIRST - timedelta(days=next(cls.passed))
        local = moment.astimezone(tz) if tz else moment.replace(tzinfo=None)
        return cls.fromisoformat(local.isoformat())


@contextmanager
def clock(of: type[datetime]) -> Iterator[None]:
    """Another clock in every loaded module of fieldkit that reads one."""
    modules = [module for name, module in sys.modules.items() if name.startswith("fieldkit.")]
    patches = [patch.object(one, "datetime", of) for one in modules if getattr(one, "datetime", None) is datetime]
    for one in patches:
        one.start()
    try:
        yield
    finally:
        for one in patches:
            one.stop()


@contextmanager
def zone(name: str) -> Iterator[None]:
    """The local time of a zone."""
    with patch.dict(os.environ, {"TZ": name}):
        time.tzset()
        try:
            yield
        finally:
            pass
    time.tzset()


def set_back(folder: Path) -> Outcome:
    """Commands while the clock goes back by a day at every reading."""
    return _compared(Outcome("a clock that is set back", "the same commands with a steady clock"), folder, _backwards)


def zones(folder: Path) -> Outcome:
    """Commands, each in another zone than the one before."""
    turns = cycle(ZONES)
    outcome = Outcome("time zones", f"the same commands, each in the next of {', '.join(ZONES)}")
    return _compared(outcome, folder, lambda: zone(next(turns)))


def _backwards() -> AbstractContextManager[None]:
    return clock(Backwards)


def _compared(outcome: Outcome, folder: Path, disturbed: Callable[[], AbstractContextManager[None]]) -> Outcome:
    """Run every command on a ledger of its own with and without a disturbance of the clock."""
    folder.mkdir(parents=True)
    undisturbed, other = (folder / name / "ledger.db" for name in ("undisturbed", "other"))
    for file in (undisturbed, other):
        file.parent.mkdir()
        season(file)
    for arguments in COMMANDS:
        ends = []
        for file, around in ((undisturbed, nullcontext), (other, disturbed)):
            with around():
                ends.append(fieldkit(file, *arguments))
        wrong = "" if ends[0][0] == ends[1][0] == 0 else ends[1][2].strip() or "not done with a steady clock"
        if state(undisturbed) != state(other):
            wrong = wrong or "the ledger is another than with a steady clock"
        outcome.saw("as with a steady clock", wrong and f"{' '.join(arguments)}: {wrong}")
    return outcome
