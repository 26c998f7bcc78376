"""Whoever sends keys has gone without a signal: a terminal, where the app has a session of its own, or the server that
shows the app in a browser."""

import os
import sys

try:
    from select import POLLERR, POLLHUP, poll
except ImportError:  # Windows, which ends the app itself when its console closes
    poll = None  # type: ignore[assignment,misc]


def terminal() -> int | None:
    """The terminal or the server that keys come from, None where they come from elsewhere or it cannot be asked."""
    keys = sys.__stdin__
    served = "TEXTUAL_DRIVER" in os.environ
    return keys.fileno() if keys is not None and poll is not None and (served or keys.isatty()) else None


def gone(terminal: int) -> bool:
    """Whether nobody holds the other end any more. Reading would say so as well, and take a key where there is one."""
    held = poll()
    held.register(terminal, 0)  # a hang-up is told unasked
    return any(event & (POLLHUP | POLLERR) for _, event in held.poll(0))
