"""Memory that large work leaves behind, handed back to the system."""

import ctypes
import gc
import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

ARENA_MAX_OPTION = -8
"""glibc's `M_ARENA_MAX`, from `malloc.h`."""
MAX_ARENAS = 2
"""Arenas of memory: one for the keys, one for all else. [1]"""
MAX_GROWTH = 1.2
"""Of the objects that the collector passes by, before they are looked through again. [1]"""


def give_back() -> None:
    """Hand memory that is free back to the system: large work leaves hundreds of megabytes that glibc would keep.

    Without glibc nothing happens.
    """
    if (trim := _of_glibc("malloc_trim")) is not None:
        trim(0)


def share_arenas() -> None:
    """Have threads share arenas of memory: of eight for each core, as glibc has it, every one keeps what it once took.

    Without glibc nothing happens.
    """
    if (option := _of_glibc("mallopt")) is not None:
        option(ARENA_MAX_OPTION, MAX_ARENAS)


@cache
def _of_glibc(name: str) -> Any:
    """One of glibc's functions, None if there is no such function."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None


@dataclass(slots=True)
class PassedBy:
    """What the collector passes by: flights and widgets that stay. With 5,000 flights to look through them takes 230 ms
    of a key, without them 30 to 50 ms."""

    last: int = 0
    """Objects that were found in use when all were looked through last. [1]"""

    def extend(self) -> None:
        """Pass by what is there now.

        Garbage goes first, for what is frozen as garbage stays: that of what is new each time, and all of it if the
        number of objects has grown by a fifth.
        """
        everything = gc.get_freeze_count() > MAX_GROWTH * self.last
        if everything:
            gc.unfreeze()
        gc.collect()
        gc.freeze()
        if everything:
            self.last = gc.get_freeze_count()
