"""The flyer's card in the app: certification, age, rules, rods and rails, and the motors in the range box."""

from dataclasses import replace
from functools import partial

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.importing.manual_entry import Question
from fieldkit.quantities import ShownUnits
from fieldkit.services.flyer_card import card_texts, read_card
from fieldkit.services.range_box import box_left, recounted
from fieldkit.settings import BoxedMotors, FlyerCard
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen

QUESTIONS = (
    Question(
        "certification", "Certification", "Your level of high-power certification: none, 1, 2 or 3. Checks use it."
    ),
    Question("born", "Born", "Year or date of birth, 2009 or 2009-05-31: for motors that are sold only to adults."),
    Question("rules", "Rules", "Rules of sites without their own: NAR,FAA or UKRA. Empty: NAR, FAA."),
    Question("rails", "Rods and rails", "Lengths that you own: 3ft, 1.8m. Plans without a rail have the longest."),
    Question(
        "box",
        "Range box",
        "Motors that you have: 3 x C6-5, 2 x D12-5 lot 0412. A flight takes its motors out, undo puts them back. "
        "B on the Fly page lists only these.",
    ),
)


def ask_card(page: PageScreen) -> None:
    """Ask for the flyer's card with what is left in its range box, and save it."""
    resources = page.resources
    box = resources.settings.flyer.box
    page.ask(lambda: box_left(box, resources.ledger, resources.motors), partial(_ask, page), "range box")


def _ask(page: PageScreen, left: tuple[BoxedMotors, ...]) -> None:
    settings, motors = page.resources.settings, page.resources.motors
    texts = card_texts(settings, settings.units, left)

    def read(name: str, text: str, unit: str) -> object:
        value = read_card(name, text, unit)
        for one in value if name == "box" and isinstance(value, tuple) else ():
            try:
                motors.resolve(one.motor)
            except FieldkitError as error:
                raise BadValue(str(error)) from error
        return value

    def save(values: dict[str, object]) -> None:
        if all(read_card(name, texts[name], unit["rails"]) == one for name, one in values.items()):
            return
        known = dict(values)
        rules = known.pop("rules")
        known["box"] = recounted(known["box"], left, settings.flyer.box)  # type: ignore[arg-type]
        page.field_app.choose("Saved your card", flyer=replace(FlyerCard(), **known), rules=rules)  # type: ignore[arg-type]

    unit = {"rails": ShownUnits(settings.units).length_unit}
    page.ask_form(Form("Your card", QUESTIONS, texts, unit, read=read), save)
