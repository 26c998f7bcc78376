"""Select rows of a log with a trustworthy clock, and find where the clock restarts."""

from array import array
from bisect import bisect_right

import numpy as np

from fieldkit.shapes import Array, Bool, Flags, Float, Int, Integers

TWO_DAYS = 172_800.0
"""Rows further apart than this cannot belong to one flight. [s]"""
MAX_CLOCK = 1e11
"""Largest time that any logger counts to, even from 1970. [s]"""

COMPARED_TIMES, LEAST_SAMPLES, MOST_SAMPLES = (2.0, 1.0, 0.4), 8, 200
"""Times before and after a gap through which a parabola shows whether the heights continue: a burnout bends the longer
ones [s], and the fewest and most samples of each side. [1]"""
MOST_CONTINUED, LEAST_MOVED = 2.0, 3.0
"""Largest misfit of heights that continue, and smallest of those that contradict the gap, in their noise. [1]"""
LEAST_NOISE = 0.1
"""Smallest noise of heights. [m]"""


def credible(clock: Float[Array, "row"]) -> Bool[Flags, "row"]:
    """Largest set of rows in which the clock [s] never runs backward and contains no time that is days away."""
    middle = np.quantile(clock, 0.5, method="lower")
    kept = np.asarray(np.abs(clock - middle) < TWO_DAYS)
    kept[kept] = onward(clock[kept])
    return kept


def restarts(clock: Float[Array, "row"]) -> Int[Integers, "restart"]:
    """Rows where a clock [s] restarts: each of the three rows before is later than the three rows from there on."""
    if len(clock) < 6:
        return np.empty(0, np.int64)
    three = np.lib.stride_tricks.sliding_window_view(clock, 3)
    return np.flatnonzero(three[:-3].min(axis=1) > three[3:].max(axis=1)) + 3


def onward(clock: Float[Array, "row"]) -> Bool[Flags, "row"]:
    """Largest set of rows in which the clock [s] never runs backward."""
    if not (np.diff(clock) < 0).any():
        return np.ones(len(clock), bool)
    tails = array("d")  # the smallest last value of a run of each length, and the row that it is in
    ends, before = array("q"), array("q", bytes(8 * len(clock)))
    for row, value in enumerate(clock.tolist()):
        length = bisect_right(tails, value)
        before[row] = ends[length - 1] if length else -1
        tails[length : length + 1] = array("d", [value])
        ends[length : length + 1] = array("q", [row])
    kept, row = np.zeros(len(clock), bool), ends[-1]
    while row >= 0:
        kept[row] = True
        row = before[row]
    return kept


_MIN_RUNS, _SIMILAR = 5, 0.8
"""Fewest ticks of a clock that show how many rows it has in each [1], and the fraction of its steps that are equal and
of its rows that have a value [1]."""


def spread(clock: Float[Array, "row"], known: Bool[Flags, "row"]) -> Float[Array, "row"]:
    """A clock that has several rows in each of its ticks, such as whole seconds, with these rows at even times. [s]

    `known` are the rows with a value; those of sensors in turn may belong to one time. The first tick may lack rows at
    its beginning, the last at its end. A clock that is not so is returned as it is.
    """
    if not np.isfinite(clock).all() or known.mean() < _SIMILAR:
        return clock
    begins = np.flatnonzero(np.diff(clock, prepend=-np.inf) != 0)
    counts, steps = np.diff(np.append(begins, clock.size)), np.diff(clock[begins])
    if begins.size < _MIN_RUNS or (usual := int(np.median(counts[1:-1]))) < 2:
        return clock
    step = float(np.median(steps))
    equal = np.abs(steps - step) < 1e-6 * max(step, 1.0)
    if step <= 0 or equal.mean() < _SIMILAR or (np.abs(counts[1:-1] - usual) <= 1).mean() < _SIMILAR:
        return clock
    of_tick = np.maximum(counts, 1)
    of_tick[0], of_tick[-1] = max(of_tick[0], usual), max(of_tick[-1], usual)
    place = np.arange(clock.size) - np.repeat(begins, counts)
    place[: counts[0]] += of_tick[0] - counts[0]
    return np.asarray(clock + step * place / np.repeat(of_tick, counts))


def in_order(*columns: Float[Array, "row"]) -> tuple[Float[Array, "row"], ...]:
    """Columns with their rows sorted by the first column, a clock; of rows at the same time only the first is kept.

    Rows without a time, or with a time that no logger counts to, are dropped.
    """
    time = columns[0]
    known = np.flatnonzero(np.abs(time) < MAX_CLOCK)
    _, first = np.unique(time[known], return_index=True)
    return tuple(column[known[first]] for column in columns)


def continues(time: Float[Array, "row"], height: Float[Array, "row"], gap: int, step: float, around: float) -> bool:
    """Whether heights continue after a gap as if it were one step [s], and not as if it were as long as it seems, by
    those `around` it [s]."""
    known = np.isfinite(height) & np.isfinite(time)
    before = np.flatnonzero(known & (time <= time[gap]) & (time > time[gap] - around))[-MOST_SAMPLES:]
    after = np.flatnonzero(known & (time >= time[gap + 1]) & (time < time[gap + 1] + around))[:MOST_SAMPLES]
    if min(before.size, after.size) < LEAST_SAMPLES:
        return False
    there = np.append(before, after)
    since, shown = time[there] - time[gap], height[there]
    closed = since - np.where(since > 0, time[gap + 1] - time[gap] - step, 0.0)
    parts = [_misfit(since[one], shown[one]) for one in (np.s_[: before.size], np.s_[before.size :])]
    noise = max(float(np.linalg.norm(parts)) / float(np.sqrt(2)), LEAST_NOISE)
    return _misfit(closed, shown) < MOST_CONTINUED * noise and _misfit(since, shown) > LEAST_MOVED * noise


def _misfit(since: Float[Array, "sample"], height: Float[Array, "sample"]) -> float:
    """Standard deviation of heights from their parabola. [m]"""
    left = height - np.polyval(np.polyfit(since, height, 2), since)
    return float(np.sqrt((left**2).sum() / max(since.size - 3, 1)))
