"""What a process does that keys would have to wait for, and when: the collector and the workers."""

import ctypes
import gc
import sys
from functools import cache
from typing import Any

YIELD = 0.0005
"""How long a worker may hold the interpreter while a key waits for it; Python's own 5 ms add up within a key. [s]"""
REST = 3.0
"""How long no key was pressed before the collector looks through everything. [s]"""
NO_AUTOMATIC_FULL = 1_000_000
"""Young collections before a full one: never by itself, for it takes as long as a key may. [1]"""
COLLECTIONS_BEFORE_FULL = 10
"""Young collections after which a pause is used for a full one. [1]"""


def begin() -> None:
    """Let workers yield to keys, and let the collector look at what is young alone."""
    sys.setswitchinterval(YIELD)
    gc.set_threshold(*gc.get_threshold()[:2], NO_AUTOMATIC_FULL)


def keep() -> None:
    """Tell the collector that what is there stays, flights and widgets: to look through them takes a tenth of a second
    where they are thousands."""
    gc.collect(1)
    gc.freeze()


def tidy() -> None:
    """Collect whatever has come together while keys were pressed."""
    if gc.get_count()[2] >= COLLECTIONS_BEFORE_FULL:
        gc.collect()
        give_back()


def give_back() -> None:
    """Hand memory that is free back to the system: large work leaves hundreds of megabytes that glibc would keep.

    Anywhere else than with glibc nothing happens.
    """
    if (trim := _trim()) is not None:
        trim(0)


@cache
def _trim() -> Any:
    """glibc's `malloc_trim`, None where there is no such function."""
    return getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
