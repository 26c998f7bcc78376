"""Taking a first step with an empty ledger: a rocket in four fields, or the demo rocket."""

from functools import partial

from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, Flight
from fieldkit.forecast.prediction import Prediction
from fieldkit.importing.manual_entry import Question, read_answer
from fieldkit.motors import Catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.quantities import measure, unit_of
from fieldkit.services.imports import bring_in
from fieldkit.services.kits import kits
from fieldkit.services.launch_day import first_forecast
from fieldkit.tui.add.fields import Form
from fieldkit.tui.home.first_steps import Step
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets import cards

QUESTIONS = (
    Question("rocket", "Rocket", "Its name, as shown in lists."),
    Question("dry_mass", "Dry mass", "Ready to fly, with recovery and payload, without the motor: 330g or 11.6 oz."),
    Question("diameter", "Diameter", "The widest tube of the body: 66mm or 2.6 in."),
    Question("motor", "Motor", "As printed on it: F24-4W, C6-5."),
)
"""The fields of a first forecast."""
EXAMPLES = {
    "rocket": "a name such as Astra",
    "dry_mass": "a mass such as 330g or 11.6oz",
    "motor": "a motor such as F24-4W",
}
"""The message about a missing answer; without a diameter a usual one is assumed."""


async def take(page: PageScreen, step: Step) -> None:
    """Take a first step."""
    match step:
        case Step.ROCKET:
            page.ask(lambda: page.resources.motors, partial(_ask_rocket, page), "motors")
            await page.settled("motors")
        case Step.DEMO:
            page.change(
                lambda: len(bring_in(page.resources.ledger, [REFERENCE_FLIGHTS], lambda name: None).ids),
                lambda count: page.show_change(f"Loaded {count} flights of the demo rocket. u to undo"),
            )
        case Step.FILES:
            await page.field_app.action_page("import_files")
        case Step.TYPE:
            await page.field_app.action_page("add")


def _ask_rocket(page: PageScreen, motors: Catalogue) -> None:
    system = page.resources.settings.units
    units = {name: unit_of(BY_NAME[name], system) for name in ("dry_mass", "diameter")}
    form = Form("Your rocket", QUESTIONS, {}, units, partial(read_first, motors), page.resources.names)
    page.ask_form(form, partial(_described, page))


def read_first(motors: Catalogue, name: str, text: str, unit: str) -> object:
    """An answer about a first rocket. Raises BadValue for one that is missing, cannot be read, or names no motor.

    A mass may be missing if the flyer has kits, which the rocket may be named after.
    """
    if not text.strip() and name in EXAMPLES and not (name == "dry_mass" and kits()):
        raise BadValue(f"expected {EXAMPLES[name]}")
    if name == "motor" and (trouble := motors.complaint(text)):
        raise BadValue(trouble)
    return read_answer(name, text, unit)


def _described(page: PageScreen, values: dict[str, object]) -> None:
    resources = page.resources

    def work() -> Prediction:
        return first_forecast(resources.ledger, resources.motors, resources.settings, Flight().with_changes(**values))

    page.show_notice("Working out the first forecast ...")
    page.change(work, partial(_forecast_made, page))


def _forecast_made(page: PageScreen, made: Prediction) -> None:
    low, middle, high = (
        measure(cards.APOGEE, float(x), page.resources.settings.units) for x in made.apogee_quantiles()
    )
    page.show_change(f"{made.plan.rocket} on {made.plan.motor}: {middle} ({low} to {high}). Each flight narrows it")
