"""The lists of the page Setup as headings, rows and cells, and the answers of their forms."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from fieldkit.entry import Question, answer_text
from fieldkit.flight import BY_NAME, Flight
from fieldkit.measures import measure
from fieldkit.safe_text import printable
from fieldkit.settings import Settings
from fieldkit.tui import cards
from fieldkit.tui.groups import Group, Kept, Place
from fieldkit.tui.table import Cells, Head

if TYPE_CHECKING:
    from fieldkit.motors import Motor

RAIL = ("rail_length", "rail_angle")
"""Settings of the usual rail."""


class Listed(NamedTuple):
    """A list as a table shows it: its columns, what its rows stand for, and their cells."""

    heads: list[Head]
    keys: Sequence[Any]
    cells: Cells


def motors_listed(found: "Sequence[Motor]", wide: bool) -> Listed:
    """The motors that a search found."""
    from fieldkit.motors.motor import delays_text

    heads = [Head("motor", 0), Head("mm", 3, True), Head("N s", 6, True), Head("avg N", 5, True)]
    heads += [Head("burn s", 6, True), Head("grams", 6, True)] if wide else []
    heads += [Head("delays", 18 if wide else 12), Head("", 14 if wide else 5)]

    def cells(motor: "Motor") -> list[str]:
        gone = "" if motor.available else "no longer made" if wide else "gone"
        figures = [f"{motor.burn_time:.3g}", f"{motor.loaded_mass * 1e3:.4g}"] if wide else []
        first = [f"{motor.maker} {motor.designation}", f"{motor.diameter * 1e3:g}", f"{motor.total_impulse:.4g}"]
        return [*first, f"{motor.average_thrust:.3g}", *figures, delays_text(motor.delays), gone]

    return Listed(heads, found, cells)


def builds_listed(kept: Kept, system: str) -> Listed:
    """The builds of the rockets that flights name."""

    def cells(group: Group) -> list[str]:
        numbers = [measure(BY_NAME[name], group.last.number(name), system) for name in ("dry_mass", "diameter")]
        return [*group.names, *numbers, str(len(group.ids)), group.last.motor]

    heads = [Head("rocket", 0), Head("config", 10), Head("dry mass", 9, True), Head("diameter", 9, True)]
    return Listed([*heads, Head("flights", 7, True), Head("last motor", 14)], kept.builds, cells)


def sites_listed(kept: Kept, system: str) -> Listed:
    """The sites that flights name or that were saved, with what safety lines ask of them."""

    def cells(place: Place) -> list[str]:
        site = place.site
        numbers = [measure(cards.APOGEE, height, system) for height in (site.elevation, site.size, site.ceiling)]
        return [site.name, *numbers, str(len(place.ids)), answer_text(place.last, "date_time")[:10]]

    heads = [Head("site", 0), Head("elevation", 9, True), Head("size", 9, True), Head("ceiling", 9, True)]
    return Listed([*heads, Head("flights", 7, True), Head("last", 10)], kept.sites, cells)


def settings_listed(settings: Settings, ledger: str, wide: bool) -> Listed:
    """What was chosen, and where things are kept."""
    from fieldkit.places import motor_folder, settings_file

    target = measure(BY_NAME["apogee"], settings.target, settings.units) or "none"
    ends = [measure(BY_NAME[name], getattr(settings, name), settings.units) for name in RAIL]
    rows = {
        "units": (settings.units, "SI, US, or mixed: feet and grams"),
        "theme": (settings.theme, "field, sun, night or terminal"),
        "target": (target, "what motors are compared against"),
        "rail": (", ".join(end for end in ends if end) or "none", "yours, for plans that name none"),
        "ledger": (ledger, "where flights are kept: --ledger, FIELDKIT_LEDGER"),
        "own motors": (str(motor_folder()), "your .eng and .rse files"),
        "settings": (str(settings_file()), "where these choices are kept"),
    }
    heads = [Head("setting", 10), Head("is", 0)] + ([Head("means", 52)] if wide else [])
    return Listed(heads, list(rows), lambda name: (name, *rows[name][: 2 if wide else 1]))


def on_record(motor: "Motor") -> tuple[tuple[str, str], ...]:
    """What is known of a motor, name and value."""
    from fieldkit.motors import describe

    facts = [(name.replace("_", " "), _said(value)) for name, value in describe(motor).items()]
    return tuple((name, printable(value)) for name, value in facts if value)


def answer_of(flight: Flight, question: Question, system: str) -> str:
    """A flight's answer to a question as a form shows it."""
    if question.column is None:
        return answer_text(flight, question.name)
    return measure(question.column, flight.number(question.name), system)


def same(flight: Flight, name: str, value: object, text: str, system: str) -> bool:
    """Whether a form's value is what it was: a number that reads the same was not changed."""
    column = BY_NAME.get(name)
    if column is None:
        return bool(getattr(flight, name) == value)
    return measure(column, value if isinstance(value, float) else None, system) == text


def _said(value: object) -> str:
    """A fact as text; long lists are left to the command."""
    if isinstance(value, list | tuple):
        return ", ".join(map(str, value)) if len(value) <= 12 else f"{len(value)} entries"
    return "" if value is None else str(value)
