"""The lists of the Setup page as headings, rows and cells, and the answers of their forms."""

from collections.abc import Callable, Hashable, Sequence
from typing import Any, NamedTuple

from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.makers import motor_name
from fieldkit.importing.manual_entry import Question, answer_text, read_answer
from fieldkit.motors import Motor
from fieldkit.motors.motor import delays_text
from fieldkit.paths import motor_folder, settings_file
from fieldkit.planning.kits import Kit
from fieldkit.quantities import SYSTEMS, measure, unit_of, written
from fieldkit.services.flyer_card import card_texts
from fieldkit.settings import BoxedMotors, Settings
from fieldkit.tui.setup.kit_form import kit_text
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.groups import Group, LaunchSite, LedgerNames
from fieldkit.tui.widgets.table import Cells, Head

RAIL = ("rail_length", "rail_angle")
"""Settings of the usual rail."""
MOTOR_CELLS = 14
"""Width of a motor. [cell]"""
NORMAL_TABLE_WIDTH, WIDE_TABLE_WIDTH = 70, 96
"""Minimum widths of a table with more columns. [cell]"""


class ListContents(NamedTuple):
    """A list for a table: its columns, its rows, their cells, and the name by which a row is found again."""

    heads: list[Head]
    keys: Sequence[Any]
    cells: Cells
    name: Callable[[Any], Hashable] = lambda key: key

    def matching(self, text: str) -> "ListContents":
        """The rows that have all words of a text."""
        words = text.casefold().split()
        if not words:
            return self  # without the cells of every row
        rows = ((key, " ".join(self.cells(key)).casefold()) for key in self.keys)
        return self._replace(keys=[key for key, row in rows if all(word in row for word in words)])


def motors_listed(found: Sequence[Motor], system: str, width: int) -> ListContents:
    """The motors that a search found, their masses in the unit of a system."""
    wide = width >= WIDE_TABLE_WIDTH
    heads = [Head("motor", 0), Head("mm", 3, True), Head("N s", 7, True), Head("avg N", 6, True)]
    heads += [Head("burn s", 6, True), Head(SYSTEMS[system].get("g", "grams"), 7, True)] if wide else []
    heads += [Head("delays s", 22 if wide else 12), Head("", 14 if wide else 5)]

    def cells(motor: Motor) -> list[str]:
        gone = "" if motor.available else "no longer made" if wide else "gone"
        figures = (
            [
                f"{motor.rated_burn:.2f}",
                written(motor.loaded_mass, "g", system, 1 if system == "SI" else None).split()[0],
            ]
            if wide
            else []
        )
        first = [f"{motor.maker} {motor.designation}", f"{motor.diameter * 1e3:.0f}", f"{motor.total_impulse:.1f}"]
        return [*first, f"{motor.rated_thrust:.1f}", *figures, delays_text(motor.delays), gone]

    return ListContents(heads, found, cells)


def builds_listed(names: LedgerNames, system: str, width: int) -> ListContents:
    """The configurations of the flights' rockets; on a narrow screen, their last motors are only in the card."""
    narrow = width < NORMAL_TABLE_WIDTH

    def cells(group: Group) -> list[str]:
        numbers = [measure(BY_NAME[name], group.last.number(name), system) for name in ("dry_mass", "diameter")]
        return [*group.names, *numbers, str(len(group.ids)), motor_name(group.last.motor, MOTOR_CELLS)][
            : 5 if narrow else 6
        ]

    heads = [Head("rocket", 0), Head("config", 8), Head("dry mass", 9, True), Head("diameter", 9, True)]
    heads += [Head("flights", 7, True), Head("last motor", MOTOR_CELLS)][: 1 if narrow else 2]
    return ListContents(heads, names.builds, cells, lambda group: group.names)


def sites_listed(names: LedgerNames, system: str, width: int) -> ListContents:
    """The sites of flights and saved sites, with their properties for safety checks."""
    narrow = width < NORMAL_TABLE_WIDTH

    def cells(place: LaunchSite) -> list[str]:
        site = place.site
        numbers = [measure(cards.APOGEE, height, system) for height in (site.elevation, site.size, site.ceiling)]
        return [site.name, *numbers, str(len(place.ids)), answer_text(place.last, "date_time")[:10]][
            : 5 if narrow else 6
        ]

    heads = [Head("site", 0), Head("elevation", 9, True), Head("size", 9, True), Head("ceiling", 9, True)]
    heads += [Head("flights", 7, True), Head("last", 10)][: 1 if narrow else 2]
    return ListContents(heads, names.sites, cells, lambda place: place.site.name)


def kits_listed(kits: Sequence[Kit], system: str) -> ListContents:
    """The flyer's kits."""

    def cells(kit: Kit) -> list[str]:
        return [kit.name, *(kit_text(kit, name, system) for name in ("dry_mass", "diameter", "mount"))]

    heads = [Head("kit", 0), Head("dry mass", 9, True), Head("diameter", 9, True), Head("mount", 9, True)]
    return ListContents(heads, kits, cells, lambda kit: kit.name)


def settings_listed(settings: Settings, ledger: str, box: tuple[BoxedMotors, ...]) -> ListContents:
    """The settings, with what is left in the range box, and the paths of files."""

    target = measure(BY_NAME["apogee"], settings.target, settings.units) or "none"
    ends = [measure(BY_NAME[name], getattr(settings, name), settings.units) for name in RAIL]
    rows = {
        "units": settings.units,
        "theme": settings.theme,
        "target": target,
        "rail": ", ".join(end for end in ends if end) or "none",
        "card": ", ".join(f"{name} {text}" for name, text in card_texts(settings, settings.units, box).items() if text)
        or "empty",
        "ledger": ledger,
        "your motors": str(motor_folder()),
        "settings": str(settings_file()),
    }
    return ListContents([Head("setting", 11), Head("value", 0)], list(rows), lambda name: (name, rows[name]))


MEANS = {
    "units": "SI: meters and grams. US: feet and ounces. mixed: feet and grams. Enter switches to the next; so does N "
    "on any page.",
    "theme": "field: for any room. sun: black on white. night: red on black. terminal: your terminal's own colors. "
    "Enter switches to the next; so does T on any page.",
    "target": "The target apogee for comparing motors on the Fly page, where you can also set it with g.",
    "rail": "Length and angle of your usual rail or rod, for plans without one.",
    "card": "Certification, birth, rules, rods and rails, and the motors in your range box: what plans start from.",
    "ledger": "The file with your flights. To open another, use fieldkit --ledger FILE or set FIELDKIT_LEDGER.",
    "your motors": "The folder of your own .eng and .rse files; press i in the Motors list to add one.",
    "settings": "The file with these settings.",
}
"""The meaning of each setting and how to change it."""


def answer_of(flight: Flight, question: Question, system: str) -> str:
    """A flight's answer to a question in the format of a form."""
    if question.column is None:
        return answer_text(flight, question.name)
    return measure(question.column, flight.number(question.name), system)


def same(name: str, value: object, text: str, system: str) -> bool:
    """Whether a form's value is unchanged, that is, the value of the text that the form showed."""
    unit = unit_of(BY_NAME[name], system) if name in BY_NAME else ""
    return read_answer(name, text, unit) == value
