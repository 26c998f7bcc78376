"""A flyer's settings: units, colors, the target height. A small JSON file in the user's folder."""

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from datetime import date
from pathlib import Path
from typing import Any

from fieldkit import files
from fieldkit.errors import FieldkitError
from fieldkit.file_lock import changing
from fieldkit.paths import settings_file

UNITS = ("SI", "US", "mixed")
"""Names of the systems of units; see `fieldkit.quantities`."""
THEMES = ("field", "sun", "night", "terminal")
"""Names of the color schemes of the app."""
CERTIFICATIONS = (0, 1, 2, 3)
"""Levels of certification; 0 is none."""
BIRTH = r"(19|20)\d\d(-(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01]))?"
"""The pattern of a year or a date of birth."""
MOST_IN_BOX = 1000
"""Largest number of one motor in a range box. [1]"""


@dataclass(frozen=True, slots=True)
class BoxedMotors:
    """Motors in the flyer's range box: a name as printed, how many, their lot, and the local time when they were
    counted (ISO), empty if it is not known."""

    motor: str
    count: int
    lot: str = ""
    counted: str = ""


@dataclass(frozen=True, slots=True)
class FlyerCard:
    """The flyer's card: certification level (0 for none) and year or date of birth (ISO), None if not given; the
    lengths of the rods and rails owned [m], and the motors in the range box."""

    certification: int | None = None
    born: str | None = None
    rails: tuple[float, ...] = ()
    box: tuple[BoxedMotors, ...] = ()

    def age(self, day: date | None = None) -> int | None:
        """The age on a day, by default today; the least possible one if only the year of birth is known. [years]"""
        if self.born is None:
            return None
        year, month, of_month = (*map(int, self.born.split("-")), 12, 31)[:3]
        on = day or date.today()
        return on.year - year - ((on.month, on.day) < (month, of_month))

    def with_motors(self, counted: BoxedMotors) -> "FlyerCard":
        """The card with this many of a motor and lot in the box; none of them for a count of 0."""
        key = counted.motor.casefold(), counted.lot
        others = [one for one in self.box if (one.motor.casefold(), one.lot) != key]
        return replace(self, box=(*others, *([counted] if counted.count else [])))


@dataclass(frozen=True, slots=True)
class Settings:
    """The settings.

    `target` is the apogee that motors are compared with, or None. [m] `rail_length` [m] and `rail_angle` [rad] are the
    defaults for plans that do not state them, `rules` the authorities of sites without their own. `flyer` is the
    flyer's card.
    """

    units: str = UNITS[0]
    theme: str = THEMES[0]
    target: float | None = None
    rail_length: float | None = None
    rail_angle: float | None = None
    rules: str = ""
    flyer: FlyerCard = FlyerCard()


def read_settings(file: Path | None = None) -> Settings:
    """The saved settings; unreadable or unknown ones have their defaults."""
    try:
        saved = json.loads(files.read_own(file or settings_file()))
    except (OSError, ValueError, RecursionError):
        return Settings()
    saved = saved if isinstance(saved, dict) else {}
    return Settings(
        units=saved["units"] if saved.get("units") in UNITS else UNITS[0],
        theme=saved["theme"] if saved.get("theme") in THEMES else THEMES[0],
        target=_number(saved.get("target"), 1e6),
        rail_length=_number(saved.get("rail_length"), 100.0),
        rail_angle=_number(saved.get("rail_angle"), 1.5),
        rules=str(saved.get("rules") or ""),
        flyer=_flyer(saved.get("flyer")),
    )


def _flyer(saved: object) -> FlyerCard:
    """A flyer's card; values that cannot be read count as not given."""
    card = saved if isinstance(saved, dict) else {}
    level, born = card.get("certification"), str(card.get("born") or "")
    lengths = [one for text in _list(card.get("rails")) if (one := _number(text, 100.0))]
    box = [_boxed(one) for one in _list(card.get("box")) if isinstance(one, dict)]
    return FlyerCard(
        level if isinstance(level, int) and level in CERTIFICATIONS else None,
        born if re.fullmatch(BIRTH, born) else None,
        tuple(lengths),
        tuple([one for one in box if one.motor and one.count > 0]),
    )


def _list(saved: object) -> list[Any]:
    return saved if isinstance(saved, list) else []


def _boxed(saved: Mapping[str, Any]) -> BoxedMotors:
    count = saved.get("count")
    named, lot, counted = (str(saved.get(key) or "") for key in ("motor", "lot", "counted"))
    return BoxedMotors(named, count if isinstance(count, int) else 0, lot, counted)


def _number(saved: object, most: float) -> float | None:
    """A positive number below a bound, or else None."""
    return float(saved) if isinstance(saved, int | float) and 0 < saved < most else None


def change_settings(changes: Mapping[str, Any], file: Path | None = None) -> Settings:
    """Save changed settings, keep the others as they are in the file now, and return all: two programs open at once do
    not overwrite each other's settings. Raises FieldkitError if the file cannot be written, or if it is a link to
    something else than settings."""
    file = file or settings_file()
    try:
        with changing(file):
            _check_link(file)
            settings = replace(read_settings(file), **changes)
            files.replace(file, (json.dumps(asdict(settings), indent=2) + "\n").encode())
    except FieldkitError as error:
        raise FieldkitError(f"{error}; the setting applies until you quit") from error
    return settings


def _check_link(file: Path) -> None:
    """Raise FieldkitError for a link to a file with other content than settings, which would be lost."""
    if not (file.is_symlink() and file.is_file()):
        return
    try:
        text = files.read_own(file)
        saved = json.loads(text) if text.strip() else {}
    except (OSError, ValueError, RecursionError):
        saved = None
    if not isinstance(saved, dict) or not saved.keys() <= {field.name for field in fields(Settings)}:
        raise FieldkitError(f"{file}: found a link to a file that is not fieldkit's settings, expected no link")
