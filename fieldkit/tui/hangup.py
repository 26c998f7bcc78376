"""A terminal that has gone without a signal, as it goes where the app has a session of its own."""

import select
import sys


def terminal() -> int | None:
    """The terminal that keys come from, None where they come from elsewhere."""
    keys = sys.__stdin__
    return keys.fileno() if keys is not None and hasattr(select, "poll") and keys.isatty() else None


def gone(terminal: int) -> bool:
    """Whether nobody holds the other end any more. Reading would say so as well, and take a key where there is one."""
    held = select.poll()
    held.register(terminal, 0)  # a hang-up is told unasked
    return any(event & (select.POLLHUP | select.POLLERR) for _, event in held.poll(0))
