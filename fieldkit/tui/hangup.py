"""Detect without a signal that the source of keys is gone: a terminal, if the app has its own session, or the server
that displays the app in a browser."""

import os
import sys

try:
    from select import POLLERR, POLLHUP, poll
except ImportError:  # Windows, which ends the app itself when its console closes
    poll = None  # type: ignore[assignment,misc]

CHECK_INTERVAL = 1.0
"""Time between checks that the other end is still there. [s]"""


def terminal() -> int | None:
    """The file descriptor of the terminal or server that keys come from; None if there is none or it cannot be
    polled."""
    keys = sys.__stdin__
    served = "TEXTUAL_DRIVER" in os.environ
    return keys.fileno() if keys is not None and poll is not None and (served or keys.isatty()) else None


def gone(terminal: int) -> bool:
    """Whether the other end is closed. Reading would detect that too, but would consume a key if there is one."""
    held = poll()
    held.register(terminal, 0)  # a hangup is always reported
    return any(event & (POLLHUP | POLLERR) for _, event in held.poll(0))


def nobody_looks(error: BaseException) -> bool:
    """Whether an error means only that the other end is closed, or comes after it was closed: nothing in the app has
    failed."""
    held = terminal()
    return isinstance(error, BrokenPipeError) or (held is not None and gone(held))
