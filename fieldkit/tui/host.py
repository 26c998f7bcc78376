"""What pages and the palette ask of the app that shows them."""

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from fieldkit.tui.resources import Resources
    from fieldkit.tui.widgets.bars import Notice


class Host(Protocol):
    """What pages ask of the app that shows them."""

    resources: "Resources"
    notices: "list[Notice]"
    revision: int
    look: int
    unseen: bool

    def settled(self) -> None:
        """The flights have been read."""

    def changed(self) -> None:
        """The ledger has changed: pages are to fill themselves again."""

    def show_notice(self, text: str, *, error: bool = False) -> None:
        """Say something."""

    def withdraw(self, text: str) -> None:
        """Remove a notice that no longer holds."""

    def survive(self, error: Exception) -> None:
        """Log an unexpected error, and show a notice."""

    def choose(self, said: str = "", **changes: Any) -> None:
        """Change settings, show what they change, and keep them."""

    def ask_target(self) -> None:
        """Ask for the height to hit."""

    def action_next_units(self) -> None:
        """The next system of units."""

    def action_next_theme(self) -> None:
        """The next colors."""

    async def open_flight(self, id: str) -> None:
        """Open a flight over the page Flights."""

    async def show_flights(self, words: str) -> None:
        """The flights that hold all of some words."""

    def action_read(self) -> None:
        """The notice in front was read."""

    async def action_page(self, name: str) -> None:
        """Bring a page to the front."""
