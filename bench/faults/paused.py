"""Run a command until it first writes, and fork it there once per trial, so its computation runs only once.

It is about to write when it locks its ledger for a change, or opens a file in its folder for writing.
"""

import json
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from bench.faults.calls import leave
from bench.faults.kills import gated

Seen = tuple[str, str]
"""Result of a trial, and any error."""


class _Enough(BaseException):
    """Raised to leave a command after enough forks."""


def from_first_write(work: Callable[[], int], folder: Path, trials: Callable[[], list[Seen] | None]) -> list[Seen]:
    """Results of trials that start where some work first writes in a folder.

    `trials` returns None in a fork, which continues with the work. The work runs in a separate process.
    """
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        os.close(reading)
        leave(lambda: _paused(work, folder, trials, writing))
    os.close(writing)
    with os.fdopen(reading) as pipe:
        message = pipe.read()
    os.waitpid(pid, 0)
    return [(what, wrong) for what, wrong in json.loads(message)] if message else [("", "the bench itself died")]


def _paused(work: Callable[[], int], folder: Path, trials: Callable[[], list[Seen] | None], pipe: int) -> int:
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    was_there = False

    def gate() -> None:
        nonlocal was_there
        if was_there:
            return
        was_there = True
        if (seen := trials()) is not None:
            with os.fdopen(pipe, "w") as output:
                json.dump(seen, output)
            raise _Enough

    def hear(event: str, arguments: tuple[object, ...]) -> None:
        if event == "open" and not was_there and _writes(folder, *arguments):
            gate()

    sys.addaudithook(hear)
    status = 0
    with gated(gate), suppress(_Enough):
        status = work()
    return status


def _writes(folder: Path, path: object, _: object, flags: object) -> bool:
    """Whether a file in a folder is opened for writing."""
    named = isinstance(path, str | bytes | os.PathLike) and isinstance(flags, int)
    if not named or not flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):  # type: ignore[operator]  # it is a number
        return False
    return os.path.realpath(os.fsdecode(path)).startswith(f"{folder}{os.sep}")  # type: ignore[arg-type]  # and a path
