"""Rule sets: dated files in `fieldkit/data/rules`, one for each club code or national law, and in the user's folder.

Each value has the wording of its rule, its source, and the reliability of the text: official, a transcription by
others, or unverified. The applicable sets depend on the launch's authorities, on motor and mass, and on the day.
"""

import datetime
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from math import inf
from pathlib import Path
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.files import read_toml
from fieldkit.paths import data_file
from fieldkit.planning.toml_values import number, problem_in, texts, whole
from fieldkit.safe_text import printable
from fieldkit.units import DEGREE, FOOT, MILE, POUND

FOLDER = Path(__file__).parents[1] / "data" / "rules"
MARKS: Mapping[str, str] = {"O": "official text", "T": "transcription by others", "U": "unverified"}
"""Reliability of the text of a rule, by its mark."""
DEFAULT_AUTHORITIES = ("NAR", "FAA")
"""Default authorities of a launch."""
DEFINITION_KEYS = (
    "impulse_of_several_ns",
    "impulse_of_one_ns",
    "average_thrust_n",
    "propellant_g",
    "mass_g",
    "kinds",
    "designations",
)
"""Keys that a definition of high power must have."""
CLASS_KEYS = ("class1_propellant_g", "class1_mass_g", "class2_impulse_ns")
"""Keys that the classes of an air law must have."""
LISTS = ("kinds", "designations", "sparky")
"""Keys of a definition of high power whose values are lists."""
_MOTORS_OVER = {
    "impulse": ("impulse_over_ns", 1.0),
    "average": ("average_over_n", 1.0),
    "propellant": ("propellant_over_g", 1e-3),
}
"""Keys of a rule for motors that exceed a figure, and their factor to SI."""
KINDS = ("model", "high power", "any")
"""The kinds of rockets that a set is for."""


@dataclass(frozen=True, slots=True)
class RuleText:
    """The basis of a value: the rule's own words or a summary, the source, its mark, and its effective date."""

    words: str
    source: str
    mark: str
    valid_from: datetime.date

    @property
    def unverified(self) -> bool:
        """Whether it must not be presented as a rule."""
        return self.mark == "U"

    def origin(self) -> str:
        """Source, mark and date in a line."""
        return f"{self.source}; {MARKS[self.mark]}, valid from {self.valid_from.isoformat()}"


@dataclass(frozen=True, slots=True)
class RuleRow:
    """A row of a table: its upper bound, the value, the value for a complex rocket, and the cleared diameter. [SI]

    `stated` is the row as printed, in its own unit; empty for a value outside a table.
    """

    up_to: float
    value: float
    complex: float | None
    cleared: float | None
    text: RuleText
    stated: str = ""


@dataclass(frozen=True, slots=True)
class Rule:
    """A requirement of one set: rows of values by installed impulse [N s] or altitude [m], or a single value.

    `propellants` are those of the motors it applies to, empty for all. `most` is whether values are upper or lower
    limits; `of_altitude` is the lower limit as a fraction of the expected altitude [1]. A rule without rows is only
    text. `only` are bounds on its applicability. `pad_inside` is whether the edges of a field must be as far from the
    pad as people. `cleared_times` is the factor by which the cleared diameter of the distance table is larger [1].
    `motors_over` are the figures of which a motor must exceed one for the rule to apply, empty for any motor: impulse
    [N s], average thrust [N], propellant [kg].
    """

    check: str
    most: bool
    by: str
    rows: tuple[RuleRow, ...]
    of_altitude: float
    classes: tuple[int, ...]
    only: Mapping[str, float]
    text: RuleText
    of: str
    propellants: tuple[str, ...] = ()
    pad_inside: bool = False
    cleared_times: float = 1.0
    motors_over: Mapping[str, float] = field(default_factory=dict)

    def row(self, impulse: float, altitude: float) -> RuleRow | None:
        """The row for an installed impulse [N s] and an expected altitude [m]; None beyond the table."""
        reached = altitude if self.by == "altitude" else impulse
        return next((row for row in self.rows if not self.by or reached <= row.up_to + 1e-9), None)

    def verified_below(self, row: RuleRow) -> RuleRow | None:
        """The last verified row below an unverified one: its value is needed in any case. None for a verified row."""
        below = self.rows[: self.rows.index(row)] if row.text.unverified else ()
        return next((one for one in reversed(below) if not one.text.unverified), None)

    def least(self, impulse: float, altitude: float, *, complex_rocket: bool = False) -> float | None:
        """The required value, None beyond the table. [SI]"""
        row = self.row(impulse, altitude)
        if row is None:
            return None
        value = row.complex if complex_rocket and row.complex is not None else row.value
        return max(value, self.of_altitude * altitude)


