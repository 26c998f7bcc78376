"""Removing a flight from the ledger on a page; undo restores it."""

from collections.abc import Callable

from textual.binding import Binding

from fieldkit.flight.short_name import flight_label
from fieldkit.tui.page import PageScreen

REMOVE = Binding("x,delete", "remove", "Remove", key_display="x", tooltip="Remove this flight; u to undo", show=False)
"""The key of `action_remove`."""


def leave(page: PageScreen, id: str) -> None:
    """Leave the screen of a flight that is no longer in the ledger: undo or another program has removed it."""
    page.show_notice(f"{flight_label(id, 'Flight')} is no longer in the ledger")
    close(page)


def close(page: PageScreen) -> None:
    """Dismiss the screen of a removed flight; if a dialog is above it, after that has closed, so that no text is
    lost."""
    if page.app.screen is page:
        page.dismiss()
    else:
        page.reload_on_resume()


def remove(page: PageScreen, id: str, then: Callable[[], object] = lambda: None) -> None:
    """Remove a flight, show how to undo it, and continue with `then`."""

    def removed(_: object) -> None:
        then()
        page.show_change(f"Removed {flight_label(id)}. u to undo")

    page.change(lambda: page.resources.ledger.remove(id), removed)
