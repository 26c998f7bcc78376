"""The form of a contest day on the Decide screen: announcements, declarations, and the size of the site."""

from dataclasses import replace
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.flight.site import Site
from fieldkit.importing.manual_entry import Question, read_lift_off_mass
from fieldkit.motors import Motor
from fieldkit.planning.contest_day import Day, read_part
from fieldkit.quantities import in_system, measure, unit_of
from fieldkit.services.manual_entry import dry_mass_under
from fieldkit.tui.setup import site_form
from fieldkit.tui.widgets import cards

DAY = (
    Question("target", "Announced target", "The apogee announced that day, such as 785ft. Empty: the season's own."),
    Question("window", "Announced window", "Seconds announced that day, such as 37-40. Empty: the season's own."),
    Question("cut", "Cut", "Points that qualify, such as 60: the contest view shows the chance. Empty: none."),
    Question("declared", "Declared flights", "The flights whose best are summed, by their ids: 4,5,6."),
    Question("length", "Rocket length", "From nose to fins: for the season's limit."),
)
"""Questions about a contest day."""

WEIGHED_QUESTION = Question(
    "lift_off_mass", "Lift-off mass", "On the scale with this motor: sets the dry mass of the plan. Empty: as planned."
)


def questions(site: Site) -> tuple[Question, ...]:
    """The questions about the day; about the site only if it has a name to save it under."""
    return (*DAY, *(site_form.ROOM if site.name else ()), WEIGHED_QUESTION)


def read(motor: Motor, system: str, name: str, text: str, unit: str) -> object:
    """The value of an answer; for a lift-off mass, the dry mass under a motor [kg]. Raises BadValue, with masses in the
    units of a system."""
    if name != WEIGHED_QUESTION.name:
        return read_part(name, text, unit)
    mass = read_lift_off_mass(text, unit)
    try:
        return None if mass is None else dry_mass_under(mass, motor)
    except BadValue as error:
        raise BadValue(in_system(error, system)) from error


def texts(day: Day, site: Site, system: str) -> dict[str, str]:
    """Known values as text to edit."""
    return site_form.room(site, system) | {
        "target": measure(cards.APOGEE, day.target, system),
        "window": "-".join(f"{end:g}" for end in day.window or ()),
        "cut": "" if day.cut is None else f"{day.cut:g}",
        "declared": ",".join(day.declared),
        "length": measure(cards.DIAMETER, day.length, system),
    }


def units(system: str) -> dict[str, str]:
    """The units of numbers typed without one."""
    own = {
        "target": unit_of(cards.APOGEE, system),
        "length": unit_of(cards.DIAMETER, system),
        WEIGHED_QUESTION.name: unit_of(cards.DRY_MASS, system),
    }
    return site_form.units(system) | own


def answered(values: dict[str, Any], day: Day, site: Site, system: str) -> tuple[Day, Site]:
    """The day and the site from the answers of the form; an answer with the same text was not changed."""
    shown, unit = texts(day, site, system), units(system)
    asked = [question.name for question in questions(site) if question != WEIGHED_QUESTION]
    new = {name: values[name] for name in asked if values[name] != read_part(name, shown[name], unit.get(name, ""))}
    room = site_form.room_names()
    return (
        replace(day, **{name: value for name, value in new.items() if name not in room}),
        replace(site, **{name: value for name, value in new.items() if name in room}),
    )
