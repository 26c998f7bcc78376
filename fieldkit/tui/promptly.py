"""What a process does that keys would have to wait for, and when: the collector and the workers."""

import gc
import sys

YIELD = 0.0005
"""How long a worker may hold the interpreter while a key waits for it; Python's own 5 ms add up within a key. [s]"""
REST = 3.0
"""How long no key was pressed before the collector looks through everything. [s]"""
NEVER = 1_000_000
"""Young collections before a whole one, which takes as long as a key may; it waits for a rest instead. [1]"""
DUE = 10
"""Young collections, after which a rest is worth a whole one. [1]"""


def begin() -> None:
    """Let workers yield to keys, and let the collector look at what is young alone."""
    sys.setswitchinterval(YIELD)
    gc.set_threshold(*gc.get_threshold()[:2], NEVER)


def keep() -> None:
    """Tell the collector that what is there stays, flights and widgets: to look through them takes a tenth of a second
    where they are thousands."""
    gc.collect(1)
    gc.freeze()


def tidy() -> None:
    """Collect whatever has come together while keys were pressed."""
    if gc.get_count()[2] >= DUE:
        gc.collect()
