"""Turns of computations that take much memory or time: one at a time, so that their memory does not add up."""

import asyncio
from collections.abc import Callable
from concurrent.futures import wait
from functools import partial
from threading import get_ident
from time import monotonic
from typing import TypeVar

from fieldkit.tui.memory import give_back

T = TypeVar("T")
MAX_PAUSED = 2
"""Number of computations that may have given way at the same time, because each keeps its memory. [1]"""
DROP_INTERVAL = 0.05
"""Interval at which one that has given way checks whether its result is still needed. [s]"""
GIVE_BACK_INTERVAL = 0.25
"""Time after which a long computation returns free memory, which takes 2 to 6 ms and returns about 15 MB. [s]"""


class Turn:
    """A turn that one computation has; the others wait, and one that is no longer needed leaves the queue, even if it
    has started."""

    def __init__(self) -> None:
        self._lock = asyncio.Lock()
        self._owner: object = None
        """The computation that has the turn."""
        self._waiting = self._paused = 0
        """Numbers of computations that have not started, and of those that have given way."""
        self._given_back = 0.0
        """When memory was last returned. [s]"""
        self._thread: int | None = None
        """The thread of the computation that has the turn."""

    async def compute(self, work: Callable[[], T]) -> T:
        """The result of work in a thread, when it has the turn. A thread cannot be stopped: if the result is no longer
        needed, the turn ends with the thread."""
        one = object()
        self._loop = asyncio.get_running_loop()
        self._waiting += 1
        try:
            await self._take(one)
        finally:
            self._waiting -= 1

        def done() -> T:
            self._thread = get_ident()
            try:
                return work()
            finally:
                if self._thread == get_ident():  # unless it gave way and was dropped
                    self._thread = None
                give_back()

        running = asyncio.ensure_future(asyncio.to_thread(done))
        running.add_done_callback(partial(self._ended, one))
        try:
            return await asyncio.shield(running)
        finally:
            del running  # the traceback of a dropped request would keep its result

    def give_way(self, dropped: Callable[[], bool] = lambda: False) -> None:
        """Called by a computation between two steps: free memory is returned, and new ones go first, unless too many
        have given way. Ends early if it is `dropped` meanwhile; raises CancelledError if the app is closed."""
        if self._thread != get_ident():
            return
        if monotonic() - self._given_back > GIVE_BACK_INTERVAL:
            give_back()
            self._given_back = monotonic()
        if not self._waiting or self._paused >= MAX_PAUSED:
            return
        again = asyncio.run_coroutine_threadsafe(self._wait_again(self._owner), self._loop)
        while not wait([again], DROP_INTERVAL).done:
            if dropped() and again.cancel():
                return
        again.result()
        self._thread = get_ident()

    async def _take(self, one: object) -> None:
        await self._lock.acquire()
        self._owner = one

    def _release(self) -> None:
        self._owner = None
        self._lock.release()

    async def _wait_again(self, one: object) -> None:
        self._paused += 1
        self._release()
        try:
            await self._take(one)
        finally:
            self._paused -= 1

    def _ended(self, one: object, ended: "asyncio.Future[T]") -> None:
        """The thread has ended, perhaps dropped; keep neither its result nor its error."""
        if self._owner is one:  # else it gave way, and was dropped or the app was closed
            self._release()
        if not ended.cancelled():
            ended.exception()  # otherwise reported as never retrieved
