"""Return memory to the system after large computations."""

import ctypes
import gc
import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

ARENA_MAX_OPTION = -8
"""glibc's `M_ARENA_MAX`, from `malloc.h`."""
MAX_ARENAS = 2
"""Number of malloc arenas: one for key handling, one for everything else. [1]"""
START_TIME = 2.0
"""Time for showing the first page, for which the command pauses garbage collection. [s]"""
MAX_GROWTH = 1.2
"""Growth of the number of frozen objects at which all of them are collected again. [1]"""


def pause_collection() -> None:
    """Stop collecting garbage until `resume_collection`: while the app starts, almost nothing that is allocated is
    garbage, and scanning it takes an eighth of the processor time."""
    gc.disable()


def resume_collection() -> None:
    """Collect garbage again."""
    gc.enable()


def give_back() -> None:
    """Return free memory to the system: large computations leave hundreds of megabytes that glibc would keep.

    Does nothing without glibc.
    """
    if (trim := _of_glibc("malloc_trim")) is not None:
        trim(0)


def share_arenas() -> None:
    """Make threads share malloc arenas: by default glibc has eight per core, and each keeps the memory it ever used.

    Does nothing without glibc.
    """
    if (option := _of_glibc("mallopt")) is not None:
        option(ARENA_MAX_OPTION, MAX_ARENAS)


@cache
def _of_glibc(name: str) -> Any:
    """A function of glibc, None if it does not exist."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None


@dataclass(slots=True)
class PassedBy:
    """Objects excluded from garbage collection: long-lived flights and widgets. With 5,000 flights, collecting them
    takes 230 ms per key; without them, a key takes 30 to 50 ms."""

    last: int = 0
    """Number of objects in use at the last full collection. [1]"""

    def extend(self) -> None:
        """Exclude all current objects from garbage collection.

        Garbage is collected first, because frozen garbage is never freed: new garbage every time, and all of it if the
        number of objects has grown by a fifth.
        """
        everything = gc.get_freeze_count() > MAX_GROWTH * self.last
        if everything:
            gc.unfreeze()
        gc.collect()
        gc.freeze()
        if everything:
            self.last = gc.get_freeze_count()
