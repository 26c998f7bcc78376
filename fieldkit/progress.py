"""Long work tells how far it is: whoever waits for it hands it something to tell."""

from collections.abc import Callable

ReportProgress = Callable[[str, float], None]
"""Told what is being done and the share that is done."""


def no_op(_text: str, _share: float) -> None:
    """Where nobody listens."""


def part(tell: ReportProgress, start: float, share: float) -> ReportProgress:
    """What a part of some work is to tell, which begins at one share of the whole and is another."""
    return lambda text, done: tell(text, start + share * done)
