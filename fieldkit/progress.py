"""Progress callbacks: long computations report the current step and the fraction done."""

from collections.abc import Callable

ReportProgress = Callable[[str, float], None]
"""Callback with the current step and the fraction done. [1]"""


def no_op(_text: str, _share: float) -> None:
    """The callback that ignores every report: a step, and the fraction done. [1]"""


def part(on_progress: ReportProgress, start: float, covered: float) -> ReportProgress:
    """The callback for a part of a computation that starts at one fraction of the whole [1] and covers another [1]."""
    return lambda text, done: on_progress(text, start + covered * done)
