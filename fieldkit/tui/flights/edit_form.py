"""Editing a flight: the form of the Add page, filled with what is known."""

from collections.abc import Callable
from functools import partial

from fieldkit.errors import BadValue
from fieldkit.flight import CONDITIONS, Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.importing.manual_entry import JUDGED_QUESTIONS, QUESTIONS, Question, date_order, with_cells
from fieldkit.quantities import unit_of
from fieldkit.services.renaming import edit_flights
from fieldkit.tui.add.add_form import DATE
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import Resources
from fieldkit.tui.setup.setup_lists import answer_of, same

ASKED_NAMES = {question.name for question in QUESTIONS}
EDIT_QUESTIONS = (
    *QUESTIONS[:3],
    DATE,
    *QUESTIONS[3:],
    *(Question(column.name, column.title, column.help) for column in CONDITIONS if column.name not in ASKED_NAMES),
    *JUDGED_QUESTIONS,
)
"""The editable fields of a flight, in the order of the Add page."""


def ask_changes(page: PageScreen, id: str, flight: Flight, renamed: Callable[[str], object]) -> None:
    """Open a form over a flight; its changes are one change of the ledger. `renamed` gets the id of the changed
    flight."""
    system = page.resources.settings.units
    texts = {question.name: answer_of(flight, question, system) for question in EDIT_QUESTIONS}
    units = {
        question.name: unit_of(question.column, system) for question in EDIT_QUESTIONS if question.column is not None
    }
    units[DATE.name] = date_order(system)
    form = Form(flight_label(id, "Flight"), EDIT_QUESTIONS, texts, units, names=page.resources.names)

    def answered(values: dict[str, object]) -> None:
        changes = {name: new for name, new in values.items() if not same(name, new, texts[name], system)}
        if not changes:
            page.show_notice(f"{flight_label(id, 'Flight')} unchanged")
            return
        titles = ", ".join(question.title.lower() for question in EDIT_QUESTIONS if question.name in changes)

        def saved(done: tuple[str, list[str]]) -> None:
            now, notes = done
            renamed(now)
            page.show_change("; ".join([f"Saved {flight_label(now)}: {titles}", *notes]) + ". u to undo")

        page.change(partial(_save, page.resources, flight, changes), saved)

    page.ask_form(form, answered)


def _save(resources: Resources, flight: Flight, changes: dict[str, object]) -> tuple[str, list[str]]:
    """Change a flight; returns its id now, and notes. Raises BadValue for an unknown motor."""
    motor = str(changes.get("motor", ""))
    if motor and (trouble := resources.names().motor_trouble(motor)):
        raise BadValue(f"motor: {trouble}")
    judged = {one.name: str(changes.pop(one.name)) for one in JUDGED_QUESTIONS if one.name in changes}
    if judged:
        changes["extra"] = with_cells(flight.extra, judged)
    done = edit_flights(resources.ledger, [flight], [changes])
    return resources.ledger.ids(done.flights)[0], done.notes
