"""Values that a log lacks, from the open forecast or the last flight: rocket, motor, mass and site; the date is
today."""

from collections.abc import Callable, Mapping

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.importing.manual_entry import read_changes
from fieldkit.services.manual_entry import planned_answers
from fieldkit.tui.add.add_form import Draft
from fieldkit.tui.imports.given_form import QUESTIONS, ask_given
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import Resources


def setup_of_day(resources: Resources) -> dict[str, str]:
    """The setup of the open forecast, else of the last flight, by question."""
    offers = Draft(resources).offers({})
    return {one.name: text for one in QUESTIONS if (text := offers.get(one.name, ""))}


def waiting_setup(resources: Resources) -> dict[str, str]:
    """The setup as in `setup_of_day` while a forecast is open; otherwise empty."""
    return setup_of_day(resources) if planned_answers(resources.ledger) else {}


def is_open(flights: tuple[Flight, ...]) -> bool:
    """Whether any flight lacks its rocket or its motor."""
    return any(not (flight.rocket and flight.motor) for flight in flights)


def ask_setup(page: PageScreen, known: Mapping[str, str], store: Callable[[dict[str, object]], None]) -> None:
    """Ask for values that a log lacks, with what is `known` filled in; `store` gets them as fields of a flight."""

    def answered(given: dict[str, str]) -> None:
        try:
            store(read_changes(Flight(), given))
        except BadValue as error:
            page.complain(str(error))

    ask_given(page, known, answered)
