"""The interface of the app for its pages and its palette."""

from asyncio import Lock
from typing import Any, Protocol

from fieldkit.tui.computing import Turn
from fieldkit.tui.resources import Resources
from fieldkit.tui.widgets.bars import Notice


class Host(Protocol):
    """The interface of the app for its pages: `revision` and `look` count changes, as in `FieldkitApp`; `unseen` means
    that a page is being prepared behind the visible one; `changing` is held while the ledger is changed; large
    computations have the turn of `computing`."""

    resources: Resources
    notices: list[Notice]
    revision: int
    look: int
    unseen: bool
    changing: Lock
    computing: Turn

    def settled(self, page: str) -> None:
        """Called when the page of this name has read the flights."""

    def changed(self) -> None:
        """The ledger has changed: pages must be reloaded."""

    def count_change(self) -> None:
        """The ledger has changed, and the current page already shows it."""

    def show_notice(self, text: str, *, error: bool = False) -> None:
        """Show a notice."""

    def withdraw(self, text: str) -> None:
        """Remove a notice that no longer holds."""

    def survive(self, error: Exception) -> None:
        """Log an unexpected error, and show a notice."""

    def choose(self, done: str = "", **changes: Any) -> None:
        """Change settings, apply them, and save them."""

    def action_ask_target(self) -> None:
        """Ask for the target apogee."""

    def action_next_units(self) -> None:
        """Switch to the next system of units."""

    def action_next_theme(self) -> None:
        """Switch to the next colors."""

    async def open_flight(self, id: str) -> None:
        """Open a flight over the Flights page."""

    async def decide(self, view: int, write: str = "") -> None:
        """Open a decision for the motor selected on the page of the next flight, and ask for the page to `write`."""

    async def show_flights(self, words: str) -> None:
        """Show only the flights that match all of these words."""

    def action_read(self) -> None:
        """Dismiss the current notice."""

    async def action_page(self, name: str) -> None:
        """Show a page."""
