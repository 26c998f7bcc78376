"""Saving the flight on the Add page: doubtful answers are confirmed first, and the result is shown."""

from collections.abc import Callable
from functools import partial

from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.tui.add.add_form import READOUT_QUESTIONS, Answered, Draft, Saved
from fieldkit.tui.add.add_sheet import Sheet
from fieldkit.tui.add.after_card import AfterCard, AfterFlight, after_flight
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets.dialogs import AskYes

DUPLICATE = "Duplicate: it is already in the ledger."


class Saving:
    """Saves the answers to the ledger, and shows the card that then replaces the form."""

    def __init__(self, page: PageScreen, sheet: Sheet, draft: Draft) -> None:
        self._page, self._sheet, self._draft = page, sheet, draft
        self._objections: list[str] = []

    @property
    def card(self) -> AfterCard:
        """The card of the flight that was just saved."""
        return self._page.query_one(AfterCard)

    def object_to(self, trouble: str) -> None:
        """Show `trouble` with an answer as a notice, which stays until the flight is saved; nothing if it is empty."""
        if trouble:
            self._objections.append(trouble)
            self._page.complain(trouble)

    async def save_once(self, answered: Answered) -> None:
        """Save the flight in the ledger unless a card is shown; the next keys wait, because saving clears the form."""
        if not self.card.display:
            self.save(answered)
            await self._page.settled("save")

    def save(self, answered: Answered, *, confirmed: bool = False) -> None:
        """Save the flight in the ledger."""
        self._page.ask(partial(self._draft.save, answered, confirmed=confirmed), partial(self._saved, answered), "save")

    def clear_if_saved(self, read: Callable[[], Answered], go_on: Callable[[], None]) -> None:
        """Clear a flight that is in the ledger now, unless something was typed meanwhile; else continue with `go_on`.
        `read` returns the answers."""
        typed = read().flight

        def clear(saved: bool) -> None:
            if saved and read().flight == typed:
                self._sheet.clear()
                self._page.reload()
            else:
                go_on()

        self._page.ask(partial(self._draft.is_saved, typed), clear, "start")

    def leave_card(self) -> None:
        """Return to the form."""
        self._front(card=False)

    def _saved(self, answered: Answered, saved: Saved) -> None:

        if saved.confirm:
            self._page.app.push_screen(AskYes(saved.confirm), partial(self._confirmed, answered))
            return
        if saved.wrong:
            self.object_to(saved.trouble)
            self._page.set_focus(self._sheet.field(saved.wrong).line)
            return
        for objection in self._objections:
            self._page.field_app.withdraw(objection)
        self._objections = []
        silent = f" Without its {saved.lacks} it does not constrain Cd." if saved.lacks else ""
        self._page.show_notice(f"Saved {flight_label(saved.id)}. u to undo.{silent}" if saved.id else DUPLICATE)
        if saved.trouble:
            self._page.complain(saved.trouble)
        self._sheet.clear()
        if saved.id and saved.flight is not None:
            self._compare(saved.id, saved.flight)
        else:
            self._page.set_focus(self._sheet.button)  # outside a field, a digit opens a page
        self._page.field_app.changed()

    def _confirmed(self, answered: Answered, yes: bool | None) -> None:
        """Save the flight anyway, or return to it."""
        if yes:
            self.save(answered, confirmed=True)
        else:
            self._page.set_focus(self._sheet.field(READOUT_QUESTIONS[0]).line)

    def _compare(self, id: str, flight: Flight) -> None:
        """Show forecast and flown, and the next forecast, as soon as they are computed."""
        resources = self._page.resources
        self.card.saved(id, flight, resources.settings.units)
        self._front(card=True)
        self._page.set_focus(self.card)
        self._page.ask(partial(after_flight, resources, flight), self._show, "outcome")

    def _show(self, found: AfterFlight | None) -> None:
        self.card.show(found, self._page.resources.settings.units)

    def _front(self, *, card: bool) -> None:
        for widget in self._sheet.widgets():
            widget.display = not card
        self.card.display = card
