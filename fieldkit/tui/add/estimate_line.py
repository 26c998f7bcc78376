"""The live estimate on the page Add: Cd, alpha and the next apogee by the network."""

import asyncio
from functools import partial
from typing import TYPE_CHECKING, cast

from textual.content import Content
from textual.widgets import Static

from fieldkit.flight import Flight
from fieldkit.safe_text import printable
from fieldkit.tui.asking import go_on
from fieldkit.tui.page import PageScreen

if TYPE_CHECKING:
    from fieldkit.services.typed_flight import TypedEstimate, TypedFlight

PAUSE = 0.15
"""Time without a key after which the estimate is computed: longer than between two digits. [s]"""


class EstimateLine(Static):
    """One line below the current field; it is computed in the background, and only the newest is shown."""

    DEFAULT_CSS = """
    EstimateLine { height: 1; padding: 0 2; text-wrap: nowrap; text-overflow: ellipsis; color: $text-muted; }
    """

    def __init__(self) -> None:
        super().__init__("", id="estimate")
        self._beside: TypedFlight | None = None
        self._last: Flight | None = None

    @property
    def _page(self) -> PageScreen:
        return cast(PageScreen, self.screen)

    def forget(self) -> None:
        """Read the flights of the ledger again, because it has changed."""
        self._beside = self._last = None

    def follow(self, typed: Flight) -> None:
        """Show the estimate from the values so far, once typing pauses."""
        if typed == self._last:
            return
        self._last = typed
        self.run_worker(partial(self._ask, typed), exclusive=True, group="pause")  # type: ignore[arg-type]  # narrower than it takes

    async def _ask(self, typed: Flight) -> None:
        await asyncio.sleep(PAUSE)
        self._page.ask(partial(self._work, typed), self._show, "estimate")

    def _work(self, typed: Flight) -> "TypedEstimate":
        from fieldkit.services.typed_flight import TypedFlight

        go_on()
        beside = self._beside
        if beside is None:
            beside = self._beside = TypedFlight(self._page.resources.ledger, self._page.resources.motors)
        return beside.estimate(typed)

    def _show(self, found: "TypedEstimate") -> None:
        from fieldkit.presentation.typed_flight_text import estimate_line

        self.update(Content(printable(estimate_line(found, self._page.resources.settings.units))), layout=False)
