"""Detect without a signal that the source of keys is gone: a terminal, if the app has its own session, or the server
that displays the app in a browser."""

import os
import sys
from threading import Thread
from time import sleep

try:
    from select import POLLERR, POLLHUP, poll
except ImportError:  # Windows, which ends the app itself when its console closes
    poll = None  # type: ignore[assignment,misc]

CHECK_INTERVAL = 1.0
"""Time between checks that the other end is still there. [s]"""
GRACE = 5.0
"""Time for the app to exit by itself after the other end is gone. [s]"""


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


def never_outlive(terminal: int) -> None:
    """End this process soon after the other end is gone, whatever keeps it alive: a computing thread, an open question,
    an event loop left idle by a write error.

    Typed text is already saved, and an incomplete change of the ledger is rolled back.
    """
    Thread(target=_end_after, args=(terminal,), name="hangup", daemon=True).start()


def _end_after(terminal: int) -> None:
    while not gone(terminal):
        sleep(CHECK_INTERVAL)
    sleep(GRACE)
    os._exit(1)
