"""Mapping of table columns to channels: entered once by the flyer, then remembered.

A choice is written `altitude=Alt (ft)`: a channel of `Series`, or for a table of flights a field of `Flight`
(`apogee=Height reached [ft]`) or `liftoff_mass`, and a column as its header spells it. A unit that the header lacks
follows in brackets, `altitude=Alt [ft]`; a table without headers has the columns `#1`, `#2`. Choices are stored by the
headers of the table they were made for, in a JSON file in the user's data folder.
"""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from fieldkit.errors import BadValue, FieldkitError, unknown
from fieldkit.file_lock import changing
from fieldkit.files import read_own, replace
from fieldkit.flight import BY_NAME, TEXT_COLUMNS
from fieldkit.importing.reading import EXCLUDE, ColumnChoice, is_exclusion
from fieldkit.importing.tables.headings import QUANTITIES
from fieldkit.paths import data_file

MAX_MAPPINGS = 500
"""Number of remembered choices; the oldest are dropped. [1]"""


LIFTOFF_MASS, MOTOR_MASS = "liftoff_mass", "motor_mass"
"""Columns that a table of flights may have instead of the dry mass, which is the first minus the second."""
FLIGHT_COLUMNS = (*TEXT_COLUMNS, *BY_NAME, LIFTOFF_MASS, MOTOR_MASS)
"""Fields that the columns of a table of flights may map to."""


def read_choice(texts: Iterable[str]) -> ColumnChoice:
    """Parse `--map` texts into a choice. Raises BadValue with the correct syntax."""
    channels: dict[str, str] = {}
    for text in texts:
        name, mark, column = (part.strip() for part in text.partition("="))
        if not (mark and column):
            raise BadValue(f"--map: found {text!r}, expected a channel and a column such as 'altitude=Alt (ft)'")
        if is_exclusion(name):
            count = sum(map(is_exclusion, channels)) + 1
            channels[EXCLUDE if count == 1 else f"{EXCLUDE} {count}"] = column
            continue
        if name not in QUANTITIES and name not in FLIGHT_COLUMNS:
            raise BadValue(
                f"--map: found the channel {name!r}, expected one of {', '.join(QUANTITIES)} for samples, "
                f"{EXCLUDE} for a column that is not to be used, "
                f"or one of {', '.join(FLIGHT_COLUMNS)} for flights"
            )
        if name in channels:
            raise BadValue(f"--map: found {name} twice, expected it once")
        channels[name] = column
    named = {name for name in channels if not is_exclusion(name)}
    if not (named <= QUANTITIES.keys() or (named <= set(FLIGHT_COLUMNS) and len(named) == len(channels))):
        raise BadValue("--map: found both sample channels and flight columns, expected one or the other")
    return ColumnChoice(channels)


def is_of_flights(choice: ColumnChoice) -> bool:
    """Whether a choice names columns of a table of flights; if ambiguous, it is of samples."""
    return not {name for name in choice.channels if not is_exclusion(name)} <= QUANTITIES.keys()


def choice_for(headers: Sequence[str], choices: Iterable[ColumnChoice]) -> ColumnChoice | None:
    """The first choice made for this table or for any table, or None."""
    return next((choice for choice in choices if choice.headers in ((), tuple(headers))), None)


def mapping_file() -> Path:
    """Path of the file with the choices, which may not exist yet."""
    return data_file("mappings.json")


def remembered() -> tuple[ColumnChoice, ...]:
    """The choices made so far, latest first. Raises FieldkitError if their file is invalid."""
    file = mapping_file()
    try:
        entries = json.loads(read_own(file))["mappings"]
        return tuple(ColumnChoice(_texts(entry["map"]), tuple(map(str, entry["headers"]))) for entry in entries)
    except FileNotFoundError:
        return ()
    except (OSError, ValueError, RecursionError, KeyError, TypeError, AttributeError) as error:
        raise FieldkitError(f"{file}: cannot be read as saved mappings; repair or delete it") from error


def _texts(mapping: object) -> dict[str, str]:
    known = QUANTITIES.keys() | {*FLIGHT_COLUMNS}
    if not isinstance(mapping, dict) or not all(name in known or is_exclusion(name) for name in mapping):
        raise ValueError(mapping)
    return {str(channel): str(column) for channel, column in mapping.items()}


def remember(choice: ColumnChoice) -> None:
    """Store a choice for tables with its headers, replacing an earlier one.

    Raises FieldkitError if it cannot be written.
    """
    if choice.headers:
        with changing(mapping_file()):
            _keep([choice, *(old for old in remembered() if old.headers != choice.headers)])


def forget(number: int) -> ColumnChoice:
    """Delete and return a remembered choice by its number, counted from 1 in the order of `remembered`.

    Raises BadValue if there is no such number, FieldkitError if the file cannot be written.
    """
    with changing(mapping_file()):
        kept = _with_number(number)
        gone = kept.pop(number - 1)
        _keep(kept)
    return gone


def edit(number: int, texts: Iterable[str]) -> ColumnChoice:
    """Replace the columns of a remembered choice, for the same headers. Raises BadValue, FieldkitError."""
    with changing(mapping_file()):
        kept = _with_number(number)
        kept[number - 1] = ColumnChoice(read_choice(texts).channels, kept[number - 1].headers)
        _keep(kept)
    return kept[number - 1]


def _with_number(number: int) -> list[ColumnChoice]:
    """The remembered choices, of which one has this number. Raises BadValue if there is no such number."""
    kept = list(remembered())
    if not 1 <= number <= len(kept):
        raise BadValue(unknown("mapping", str(number), map(str, range(1, len(kept) + 1))))
    return kept


def _keep(choices: Sequence[ColumnChoice]) -> None:
    """Replace the stored choices atomically: a power failure leaves either the old or the new file."""
    kept = choices[:MAX_MAPPINGS]
    document = {"mappings": [{"headers": list(one.headers), "map": dict(one.channels)} for one in kept]}
    replace(mapping_file(), json.dumps(document, indent=1).encode())
