"""Turns of computations that take much memory or time: one at a time, so that their memory does not add up."""

import asyncio
from collections.abc import Callable
from threading import get_ident
from time import monotonic
from typing import TypeVar

from fieldkit.tui.memory import give_back

T = TypeVar("T")
GIVE_BACK_INTERVAL = 0.25
"""Time after which a long computation returns free memory, which takes 2 to 6 ms and returns about 15 MB. [s]"""


class Turn:
    """A turn that one computation has; the others wait, and one that is no longer needed leaves the queue."""

    def __init__(self) -> None:
        self._lock = asyncio.Lock()
        self._waiting = 0
        self._given_back = 0.0
        """When memory was last returned. [s]"""
        self._thread: int | None = None
        """The thread of the computation that has the turn."""

    async def compute(self, work: Callable[[], T]) -> T:
        """The result of work in a thread, when it has the turn. A thread cannot be stopped: if the result is no longer
        needed, the turn ends with the thread."""
        await self._take()

        def done() -> T:
            self._thread = get_ident()
            try:
                return work()
            finally:
                self._thread = None
                give_back()

        running = asyncio.ensure_future(asyncio.to_thread(done))
        running.add_done_callback(self._ended)
        try:
            return await asyncio.shield(running)
        finally:
            del running  # the traceback of a dropped request would keep its result

    def give_way(self) -> None:
        """Called by a computation between two steps: free memory is returned, and others that wait go first. Raises
        CancelledError if the app is closed meanwhile."""
        if self._thread != get_ident():
            return
        if monotonic() - self._given_back > GIVE_BACK_INTERVAL:
            give_back()
            self._given_back = monotonic()
        if self._waiting:
            asyncio.run_coroutine_threadsafe(self._wait_again(), self._loop).result()
            self._thread = get_ident()

    async def _take(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._waiting += 1
        try:
            await self._lock.acquire()
        finally:
            self._waiting -= 1

    async def _wait_again(self) -> None:
        self._lock.release()
        await self._take()

    def _ended(self, ended: "asyncio.Future[T]") -> None:
        """The thread has ended, perhaps dropped; keep neither its result nor its error."""
        if self._lock.locked():  # else it gave way, and the app was closed
            self._lock.release()
        if not ended.cancelled():
            ended.exception()  # otherwise reported as never retrieved
