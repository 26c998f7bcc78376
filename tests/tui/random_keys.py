"""The app under random keys in a separate process: `python -m tests.tui.random_keys SEED KEYS REST LEDGER COLUMNS
LINES` prints a line of JSON with the memory at the start, at its peak and at rest [MB], and unexpected errors. It rests
for REST seconds once its pages are ready, and again after the last key. Its environment is that of the command
`fieldkit`."""

import asyncio
import json
import os
import random
import sys
import time
import traceback
from collections import deque
from pathlib import Path

from textual.events import Key

from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.memory import give_back

LETTERS = "123456789abcdefghijklmnoprstuvwxyzCNSTUW/?.-=;"
NAMED = (
    "up",
    "down",
    "left",
    "right",
    "enter",
    "tab",
    "shift+tab",
    "space",
    "backspace",
    "delete",
    "pageup",
    "pagedown",
)
OTHER = (
    "home",
    "end",
    "ctrl+p",
    "ctrl+s",
    "ctrl+n",
    "ctrl+z",
    "ctrl+c",
    "f1",
    "ctrl+end",
    "question_mark",
    "exclamation_mark",
)
KEYS = (*LETTERS, *NAMED, *OTHER, *["escape"] * 7, *"0123456" * 2)
"""The keys; those that change the page are more frequent, and none leaves the app."""
IDLE = 0.2
"""Processor time that an idle app uses at most within a second. [s]"""
REPORTED = 1000
"""Number of keys between two reports."""


def resident() -> float:
    """Memory of this process. [MB]"""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def peak() -> float:
    """Largest memory that this process ever had. [MB]"""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    (found,) = (line for line in lines if line.startswith("VmHWM:"))
    return int(found.split()[1]) * 1024 / 1e6


async def ready(app: FieldkitApp) -> None:
    """Wait until the app has opened its pages behind the visible one and is idle."""
    while not app._readied or not all(worker.is_finished for worker in app.workers):
        await asyncio.sleep(0.05)


async def rested(pause: float) -> None:
    """Wait for a pause, and until the threads have ended the work that was dropped, however long a busy machine
    takes."""
    await asyncio.sleep(pause)
    used = -1.0
    while time.process_time() - used > IDLE:
        used = time.process_time()
        await asyncio.sleep(1.0)


async def handled(app: FieldkitApp) -> None:
    """Wait until the app has handled its keys, however long a busy machine takes."""
    await asyncio.sleep(0)
    while not app._message_queue.empty() or app.turn.locked():
        await asyncio.sleep(0.001)


def report(done: int, errors: list[Exception], last: "deque[str]") -> None:
    """Write how many keys were pressed, and the new errors with the last keys before them, to the error output."""
    for error in errors:
        sys.stderr.write("".join(traceback.format_exception(error)))
        sys.stderr.write(f"after {done:,} keys, the last of them {' '.join(last)}\n")
    if done % REPORTED == 0:
        sys.stderr.write(f"{done:,} keys, {resident():.0f} MB, at most {peak():.0f}\n")
    sys.stderr.flush()


async def pressed(seed: int, keys: int, pause: float, ledger: Path, size: tuple[int, int]) -> dict[str, object]:
    """The result of this number of keys."""
    rng, app = random.Random(seed), FieldkitApp(ledger, ledger.with_name("settings.json"), stays=True)
    last = deque[str](maxlen=40)
    async with app.run_test(size=size):
        await ready(app)
        await rested(pause)
        start = resident()
        for done in range(1, keys + 1):
            key, before = rng.choice(KEYS), len(app.errors)
            last.append(key)
            app.post_message(Key(key, key if len(key) == 1 else None))
            await handled(app)
            report(done, app.errors[before:], last)
        for worker in app.workers:
            worker.cancel()
        await rested(pause)
        give_back()
        rest = resident()
    errors = [f"{type(error).__name__}: {error}" for error in app.errors]
    return {"start": round(start), "most": round(peak()), "rest": round(rest), "errors": errors}


def _size(words: list[str]) -> tuple[int, int]:
    columns, lines = map(int, words)
    return columns, lines


if __name__ == "__main__":
    found = asyncio.run(
        pressed(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), Path(sys.argv[4]), _size(sys.argv[5:7]))
    )
    sys.stdout.write(json.dumps(found) + "\n")
    sys.stdout.flush()
    os._exit(0)
