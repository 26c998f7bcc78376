"""A screen that queries the engine: in workers, in order, and canceled if no longer needed."""

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable
from contextlib import nullcontext
from typing import ClassVar, Literal, TypeVar, cast

from textual.screen import Screen
from textual.worker import get_current_worker

from fieldkit.errors import FieldkitError
from fieldkit.tui.computing import Turn
from fieldkit.tui.host import Host
from fieldkit.tui.resources import Resources

T = TypeVar("T")
WAIT = 0.005
"""Polling interval for results that keys wait for. [s]"""


class Dropped(Exception):
    """The answer is no longer needed."""


def go_on() -> None:
    """Called within a worker: lets other computations of the app go first. Raises Dropped if its answer is no longer
    needed."""
    worker = get_current_worker()
    if not worker.is_cancelled:
        cast(Host, worker.node.app).computing.give_way(lambda: worker.is_cancelled)
    if worker.is_cancelled:
        raise Dropped


class AskingScreen(Screen[None]):
    """A screen whose work blocks no key, with the resources of its app."""

    ROW_REQUESTS: ClassVar[tuple[str, ...]] = ("ask",)
    """The groups of requests whose answers fill its first table."""

    def __init__(self) -> None:
        super().__init__()
        self._turns: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)
        self._alone: defaultdict[str, Turn] = defaultdict(Turn)

    @property
    def resources(self) -> Resources:
        """The ledger, the motors, the settings."""
        return self.field_app.resources

    @property
    def field_app(self) -> Host:
        """The app by the interface for its pages, because its module imports theirs."""
        return cast(Host, self.app)

    def ask(
        self,
        question: Callable[[], T],
        answer: Callable[[T], None],
        group: str = "ask",
        *,
        in_turn: bool = False,
        alone: Literal["", "group", "app"] = "",
    ) -> None:
        """Run work in a worker of this screen, which ends with it, and pass its result to `answer`.

        A newer request of a group drops an older one, or waits for it if `in_turn`. An error becomes a notice; an
        unexpected one also a crash file. Threads cannot be stopped, so dropped work runs to its end or to its next call
        of `go_on`. Long requests run `alone`, the newest next: one at a time in their group, or in the whole `app` if
        they take much memory.
        """

        def shown(result: T) -> None:
            if self.display:  # false while the screen is removed: its widgets go first, its workers last
                answer(result)

        async def work() -> None:
            async with self._turns[group] if in_turn else nullcontext():
                turn = self.field_app.computing if alone == "app" else self._alone[group]
                await self._pass_on(turn.compute(question) if alone else asyncio.to_thread(question), shown)

        self.run_worker(work, exclusive=not in_turn, group=group)  # type: ignore[arg-type]  # narrower than it takes

    async def _pass_on(self, question: Awaitable[T], answer: Callable[[T], None]) -> None:
        """Pass a result on, or report the error."""
        try:
            answer(await question)
        except FieldkitError as error:
            self.complain(str(error))
            self.unanswered()
        except Exception as error:
            self.field_app.survive(error)
            self.unanswered()

    def unanswered(self) -> None:
        """Called after the notice of an error: what was announced will not be shown."""

    async def settled(self, *groups: str) -> None:
        """Wait until the requests of some groups are answered: keys typed ahead depend on the answers."""
        while self.is_asking(*groups):
            await asyncio.sleep(WAIT)

    def is_asking(self, *groups: str) -> bool:
        """Whether requests of some groups are not answered yet."""
        nodes = (self, self.app)  # changes are made by the app
        return any(one.group in groups and one.node in nodes and not one.is_finished for one in self.workers)

    def change(self, question: Callable[[], T], answer: Callable[[T], None]) -> None:
        """Change the ledger in a worker of the app, whose result is shown even if this screen has closed; changes are
        made in the order of the keys, whatever their screens."""

        async def work() -> None:
            async with self.field_app.changing:
                await self._pass_on(asyncio.to_thread(question), answer)

        self.app.run_worker(work, group="change")  # type: ignore[arg-type]  # narrower than it takes

    def show_notice(self, text: str) -> None:
        """Show a notice of success."""
        self.field_app.show_notice(text)

    def complain(self, text: str) -> None:
        """Show a notice that must be dismissed."""
        self.field_app.show_notice(text, error=True)


def or_why(work: Callable[[], T]) -> Callable[[], T | str]:
    """Work that returns the message of a FieldkitError instead of raising it, so that no notice is shown."""

    def tried() -> T | str:
        try:
            return work()
        except FieldkitError as error:
            return str(error)

    return tried
