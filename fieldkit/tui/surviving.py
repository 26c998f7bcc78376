"""How the app handles unexpected errors: it continues if it can, and otherwise remembers its state."""

import sys
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from textual import events

from fieldkit.tui.choosing import Choosing
from fieldkit.tui.crash import Crash, place_of, record
from fieldkit.tui.hangup import nobody_looks
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import Resources


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """The state before an error: the page, the row of its first table, and the error."""

    page: str
    row: Any
    crash: Crash


class Surviving(Choosing):
    """An app that continues after a failing key."""

    def __init__(self, resources: Resources) -> None:
        super().__init__(resources)
        self.error_console = Console(stderr=True, quiet=True)  # a failure is reported in one line
        self.place: Whereabouts | None = None
        """The state when an error ended the app."""
        self.errors: list[Exception] = []
        """Unexpected errors after which the app continued."""
        self._crashes: dict[str, Crash] = {}

    async def on_event(self, event: events.Event) -> None:
        """Handle an event; an error in it is reported, and the app continues."""
        try:
            await super().on_event(event)
        except Exception as error:
            self.survive(error)

    def survive(self, error: Exception) -> None:
        """Log an unexpected error, once for each place that it comes from, and show a notice."""
        if nobody_looks(error):
            self.exit()
            return
        self.errors.append(error)
        self.show_notice(self._crash(error).line(), error=True)

    def _crash(self, error: BaseException) -> Crash:
        crash = record(error) if (known := self._crashes.get(place_of(error))) is None else known
        return self._crashes.setdefault(crash.where, crash)

    def bell(self) -> None:
        """Save the state before an error ends the app: Textual rings the bell only then."""
        error = sys.exception()
        if error is not None and self.place is None and not nobody_looks(error):
            self.place = Whereabouts(self.current_mode, self._row(), self._crash(error))
        super().bell()

    def _row(self) -> Any:
        try:
            return page.row() if isinstance(page := self.screen_stack[0], PageScreen) else None
        except Exception:  # an app that is failing may have no screen left
            return None
