"""A flyer's settings: units, colors, the target height. A small JSON file in the user's folder."""

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fieldkit.errors import FieldkitError
from fieldkit.file_lock import changing
from fieldkit.files import read_own, replace
from fieldkit.paths import settings_file

UNITS = ("SI", "US", "mixed")
"""Names of the systems of units; see `fieldkit.quantities`."""
THEMES = ("field", "sun", "night", "terminal")
"""Names of the color schemes of the app."""


@dataclass(frozen=True, slots=True)
class Settings:
    """The settings.

    `target` is the apogee that motors are compared with, or None. [m] `rail_length` [m] and `rail_angle` [rad] are the
    defaults for plans that do not state them.
    """

    units: str = UNITS[0]
    theme: str = THEMES[0]
    target: float | None = None
    rail_length: float | None = None
    rail_angle: float | None = None


def read_settings(file: Path | None = None) -> Settings:
    """The saved settings; unreadable or unknown ones have their defaults."""
    try:
        saved = json.loads(read_own(file or settings_file()))
    except (OSError, ValueError, RecursionError):
        return Settings()
    saved = saved if isinstance(saved, dict) else {}
    return Settings(
        units=saved["units"] if saved.get("units") in UNITS else UNITS[0],
        theme=saved["theme"] if saved.get("theme") in THEMES else THEMES[0],
        target=_number(saved.get("target"), 1e6),
        rail_length=_number(saved.get("rail_length"), 100.0),
        rail_angle=_number(saved.get("rail_angle"), 1.5),
    )


def _number(saved: object, most: float) -> float | None:
    """A positive number below a bound, or else None."""
    return float(saved) if isinstance(saved, int | float) and 0 < saved < most else None


def change_settings(changes: Mapping[str, Any], file: Path | None = None) -> Settings:
    """Save changed settings, keep the others as they are in the file now, and return all: two programs open at once do
    not overwrite each other's settings. Raises FieldkitError if the file cannot be written."""
    file = file or settings_file()
    try:
        with changing(file):
            settings = dataclasses.replace(read_settings(file), **changes)
            replace(file, (json.dumps(asdict(settings), indent=2) + "\n").encode())
    except FieldkitError as error:
        raise FieldkitError(f"{error}; the setting applies until you quit") from error
    return settings
