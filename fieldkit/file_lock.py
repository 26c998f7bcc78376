"""A lock that lets only one program at a time change a file of fieldkit; it ends with its process, even a killed
one."""

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fieldkit.errors import FieldkitError
from fieldkit.paths import LOCK_NAME

PATIENCE = 10.0
"""Longest wait for another program, which needs milliseconds. [s]"""
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
"""Flag of `os.open`: a lock that is a link would create or hold another file. Windows has none."""
POLL = 0.01
"""Interval between two attempts. [s]"""


@contextmanager
def changing(file: Path) -> Iterator[None]:
    """Lock a file, and all others in its folder, while it is read and replaced, so that no other program's change is
    lost.

    Every change to a file that fieldkit manages is in such a block; blocks are never nested. On a disk without locks,
    files are written without one. Raises FieldkitError if the folder cannot be written or stays locked.
    """
    number = _opened(file)
    try:
        end = time.monotonic() + PATIENCE
        while not _is_ours(number):
            if time.monotonic() >= end:
                raise FieldkitError(f"{file}: another program has been changing it for {PATIENCE:g} s; try again")
            time.sleep(POLL)
        yield
    finally:
        os.close(number)


def hold(lock: Path) -> int | None:
    """Hold a lock file until the end of the process, or until the returned number is passed to `os.close`; None if
    another holder has it. Raises FieldkitError if the file cannot be written."""
    number = _opened(lock, lock.name)
    if _is_ours(number):
        return number
    os.close(number)
    return None


def _opened(file: Path, name: str = LOCK_NAME) -> int:
    """The open lock of this name in a file's folder, which is created if necessary. A file that is a link has the
    lock of its target's folder. Raises FieldkitError if it cannot be written."""
    try:
        folder = file.resolve().parent
        folder.mkdir(parents=True, exist_ok=True)
        return os.open(folder / name, os.O_RDWR | os.O_CREAT | NO_LINK, 0o666)
    except (OSError, RuntimeError) as error:  # a loop of links
        raise FieldkitError(f"{file}: cannot be written ({getattr(error, 'strerror', None) or error})") from error


def _is_ours(number: int) -> bool:
    """Whether the lock was free and is now held; also on a disk that has no locks."""
    try:
        _locked(number)
    except (BlockingIOError, PermissionError):  # held, on Unix and on Windows
        return False
    except OSError:
        return True
    return True


def _locked(number: int) -> None:
    """Lock an open file. Raises OSError if it is locked already, or if its disk has no locks."""
    try:
        from fcntl import LOCK_EX, LOCK_NB, flock
    except ImportError:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
    else:
        flock(number, LOCK_EX | LOCK_NB)
