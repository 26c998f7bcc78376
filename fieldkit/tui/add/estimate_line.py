"""The live estimate on the Add page: Cd, alpha and the next apogee by a linear pass."""

import asyncio
from contextlib import suppress
from functools import partial
from typing import cast

from textual.content import Content
from textual.widgets import Static

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.presentation.typed_flight_text import estimate_line, estimate_rows
from fieldkit.safe_text import printable
from fieldkit.services.manual_entry import weighed
from fieldkit.services.typed_flight import TypedEstimate, TypedFlight
from fieldkit.tui.asking import go_on
from fieldkit.tui.next.intervals import IntervalBar, bar
from fieldkit.tui.page import PageScreen

PAUSE = 0.15
"""Time without a key after which the estimate is computed: longer than between two digits. [s]"""
MIN_BAR = 16
"""Cells of an interval, below which the estimate is one line of text."""


class EstimateLine(Static):
    """One line below the current field, or three intervals beside it on a wide screen; it is computed in the
    background, and only the newest is shown."""

    DEFAULT_CSS = """
    EstimateLine { height: 1; padding: 0 1; text-wrap: nowrap; text-overflow: ellipsis; color: $text-muted; }
    """

    def __init__(self) -> None:
        super().__init__("", id="estimate")
        self.border_title = "The same flight again"
        self._beside: TypedFlight | None = None
        self._last: tuple[Flight, float | None] | None = None
        self._found: TypedEstimate | None = None
        self._scales: dict[str, tuple[float, float]] = {}

    @property
    def _page(self) -> PageScreen:
        return cast(PageScreen, self.screen)

    def forget(self) -> None:
        """Read the flights of the ledger again, because it has changed."""
        self._beside = self._last = None
        self._scales.clear()

    def follow(self, typed: Flight, lift_off: float | None = None) -> None:
        """Show the estimate from the values so far, once typing pauses; `lift_off` is the mass with the motor, if the
        rocket was weighed with it [kg]."""
        if (typed, lift_off) == self._last:
            return
        self._last = typed, lift_off
        self.run_worker(partial(self._ask, typed, lift_off), exclusive=True, group="pause")  # type: ignore[arg-type]  # narrower than it takes

    async def _ask(self, typed: Flight, lift_off: float | None) -> None:
        await asyncio.sleep(PAUSE)
        self._page.ask(partial(self._work, typed, lift_off), self._show, "estimate", alone="group")

    def _work(self, typed: Flight, lift_off: float | None) -> TypedEstimate:
        go_on()
        beside = self._beside
        if beside is None:
            beside = self._beside = TypedFlight(self._page.resources.ledger, self._page.resources.motors)
        with suppress(FieldkitError):  # the form shows why
            typed = weighed(self._page.resources.motors, typed, lift_off)
        return beside.estimate(typed)

    def _show(self, found: TypedEstimate) -> None:
        self._found = found
        self.on_resize()

    def on_resize(self) -> None:
        """Draw the estimate for the current width and height."""
        if self._found is None:
            return
        system = self._page.resources.settings.units
        rows = estimate_rows(self._found, system)
        room = self.size.width - 2 - sum(max((len(row[at]) for row in rows), default=0) + 2 for at in (0, 1))
        if not rows or self.size.height < len(rows) or room < MIN_BAR:
            self.update(Content(printable(estimate_line(self._found, system))), layout=False)
            return
        lead, end = (max(len(row[at]) for row in rows) for at in (0, 1))
        lines = [f"{name:{lead}}  {self._drawn(name, interval, room)}  {text:{end}}" for name, text, interval in rows]
        self.update(Content("\n".join(lines)), layout=False)

    def _drawn(self, name: str, interval: tuple[float, float, float], room: int) -> str:
        """An interval on the widest scale used so far for this flight, so that it visibly narrows as readouts are
        typed."""
        row = IntervalBar(name, *interval)
        low, high = self._scales.get(name, row.ends)
        low, high = self._scales[name] = min(low, row.low), max(high, row.high)
        return bar(row, low, high, room)
