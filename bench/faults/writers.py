"""Concurrent writers, commands beside open apps, and old schemas."""

import asyncio
import multiprocessing
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.synchronize import Barrier
from pathlib import Path

from bench.faults.ledgers import OLD, Outcome, fieldkit, old, raw_step, season, unsound
from fieldkit.ledger import Ledger, backups
from fieldkit.ledger.schema import STEPS


def two_commands(folder: Path, each: int) -> Outcome:
    """Two processes that add and tag flights in one ledger, as fast as they can."""
    file = _ledger(folder)
    _at_once(file, each, _add, _add)
    outcome = Outcome("two writers", "two commands", tried=4 * each)
    return _judged(outcome, file, 1 + 4 * each, 12 + 2 * each)


def apps_and_commands(folder: Path, each: int) -> Outcome:
    """Two open apps, in which a key undoes the last change, while three commands add and tag."""
    file = _ledger(folder)
    _at_once(file, each, _press, _press, _add, _add, _add)
    outcome = Outcome("five writers", "two open apps and three commands", tried=8 * each)
    return _judged(outcome, file, 1 + 8 * each, None)


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
    from textual.worker import WorkerCancelled

    from fieldkit.tui.app import FieldkitApp

    async def pressing() -> None:
        app = FieldkitApp(file, file.with_name("settings.json"))
        async with app.run_test(size=(80, 24)) as pilot:
            for _ in range(each):
                await pilot.press("u")
                with suppress(WorkerCancelled):  # a page that is shown again reads the ledger again
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


def concurrent_migrations(folder: Path, processes: int) -> Outcome:
    """Processes that open a ledger of an older schema at the same moment: one upgrades it, all answer."""
    outcome = Outcome("older schema", f"opened by {processes} processes at once")
    for step in STEPS[:-1]:
        file, context = folder / step / "ledger.db", multiprocessing.get_context("fork")
        file.parent.mkdir(parents=True)
        old(file, step)
        together = context.Barrier(processes)
        running = [context.Process(target=_open, args=(file, together)) for _ in range(processes)]
        for process in running:
            process.start()
        for process in running:
            process.join()
            wrong = "" if process.exitcode == 0 else "a process was refused or gave another answer"
            outcome.saw("answered", wrong and f"{step}: {wrong}")
        kept = [raw_step(one.file) for one in backups.backups(file)]
        if found := unsound(file) or ("" if raw_step(file) == STEPS[-1] else "it was not upgraded"):
            outcome.faults.append(f"{step}: {found}")
        if step not in kept:
            outcome.faults.append(f"{step}: no backup was made before")
    return outcome


def _open(file: Path, together: Barrier) -> None:
    together.wait()
    status, out, _ = fieldkit(file, "show", "1")
    assert status == 0
    assert "281.3" in out
