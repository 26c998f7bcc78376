"""Detects that the sender of keys has gone without a signal: a terminal, if the app has its own session, or the server
that shows the app in a browser."""

import os
import sys

try:
    from select import POLLERR, POLLHUP, poll
except ImportError:  # Windows, which ends the app itself when its console closes
    poll = None  # type: ignore[assignment,misc]


def terminal() -> int | None:
    """The terminal or the server that keys come from, None if they come from elsewhere or it cannot be polled."""
    keys = sys.__stdin__
    served = "TEXTUAL_DRIVER" in os.environ
    return keys.fileno() if keys is not None and poll is not None and (served or keys.isatty()) else None


def gone(terminal: int) -> bool:
    """Whether the other end is closed. Reading would show that too, but would consume a key if there is one."""
    held = poll()
    held.register(terminal, 0)  # a hang-up is always reported
    return any(event & (POLLHUP | POLLERR) for _, event in held.poll(0))
