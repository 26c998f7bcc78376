"""How much tests try: everything if the variable `FIELDKIT_THOROUGH` is set, as in `.ci/run`, or else a part."""

import os
from collections import defaultdict
from collections.abc import Sequence
from typing import TypeVar
from zlib import crc32

import pytest
from hypothesis import settings

THOROUGH = bool(os.environ.get("FIELDKIT_THOROUGH"))
PART = 4

Case = TypeVar("Case")


def examples(count: int) -> settings:
    """Number of examples that hypothesis generates: all of them in the thorough run, a quarter in others."""
    return settings(max_examples=count if THOROUGH else max(count // PART, 2), deadline=None)


def part(cases: Sequence[Case], start: int = 0) -> Sequence[Case]:
    """All cases in the thorough run, every fourth of them in others.

    `start` shifts which ones, so that the tests of many subjects try every case on some of them.
    """
    return cases if THOROUGH else cases[start % PART :: PART]


def left_out(items: Sequence[pytest.Item]) -> set[pytest.Item]:
    """Three of four cases of each test with the marker `sampled`: always the same, in no regular pattern."""
    tests = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sampled"):
            tests[item.nodeid.partition("[")[0]].append(item)
    return {
        item
        for cases in tests.values()
        for item in sorted(cases, key=lambda case: crc32(case.nodeid.encode()))[-(-len(cases) // PART) :]
    }