@dataclass(frozen=True, slots=True)
class RuleSet:
    """A code: its authority, the rockets it is for, its effective date, its rules, and its definition of high power."""

    key: str
    title: str
    authority: str
    country: str
    kind: str
    valid_from: datetime.date
    rules: tuple[Rule, ...]
    text: RuleText
    definition: Mapping[str, Any] = field(default_factory=dict)
    classes: Mapping[str, Any] = field(default_factory=dict)


def rule_sets(own: Path | None = None) -> list[RuleSet]:
    """Every shipped set, and those in the user's own folder, which replace shipped ones with the same file name.

    Raises BadValue that names the file and the error.
    """
    files = {
        file.name: file for folder in (FOLDER, own) if folder is not None for file in sorted(folder.glob("*.toml"))
    }
    return [_read(file, file.stat().st_mtime_ns) for file in files.values()]


def known_rules() -> list[RuleSet]:
    """The shipped rule sets and the user's own. Raises BadValue for a damaged file."""
    return rule_sets(data_file("rules"))


def governing(
    sets: Iterable[RuleSet], authorities: Sequence[str], high_power: bool, day: datetime.date
) -> list[RuleSet]:
    """The sets of some authorities that apply to a rocket on a day, in the order of the authorities.

    If a code has several versions, the newest one in effect counts; if the day is before all of them, the oldest.
    Raises BadValue for an authority without rule sets.
    """
    known = list(sets)
    chosen: list[RuleSet] = []
    for authority in authorities:
        ours = [one for one in known if one.authority.casefold() == authority.casefold()]
        if not ours:
            names = ", ".join(sorted({one.authority for one in known}))
            raise BadValue(f"rules: found {authority!r}, expected one of {names}")
        fitting = [one for one in ours if one.kind in ("any", "high power" if high_power else "model")]
        for title in dict.fromkeys(one.title for one in fitting):
            versions = sorted((one for one in fitting if one.title == title), key=lambda one: one.valid_from)
            chosen.append(next((one for one in reversed(versions) if one.valid_from <= day), versions[0]))
    return chosen


def read_authorities(text: str) -> tuple[str, ...]:
    """Parse the authorities of a launch, typed as `NAR, FAA`; the default if the text is empty."""
    return tuple(name.strip() for name in text.split(",") if name.strip()) or DEFAULT_AUTHORITIES


@cache
def _read(file: Path, changed: int) -> RuleSet:
    """A rule set from its file; cached until the modification time `changed` differs. [ns]"""
    try:
        table = read_toml(file)
    except (ValueError, OSError) as error:
        raise BadValue(f"{file.name}: found {problem_in(error)}, expected a set of rules in TOML") from error
    try:
        return _rule_set(file.stem, table)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        found = problem_in(error)
        raise BadValue(f"{file.name}: found {found}, expected title, authority, for, valid_from, [[rule]]") from error


def _rule_set(key: str, table: Mapping[str, Any]) -> RuleSet:
    kind = str(table["for"])
    if kind not in KINDS:
        raise ValueError(f"for = {kind!r}, one of {', '.join(KINDS)}")
    text = _text(table, RuleText("", str(table["source"]), str(table["mark"]), table["valid_from"]))
    return RuleSet(
        key=key,
        title=printable(str(table["title"])),
        authority=printable(str(table["authority"])),
        country=printable(str(table.get("country", ""))),
        kind=kind,
        valid_from=text.valid_from,
        rules=tuple(_rule(one, text, str(table["title"])) for one in table.get("rule", ())),
        text=text,
        definition=_bounds(table.get("definition", {}), DEFINITION_KEYS),
        classes=_bounds(table.get("classes", {}), CLASS_KEYS),
    )


