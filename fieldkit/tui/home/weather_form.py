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
    page.app.push_screen(Form("Today's weather", questions, texts, units), partial(_answered, page, now, texts))


def _answered(page: PageScreen, now: Flight, texts: dict[str, str], values: dict[str, object] | None) -> None:
    if values is None:
        return

    system = page.resources.settings.units
    values = {name: now.number(name) if same(name, new, texts[name], system) else new for name, new in values.items()}

    def work() -> bool:
        return save_weather(page.resources.ledger, Flight().with_changes(**values))

    page.change(work, partial(_saved, page))


def _saved(page: PageScreen, new: bool) -> None:
    page.show_notice("Weather saved for today. u to undo" if new else "Weather unchanged")
    page.field_app.changed()
