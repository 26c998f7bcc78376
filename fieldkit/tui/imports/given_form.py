"""The form of values that a file lacks: rocket, motor, site, date and mass, for every flight in it."""

from collections.abc import Callable, Mapping

from fieldkit.flight import BY_NAME
from fieldkit.importing.manual_entry import Question, read_answer
from fieldkit.quantities import unit_of
from fieldkit.services.manual_entry import with_unit
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen

TEXTS = {"rocket": "Rocket", "config": "Configuration", "motor": "Motor", "site": "Site", "date_time": "Date"}
NUMBERS = ("dry_mass", "diameter")
"""Columns that are asked for: texts with their titles, and numbers."""
QUESTIONS = (
    *(Question(name, title, "For every flight in the file that lacks it.") for name, title in TEXTS.items()),
    *(Question(name, BY_NAME[name].title, BY_NAME[name].help) for name in NUMBERS),
)


def ask_given(page: PageScreen, given: Mapping[str, str], answer: Callable[[dict[str, str]], None]) -> None:
    """Ask for values that a file lacks; values `given` for other columns are unchanged. `answer` gets all of them as
    text."""
    units = {name: unit_of(BY_NAME[name], page.resources.settings.units) for name in NUMBERS}
    texts = {question.name: given.get(question.name, "") for question in QUESTIONS}

    def answered(values: dict[str, object] | None) -> None:
        if values is not None:
            named = {name: str(text) for name, text in values.items() if text}
            answer({name: text for name, text in given.items() if name not in texts} | named)

    page.app.push_screen(Form("Not in the file", QUESTIONS, texts, units, _checked, page.resources.names), answered)


def _checked(name: str, text: str, unit: str) -> str:
    """An answer as it was typed, with its unit. Raises BadValue for one that cannot be read."""
    read_answer(name, text, unit)
    return with_unit(text, unit)
