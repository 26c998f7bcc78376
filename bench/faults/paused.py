"""Run a command until it first writes, and fork it there once per trial, so its computation runs only once.

It is about to write when it locks its ledger for a change, or opens a file in its folder for writing.
"""

import json
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from bench.faults.calls import answer_of, leave
from bench.faults.kills import Enough, gated

Seen = tuple[str, str]
"""Result of a trial, and any error."""


def from_first_write(work: Callable[[], int], folder: Path, trials: Callable[[], list[Seen] | None]) -> list[Seen]:
    """Results of trials that start where some work first writes in a folder.

    `trials` returns None in a fork, which continues with the work. The work runs in a separate process.
    """
    message = answer_of(lambda: _paused(work, folder, trials))
    return [(what, wrong) for what, wrong in json.loads(message)] if message else [("", "the bench itself died")]


def _paused(work: Callable[[], int], folder: Path, trials: Callable[[], list[Seen] | None]) -> str:
    was_there, seen = False, None

    def gate() -> None:
        nonlocal was_there, seen
        if was_there:
            return
        was_there = True
        seen = trials()
        if seen is not None:
            raise Enough

    def hear(event: str, arguments: tuple[object, ...]) -> None:
        if event == "open" and not was_there and _writes(folder, *arguments):
            gate()

    sys.addaudithook(hear)
    status = 0
    with gated(gate), suppress(Enough):
        status = work()
    if seen is None:
        leave(lambda: status)
    return json.dumps(seen)


def _writes(folder: Path, path: object, _: object, flags: object) -> bool:
    """Whether a file in a folder is opened for writing."""
    named = isinstance(path, str | bytes | os.PathLike) and isinstance(flags, int)
    if not named or not flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):  # type: ignore[operator]  # it is a number
        return False
    return os.path.realpath(os.fsdecode(path)).startswith(f"{folder}{os.sep}")  # type: ignore[arg-type]  # and a path
