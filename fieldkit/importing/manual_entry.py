"""Entering a flight: the questions, how answers are parsed, and which are implausible.

Independent of the user interface, so that the prompts of `fieldkit add`, `fieldkit edit column=value` and a form on a
screen accept and reject the same input.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta

from fieldkit import units
from fieldkit.errors import BadValue, nearest
from fieldkit.flight import (
    BY_NAME,
    COLUMNS,
    LOGGED,
    MEASURED,
    READOUTS,
    TAGS,
    TEXT_COLUMNS,
    Column,
    Flight,
    read_date,
    read_tags,
)
from fieldkit.flight.further import JUDGED_COLUMNS, TIMERS
from fieldkit.flight.judged import condition_of_eggs, read_eggs, read_timer
from fieldkit.flight.limits import check
from fieldkit.flight.plausibility import doubted
from fieldkit.flight.readout import beside
from fieldkit.flight.storable import NAMES, check_name
from fieldkit.importing.tables.flight_dates import date_of
from fieldkit.importing.tables.flight_headings import plain
from fieldkit.messages import TextWithAmounts, marked, message
from fieldkit.motors.names import in_capitals

MONTH_FIRST = "month/day"
"""The `unit` of a date in which `5/1/2026` is May 1st."""
NOT_RECORDED = "-"
"""Typed for "not recorded" when an empty answer would accept the default."""


@dataclass(frozen=True, slots=True)
class Question:
    """One question about a flight; `offered` means that the default is the last flight's answer.

    `read_as` is the column whose units its answer has, if it is not a column itself.
    """

    name: str
    title: str
    help: str
    offered: bool = False
    read_as: str = ""

    @property
    def column(self) -> Column | None:
        """The column of a number; None for text."""
        return BY_NAME.get(self.read_as or self.name)


def _asked(name: str, *, offered: bool = False) -> Question:
    column = BY_NAME[name]
    return Question(name, column.title, column.help, offered)


QUESTIONS = (
    Question("rocket", "Rocket", "Name of the rocket.", offered=True),
    Question("config", "Configuration", "Name of this build, such as A or ballast.", offered=True),
    Question("motor", "Motor", "As printed, such as F24-4W; ?F24 searches.", offered=True),
    *(_asked(column.name) for column in READOUTS),
    Question("tags", "Tags", f"Separated by ;, your own or one of these: {', '.join(TAGS)}."),
    _asked("dry_mass", offered=True),
    _asked("diameter", offered=True),
    Question("site", "Site", "Name of the launch site.", offered=True),
    _asked("wind", offered=True),
    _asked("temperature", offered=True),
    Question("notes", "Notes", "Free text."),
)
"""The questions about a flight, with readouts in the order in which the altimeter displays them."""

LIFT_OFF_MASS = Question(
    "lift_off_mass",
    "Lift-off mass",
    "Weighed ready to fly with this motor: replaces the dry mass.",
    read_as="dry_mass",
)
"""Another way to give the dry mass."""
JUDGED_QUESTIONS = (
    Question("timer_1_s", "Timer 1", "Contest: what the first watch showed, such as 38.42."),
    Question("timer_2_s", "Timer 2", "Contest: what the second watch showed; the mean of both counts."),
    Question("eggs", "Eggs", "Contest: intact, or cracked, with which the flight has no score; 2 intact counts them."),
)
"""The questions about a contest flight; their answers are further columns."""


def field_of(name: str) -> tuple[str, str]:
    """The field of `Flight` and the unit that a column name stands for: `apogee_ft` gives `apogee` and `ft`.

    Raises BadValue with suggestions of similar names.
    """
    plain = name.strip().lower().replace("-", "_")
    if plain in TEXT_COLUMNS:
        return plain, ""
    for column in (*COLUMNS, *LOGGED):
        ending = plain.removeprefix(column.name)
        if ending == "" or (ending.startswith("_") and units.named(column.quantity, ending[1:])):
            return column.name, ending[1:]
    known = [*TEXT_COLUMNS, *(column.header for column in COLUMNS)]
    known += [header for column in MEASURED for header in (column.sd_header, column.source_header)]
    near = nearest(plain, known, least=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else "`fieldkit flights --json` shows their names"
    raise BadValue(f"no column {name!r}; {hint}")


def read_answer(name: str, text: str, unit: str = "") -> object:
    """Parse the typed value of a field; an empty text, or `-` for a number, means "not recorded". Raises BadValue. [SI]

    A number without a unit is in `unit`, or in the column's own; of a date such as 5/1/2026 the `unit` is the order.
    """
    text = text.strip()
    if name in BY_NAME:
        return _number(BY_NAME[name], text, unit)
    if name == "tags":
        return tuple(check_name(tag) for tag in read_tags(text))
    if name in NAMES:
        return check_name(text)
    if name in JUDGED_COLUMNS:
        return _judged(name, "" if text == NOT_RECORDED else text)
    if name == "motor":
        return in_capitals(text)
    if name != "date_time":
        return text
    return date_of(text, False if unit == MONTH_FIRST else None) or read_date(_day_in_words(text))


def date_order(system: str) -> str:
    """The `unit` of dates for a flyer with these units: with US units the month comes first."""
    return MONTH_FIRST if system == "US" else ""


def read_lift_off_mass(text: str, unit: str = "") -> float | None:
    """A typed lift-off mass; without a unit it is in `unit`, or in grams. None for an empty text or `-`. Raises
    BadValue. [kg]"""
    text = "" if text.strip() == NOT_RECORDED else text.strip()
    return units.parse(text, "mass", unit or "g") if text else None


def _day_in_words(text: str) -> str:
    """The time for `today`, `yesterday`, `10:30` or `yesterday 10:30`; any other text unchanged."""
    now, found = datetime.now(), _DAY_AND_TIME.fullmatch(text.casefold())
    if found is None or not text:
        return text
    day, clock = f"{now.date() - timedelta(days=found[1] == 'yesterday')}", found[2]
    if clock:
        return f"{day}T{clock:0>5}"
    return day if found[1] == "yesterday" else now.isoformat(timespec="minutes")


_DAY_AND_TIME = re.compile(r"(today|yesterday)?(?:(?:^|\s+)((?:[01]?\d|2[0-3]):[0-5]\d))?")


def read_changes(flight: Flight, changes: Mapping[str, str], order: str = "") -> dict[str, object]:
    """Fields and values of `column=value` changes to a flight, with dates in an `order`, as `date_order` gives it.
    Standard deviations and sources of readouts and extra columns may be changed as well.

    Raises BadValue that names the column.
    """
    values: dict[str, object] = {}
    extra = dict(flight.extra)
    details: dict[str, dict[str, object]] = {}
    for name, text in changes.items():
        try:
            if name in extra or name in JUDGED_COLUMNS:
                extra = with_cells(extra, {name: _judged(name, text)})
                continue
            if place := beside(name.strip().lower().replace("-", "_")):
                details.setdefault(place.part, {})[place.readout] = place.read(
                    "" if text.strip() == NOT_RECORDED else text
                )
                continue
            field, unit = field_of(name)
            values[field] = read_answer(field, text, unit or (order if field == "date_time" else ""))
        except BadValue as error:
            label = {"date_time": "date", "flight_id": "id"}.get(name, name)
            label = label.replace("_", " ") if name in BY_NAME else label
            if str(error).startswith("no column"):
                raise
            raise BadValue(message(f"{label}: {marked(error)}")) from error
    changed = flight.with_changes(**values)
    for part, new in details.items():
        both = {**getattr(changed, part), **new}
        values[part] = {name: value for name, value in both.items() if value is not None}
    return values | ({"extra": extra} if extra != dict(flight.extra) else {})


def with_cells(extra: Mapping[str, str], changed: Mapping[str, str]) -> dict[str, str]:
    """The further columns of a flight with some of them changed; an empty text removes its column."""
    return {name: text for name, text in {**extra, **changed}.items() if text or name not in changed}


def _judged(name: str, text: str) -> str:
    """A further column as typed: seconds without their unit, eggs with their condition, another one unchanged. Raises
    BadValue."""
    if plain(name) in TIMERS:
        time = read_timer(text)
        return "" if time is None else f"{time:.10g}"
    return condition_of_eggs(text) if plain(name) == "eggs" else text


def check_judged(header: str, text: str) -> None:
    """Raise BadValue for a cell of a table with a watch or eggs that cannot be read; a count of eggs alone can be, but
    gives no score."""
    if plain(header) in TIMERS:
        read_timer(text)
    if plain(header) == "eggs":
        read_eggs(text)


def answer_text(flight: Flight, name: str) -> str:
    """A field of a flight as text to edit; empty if not recorded. A number has the unit of its column."""
    if name in JUDGED_COLUMNS:
        return flight.text(name)
    value = getattr(flight, name)
    if value is None:
        return ""
    if name in BY_NAME:
        column = BY_NAME[name]
        return f"{units.unit(column.quantity, column.unit).from_si(value):.6g} {column.unit}"
    if isinstance(value, datetime):
        return value.isoformat(" ", "minutes")
    return "; ".join(value) if isinstance(value, tuple) else str(value)


def implausible_answers(flight: Flight, name: str, usual: Mapping[str, float] | None = None) -> list[TextWithAmounts]:
    """Warnings about one implausible answer, one phrase each.

    The answer is checked by itself, against the other answers, and against the `usual` readouts, which are
    `plausibility.middles`.
    """
    return [phrase for phrase, concerned in doubted(flight, usual or {}) if name in concerned]


def _number(column: Column, text: str, unit: str) -> float | None:
    if text in ("", NOT_RECORDED):
        return None
    typed = units.typed_unit(text, unit or column.unit)
    try:
        return check(column, column.parse(text, unit or None), typed)
    except BadValue as error:
        raise BadValue(message(f"{marked(error)}, such as {_example(column, typed, unit)}")) from error


def _example(column: Column, typed: str, usual: str) -> str:
    """An example of a valid answer, a round number in the unit that was typed if that is known, or else in the usual
    one of the form: `300m`."""
    unit = typed if units.named(column.quantity, typed) else usual or column.unit
    scale = units.unit(column.quantity, unit)
    middle = (column.low * column.high) ** 0.5 if column.low > 0 else (column.low + column.high) / 2
    return f"{float(f'{scale.from_si(middle):.1g}'):g}{unit}"