def _bounds(table: Mapping[str, Any], needed: Sequence[str]) -> dict[str, Any]:
    """A table of bounds, which must have all the needed keys, or be empty. Raises KeyError, ValueError."""
    if table and (missing := [name for name in needed if name not in table]):
        raise KeyError(missing[0])
    numbers = {name: number(table[name], name) for name in needed if name in table and name not in LISTS}
    return dict(table) | numbers | {name: list(texts(table[name], name)) for name in LISTS if name in table}


def _text(table: Mapping[str, Any], above: RuleText) -> RuleText:
    """The rule text of a table, with missing entries taken from the table above it."""
    quote, says = (printable(str(table.get(name, ""))) for name in ("quote", "says"))
    words = f"“{quote}”" if quote else says or above.words
    day = table.get("valid_from", above.valid_from)
    if not isinstance(day, datetime.date) or str(table.get("mark", above.mark)) not in MARKS:
        raise ValueError("valid_from and mark: a day and one of O, T, U")
    return RuleText(words, printable(str(table.get("source", above.source))), str(table.get("mark", above.mark)), day)


def _stated(row: Mapping[str, Any], value: float, unit: str) -> str:
    """A row of a table by impulse, in words: `100 ft, 200 ft for complex rockets, up to 640 N s`."""
    complex_too = f", {row['complex']:,g} {unit} for complex rockets" if "complex" in row else ""
    return f"{value:,g} {unit}{complex_too}, up to {float(row['up_to']):,g} N s"


def _rule(table: Mapping[str, Any], above: RuleText, title: str) -> Rule:
    text, unit = _text(table, above), str(table.get("unit", "1"))
    if unit not in RULE_UNITS:
        raise ValueError(f"unit = {unit!r}, one of {', '.join(RULE_UNITS)}")
    scale = RULE_UNITS[unit]
    single = [{"up_to": inf, **table}] if {"at_most", "at_least"} & set(table) else []
    rows = []
    for row in table.get("rows", single):
        more = [number(row[name], name) * scale if name in row else None for name in ("complex", "cleared")]
        name = "at_most" if "at_most" in row else "at_least"
        value = number(row[name], f"{table['check']}, {name}")
        stated = _stated(row, value, unit) if table.get("by") == "impulse" and unit in ("ft", "m") else ""
        up_to = number(row["up_to"], "up_to", unlimited=True)
        rows.append(RuleRow(up_to, value * scale, more[0], more[1], _text(row, text), stated))
    only = {
        quantity: number(table.get(name, inf), name, unlimited=True) * unit
        for quantity, name, unit in (
            ("impulse", "impulse_ns", 1.0),
            ("mass", "mass_g", 1e-3),
            ("altitude", "altitude_ft", RULE_UNITS["ft"]),
        )
    }
    return Rule(
        check=printable(str(table["check"])),
        most="at_most" in table,
        by=str(table.get("by", "")),
        rows=tuple(sorted(rows, key=lambda row: row.up_to)),
        of_altitude=number(table.get("of_altitude", 0.0), "of_altitude"),
        classes=tuple(whole(one, "classes", 1, 3) for one in table.get("classes", ())),
        only=only,
        text=text,
        of=printable(title),
        propellants=texts(table.get("propellants", ()), "propellants"),
        pad_inside=bool(table.get("pad_inside", False)),
        cleared_times=number(table.get("cleared_times", 1.0), "cleared_times"),
        motors_over={
            name: number(table[key], key) * scale for name, (key, scale) in _MOTORS_OVER.items() if key in table
        },
    )


RULE_UNITS: Mapping[str, float] = {
    "1": 1.0,
    "level": 1.0,
    "m": 1.0,
    "ft": FOOT,
    "g": 1e-3,
    "lb": POUND,
    "deg": DEGREE,
    "m/s": 1.0,
    "mph": MILE / 3600,
    "N": 1.0,
    "N s": 1.0,
}
"""SI value of one of each unit."""
