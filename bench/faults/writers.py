"""Two concurrent writers, the app and commands, a clock that goes backwards, and old schemas."""

import asyncio
import multiprocessing
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, tzinfo
from itertools import count
from pathlib import Path
from unittest.mock import patch

from bench.faults.ledgers import OLD, Outcome, fieldkit, old, raw_step, season, unsound
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, backups, journal
from fieldkit.ledger.schema import STEPS


def two_commands(folder: Path, each: int) -> Outcome:
    """Two processes that add and tag flights in one ledger, as fast as they can."""
    file = _ledger(folder)
    _at_once(file, each, _add, _add)
    outcome = Outcome("two writers", "two commands", tried=4 * each)
    return _judged(outcome, file, 1 + 4 * each, 12 + 2 * each)


def app_and_command(folder: Path, each: int) -> Outcome:
    """The app, in which a key undoes the last change, while commands add and tag."""
    file = _ledger(folder)
    _at_once(file, each, _press, _add)
    outcome = Outcome("two writers", "app and command", tried=3 * each)
    return _judged(outcome, file, 1 + 3 * each, None)


def _ledger(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "ledger.db"
    season(file)
    return file


Writer = Callable[[Path, str, int], None]


def _at_once(file: Path, each: int, *writers: Writer) -> None:
    context = multiprocessing.get_context("fork")
    running = [context.Process(target=one, args=(file, f"R{place}", each)) for place, one in enumerate(writers)]
    for process in running:
        process.start()
    for process in running:
        process.join()
        assert process.exitcode == 0, "a writer was refused"


def _add(file: Path, rocket: str, each: int) -> None:
    for number in range(each):
        id = f"{rocket}-{number}"
        assert fieldkit(file, "add", "--rocket", rocket, "--flight-id", id, "--apogee", "100m")[0] == 0
        fieldkit(file, "tag", id, "mine")  # the app may have undone it


def _press(file: Path, _: str, each: int) -> None:
    from fieldkit.tui.app import FieldkitApp

    async def pressing() -> None:
        app = FieldkitApp(file, file.with_name("settings.json"))
        async with app.run_test(size=(80, 24)) as pilot:
            for _ in range(each):
                await pilot.press("u")
                await app.workers.wait_for_complete()

    asyncio.run(pressing())


def _judged(outcome: Outcome, file: Path, changes: int, flights: int | None) -> Outcome:
    """Check that the journal has every change once and in order, and that the flights match the changes in effect."""
    with Ledger.open(file) as ledger:
        history, count = ledger.history(), len(ledger.flights())
    known = sum((12 if one.command == "import" else one.command == "add") for one in history if not one.undone)
    numbers = [one.number for one in history]
    if found := unsound(file):
        outcome.faults.append(found)
    if numbers != list(range(1, len(numbers) + 1)) or (flights is not None and len(history) != changes):
        outcome.faults.append(f"found {len(numbers)} changes, expected {changes}")
    if count != (known if flights is None else flights):
        outcome.faults.append(f"found {count} flights, expected {known if flights is None else flights}")
    outcome.counts = {"changes in the journal": len(history), "flights": count}
    return outcome


class Backwards(datetime):
    """A clock that goes back by a day at every reading."""

    passed = count()

    @classmethod
    def now(cls, tz: tzinfo | None = None) -> "Backwards":
        """The day before its last reading."""
        return cls(2026, 5, 1, tzinfo=UTC).astimezone(tz) - timedelta(days=next(cls.passed))


def clock_backwards(folder: Path, changes: int) -> Outcome:
    """Changes while the clock goes back: order, undo and the rotation of backups use numbers."""
    outcome, file = Outcome("clock going backwards", "add, undo, backups"), folder / "ledger.db"
    folder.mkdir(parents=True, exist_ok=True)
    backwards = [patch.object(module, "datetime", Backwards) for module in (journal, backups)]
    with backwards[0], backwards[1], Ledger.open(file) as ledger:
        for number in range(changes):
            ledger.add([Flight(flight_id=str(number), rocket="Astra")])
            order = [one.what for one in ledger.history()] == [str(n) for n in range(number + 1)]
            outcome.saw("in order", "" if order else f"out of order after {number}")
        kept = backups.backups(file)
        ledger.undo()
        left = len(ledger.flights())
    if [one.changes for one in kept] != list(range(changes - 1, 0, -1))[: backups.MAX_BACKUPS]:
        outcome.faults.append(f"backups of {[one.changes for one in kept]} changes were kept")
    if left != changes - 1:
        outcome.faults.append(f"undo left {left} flights of {changes}")
    return outcome


def old_schemas(folder: Path) -> Outcome:
    """A ledger from every older version of the schema: opened, upgraded after a backup, sound."""
    outcome, file = Outcome("older schema", ", ".join(STEPS)), folder / "ledger.db"
    folder.mkdir(parents=True, exist_ok=True)
    for step in sorted(one.stem for one in OLD.glob("*.sql")):
        old(file, step)
        status, out, _ = fieldkit(file, "show", "1")
        copies = [raw_step(one.file) for one in backups.backups(file)]
        wrong = unsound(file) or ("" if status == 0 and "281.3" in out else "its flights are gone")
        if step != STEPS[-1] and step not in copies:
            wrong = wrong or "no backup was made before"
        outcome.saw("upgraded" if step != STEPS[-1] else "current", wrong)
    return outcome
