"""A command that runs up to where it first writes, and is forked there once a trial: what it computes is computed once.

It is about to write when it takes its ledger to change it, or opens a file of its folder for writing.
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
"""What came of a trial, and what is wrong with it."""


class _Enough(BaseException):
    """Leaves a command that was forked often enough."""


def from_first_write(work: Callable[[], int], folder: Path, trials: Callable[[], list[Seen] | None]) -> list[Seen]:
    """What came of some trials, which are called where some work first writes in a folder.

    They end in None in a fork, which continues with the work. The work runs in a process of its own.
    """
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        os.close(reading)
        leave(lambda: _paused(work, folder, trials, writing))
    os.close(writing)
    with os.fdopen(reading) as pipe:
        said = pipe.read()
    os.waitpid(pid, 0)
    return [(what, wrong) for what, wrong in json.loads(said)] if said else [("", "the bench itself died")]


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
            with os.fdopen(pipe, "w") as told:
                json.dump(seen, told)
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
    """Whether a file of a folder is opened for writing."""
    named = isinstance(path, str | bytes | os.PathLike) and isinstance(flags, int)
    if not named or not flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):  # type: ignore[operator]  # it is a number
        return False
    return os.path.realpath(os.fsdecode(path)).startswith(f"{folder}{os.sep}")  # type: ignore[arg-type]  # and a path
