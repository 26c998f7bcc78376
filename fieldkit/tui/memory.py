"""Use little memory, and return it to the system."""

import ctypes
import gc
import sys
from functools import cache
from typing import Any

ARENA_MAX_OPTION = -8
"""glibc's `M_ARENA_MAX`, from `malloc.h`."""
MAX_ARENAS = 2
"""Number of malloc arenas: one for key handling, one for everything else. [1]"""
MMAP_THRESHOLD_OPTION = -3
"""glibc's `M_MMAP_THRESHOLD`, from `malloc.h`."""
MMAP_THRESHOLD = 1 << 16
"""Size from which memory is returned to the system as soon as it is free. After 2,000 random keys this saves 35 MB, and
no processor time is lost. [B]"""
START_TIME = 2.0
"""Time for showing the first page, for which the command pauses garbage collection. [s]"""


def pause_collection() -> None:
    """Stop collecting garbage until `resume_collection`: while the app starts, almost nothing that is allocated is
    garbage, and scanning it takes an eighth of the processor time."""
    gc.disable()


def resume_collection() -> None:
    """Collect garbage again."""
    gc.enable()


def freeze_permanent() -> None:
    """Exclude all current objects from garbage collection: modules and prepared pages, which stay to the end. Scanning
    them takes 0.13 s, which a key would wait for."""
    gc.collect()
    gc.freeze()
    gc.collect()  # a full collection waits until a quarter as many objects are new as the last one scanned: now none


def give_back() -> None:
    """Return free memory to the system: large computations leave hundreds of megabytes that glibc would keep.

    Does nothing without glibc.
    """
    if (trim := _of_glibc("malloc_trim")) is not None:
        trim(0)


def limit_malloc() -> None:
    """Have glibc keep little free memory. By default it has eight arenas per core, each of which keeps the memory it
    ever used, and after large arrays were freed it keeps later ones in arenas too, between smaller objects.

    Does nothing without glibc.
    """
    if (option := _of_glibc("mallopt")) is not None:
        option(ARENA_MAX_OPTION, MAX_ARENAS)
        option(MMAP_THRESHOLD_OPTION, MMAP_THRESHOLD)


@cache
def _of_glibc(name: str) -> Any:
    """A function of glibc, None if it does not exist."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None
