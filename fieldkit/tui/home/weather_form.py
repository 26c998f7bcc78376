"""The form of today's weather."""

from functools import partial

from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.columns import WEATHER
from fieldkit.importing.manual_entry import Question
from fieldkit.quantities import measure, unit_of
from fieldkit.services.day_weather import save_weather
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen
from fieldkit.tui.setup.setup_lists import same


def ask_weather(page: PageScreen, now: Flight) -> None:
    """Ask for today's weather and save it."""
    system = page.resources.settings.units
    questions = [Question(name, BY_NAME[name].title, f"{BY_NAME[name].help} Empty: not known.") for name in WEATHER]
    texts = {name: measure(BY_NAME[name], now.number(name), system) for name in WEATHER}
    units = {name: unit_of(BY_NAME[name], system) for name in WEATHER}

    def answered(values: dict[str, object]) -> None:
        kept = {name for name, new in values.items() if same(name, new, texts[name], system)}
        weather = Flight().with_changes(**values | {name: now.number(name) for name in kept})
        page.change(
            partial(save_weather, page.resources.ledger, weather),
            lambda new: page.show_change("Weather saved for today. u to undo" if new else "Weather unchanged"),
        )

    page.ask_form(Form("Today's weather", questions, texts, units), answered)
