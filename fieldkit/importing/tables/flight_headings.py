"""Interpret the headers of a table of flights: fieldkit's own column names, those of others, and numbers.

A table without headers has the columns `#1`, `#2`, and is recognized by their contents: a date, a text or a number.
"""

import re
import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from importlib.resources import files

from fieldkit import units
from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME, TEXT_COLUMNS
from fieldkit.flight.further import JUDGED_COLUMNS
from fieldkit.flight.readout import ReadoutColumn, beside
from fieldkit.importing.reading import ColumnChoice
from fieldkit.importing.tables.text import first_names, no_column, shown
from fieldkit.safe_text import printable

OWN_COLUMNS = ("flight_id", "rocket", "config", "motor", "date_time")
"""Columns of which one is enough to recognize a flight table; a readout with its unit is enough as well."""
NO_UNITS = ("note", "notes", "source", "dir", "direction", "gust", "gusts", "type", "sd", "error", "raw", "mach")
"""Endings of a header that look like a unit but are not: `wind_direction` is a column of its own, and a Mach number is
a speed only at a known temperature."""
_NUMBER = re.compile(r"[+-]?\d+([.,]\d+)?\s*[A-Za-z°/²]{0,6}")
_EXAMPLE = re.compile(r"\((?:e\. ?g\.?|eg|for example|such as|optional|if known)\b[^()]*\)")
"""What a form says in brackets about an answer: `Motor (e.g. C6-5)`."""
_LETTER = re.compile(r"[^\W\d_]")
_DATE = re.compile(r"\d{4}-\d\d?-\d\d?([T ].*)?|\d\d?[./]\d\d?[./]\d{2,4}.*")


@dataclass(frozen=True, slots=True)
class ColumnRole:
    """The content of one column: a field of `Flight`, a value `beside` a readout (its sd or source), or neither.

    `kept_as` is the name under which the ledger has a column of how a contest flight was judged, else empty. `unit` is
    empty if the cells include theirs; `loose` if the name may mean something else as well; `repeats` is the
    earlier column with the same meaning, if any. `day_first` is the order of its dates, or None if unknown.
    """

    spelled: str
    field: str = ""
    unit: str = ""
    beside: ReadoutColumn | None = None
    loose: bool = False
    repeats: str = ""
    day_first: bool | None = None
    kept_as: str = ""

    @property
    def key(self) -> str:
        """Identifier of the meaning of a column."""
        if self.beside:
            return f"{self.beside.readout} {self.beside.part}"
        return self.field or self.kept_as or self.spelled.lower()


def shape(cells: Sequence[str]) -> tuple[str, ...]:
    """Column types of a table without headers, given the cells of its first row; empty if those are headers."""
    kinds = [
        "date" if _DATE.fullmatch(cell) else "number" if _NUMBER.fullmatch(cell) else "text"
        for cell in map(str.strip, cells)
    ]
    if not {"date", "number"} & set(kinds):
        return ()
    return tuple(f"#{number} {kind}" for number, kind in enumerate(kinds, start=1))


def table_names(head: bytes) -> tuple[str, ...]:
    """Column names of a table of flights, and what identifies a table without headers. Raises DamagedLog."""
    names = first_names(head)
    return shape(names) or names


def renamed(names: Sequence[str], choice: ColumnChoice, row: int) -> list[str]:
    """Column names, with fieldkit's own names and units for the chosen columns.

    Raises DamagedLog for a missing column.
    """
    renamed = list(names)
    for name, text in choice.channels.items():
        bare = re.fullmatch(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]", text)
        ways = [(text, ""), *([(bare[1], bare[2])] if bare else [])]
        found = ((place, unit) for wanted, unit in ways for place in _places(names, wanted))
        place, unit = next(found, (-1, ""))
        if place < 0:
            raise DamagedLog(no_column(text, names), row=row)
        if renamed[place] != names[place]:
            raise DamagedLog(f"found the column {shown(names[place])} for two meanings, expected one", row=row)
        unit = unit or stated_unit(names[place])
        renamed[place] = f"{name}_{unit}" if unit else name
    return renamed


def _places(names: Sequence[str], wanted: str) -> list[int]:
    """Indices of the columns with a name, or with a number such as `#3`."""
    if re.fullmatch(r"#\d{1,3}", wanted) and 1 <= int(wanted[1:]) <= len(names):
        return [int(wanted[1:]) - 1]
    same = [place for place, name in enumerate(names) if plain(name) == plain(wanted)]
    without_unit = (plain(name).removesuffix(f"_{stated_unit(name)}") for name in names)
    return same or [place for place, name in enumerate(without_unit) if name == plain(wanted)]


def stated_unit(name: str) -> str:
    """The unit at the end of a header, or ""."""
    ending = plain(name).rpartition("_")[2]
    return ending if "_" in plain(name) and units.is_unit(ending) else ""


def plain(spelled: str) -> str:
    """A header in lower case, with one underscore for spaces and brackets: `Apogee (ft)` becomes `apogee_ft`."""
    return re.sub(r"[\s()\[\]_?]+", "_", _EXAMPLE.sub("", spelled.strip().lower())).strip("_")


def usual_name(words: str) -> str:
    """A `plain` header with abbreviations spelled out, and without words that do not change its meaning.

    `actual_alt_agl_ft` becomes `altitude_ft`.
    """
    known = _known_names()
    parts = [part.strip(".,") for part in re.split(r"[_\-:#]+", words)]
    kept = [known["words"].get(part, part) for part in parts if part and part not in known["ignored"]]
    return "_".join(kept) or words


@cache
def _usual_names(part: str) -> Mapping[str, str]:
    """Other names of columns, also with their abbreviations spelled out."""
    names = _known_names()[part]
    return {**{usual_name(other): name for other, name in names.items()}, **names}


@cache
def _known_names() -> Mapping[str, Mapping[str, str]]:
    """Other names of columns and fieldkit's own: valid anywhere, valid in a table with motors, and names of masses;
    other words of a name, and words without a meaning of their own."""
    known = tomllib.loads(files("fieldkit").joinpath("data/flight_columns.toml").read_text(encoding="utf-8"))
    return {part: {other: name for name, others in names.items() for other in others} for part, names in known.items()}


def synonyms() -> Mapping[str, str]:
    """Other names of columns, and fieldkit's own."""
    return _usual_names("anywhere")


def judged_name(spelled: str) -> str:
    """fieldkit's own name of a column of how a contest flight was judged, such as `timer_1_s`; empty for another."""
    words = plain(spelled)
    bare = words.removesuffix(f"_{stated_unit(spelled)}")
    names = {**_usual_names("judged"), **{name: name for name in JUDGED_COLUMNS}}
    return next((names[one] for one in (words, bare, usual_name(bare)) if one in names), "")


@cache
def mass_names(name: str) -> frozenset[str]:
    """Names of a mass that is not a field of a flight: the lift-off mass, or the motor mass."""
    return frozenset({name, *(other for other, own in _usual_names("masses").items() if own == name)})


def beside_a_motor(names: Sequence[str]) -> list[str]:
    """Column names, with fieldkit's own for those that are unambiguous in a table that names motors.

    `Altitude (ft)` is the height of a sample in a log and the apogee in a list of launches. Only such a list has a
    motor in every row.
    """
    if "motor" not in {role_of(name, strict=False).field for name in names}:
        return list(names)
    taken = {role_of(name, strict=False, taken=()).field for name in names}
    renamed = []
    for name in names:
        role, own = next(_roles_beside_a_motor(plain(name), taken), (None, name))
        taken |= {role.field} if role else set()
        renamed.append(own)
    return renamed


def _roles_beside_a_motor(words: str, taken: Collection[str]) -> Iterator[tuple[ColumnRole, str]]:
    """What a column may be in a table that names motors, with fieldkit's own name for it."""
    for spelled in dict.fromkeys((words, usual_name(words))):
        for other, own in _usual_names("beside_a_motor").items():
            if spelled == other or spelled.startswith(f"{other}_"):
                name = own + spelled.removeprefix(other)
                role = role_of(name, strict=False)
                if role.field and role.field not in taken and own.startswith(role.field):
                    yield role, name


def _ours(words: str, taken: Collection[str]) -> str:
    """A header with fieldkit's own name, followed by its unit: `wind_speed_mps` becomes `wind_mps`.

    An own name is never read as a shorter other one: `coast_to_apogee_s` does not begin with the other name `coast`.
    Of several names for one column the longest counts: `engine_used` is not `engine` with the unit `used`.
    """
    own = max((len(name) for name in _beginnings(words) if name in BY_NAME), default=0)
    for spelled in dict.fromkeys((words, usual_name(words))):
        names = _ranked(own_too=spelled != words)
        known = [other for other in _beginnings(spelled) if other in names and len(other) >= own]
        longest = {names[other][1]: other for other in sorted(known, key=len)}
        for name, other in sorted(longest.items(), key=lambda item: names[item[1]]):
            if name not in taken:
                return name + spelled.removeprefix(other)
    return words


def _beginnings(words: str) -> list[str]:
    """The names that a header may be: all of it, or its first words, up to the length of the longest name."""
    return [words[: mark.start()] for mark in re.finditer("_", words[: _longest() + 1])] + [words]


@cache
def _longest() -> int:
    """Length of the longest name of a column."""
    return max(map(len, [*synonyms(), *BY_NAME, *TEXT_COLUMNS]))


@cache
def _ranked(*, own_too: bool) -> Mapping[str, tuple[int, str]]:
    """Synonyms, and fieldkit's own names if they are asked for too: the place in the list, the first counts, and the
    own name."""
    names = {**synonyms(), **({name: name for name in (*BY_NAME, *TEXT_COLUMNS)} if own_too else {})}
    return {other: (place, name) for place, (other, name) in enumerate(names.items())}


def role_of(spelled: str, *, strict: bool, taken: Collection[str] = ()) -> ColumnRole:
    """Interpret a header; another name of a field counts only if none of those `taken` is the field's own name.

    Raises BadValue for a known column with an unknown unit if `strict`. Otherwise, or if the ending is several words or
    one of `NO_UNITS`, the column counts as unknown.
    """
    if not _LETTER.search(spelled):
        return ColumnRole(spelled.strip())  # at once, because the first line of a log may be thousands of numbers
    words = _ours(plain(spelled), taken)
    if words in TEXT_COLUMNS or words in BY_NAME:
        return ColumnRole(spelled.strip(), words)
    if column_beside := _beside(words, strict=strict):
        return ColumnRole(spelled.strip(), unit=column_beside.unit, beside=column_beside)
    if name := max((one for one in _beginnings(words) if one in BY_NAME), key=len, default=""):
        column, ending = BY_NAME[name], words.removeprefix(f"{name}_")
        if ending and units.named(column.quantity, ending):
            return ColumnRole(spelled.strip(), name, ending)
        if strict and "_" not in ending and ending not in NO_UNITS:
            units.unit(column.quantity, ending)
    return ColumnRole(spelled.strip())


def _beside(words: str, *, strict: bool) -> ReadoutColumn | None:
    """The sd or source of a readout that a column contains. Raises BadValue for an impossible unit, if `strict`."""
    try:
        return beside(words)
    except BadValue:
        if strict:
            raise
        return None


def headings_of(spelled: Sequence[str], row: int) -> list[ColumnRole]:
    """Interpret all columns. Raises DamagedLog if none is known, for a known one with an unknown unit, or for a
    repeated one of an sd or source."""
    own = {role_of(name, strict=False, taken=synonyms().values()).field for name in spelled}
    certain = {role_of(name, strict=False, taken=own).field for name in spelled}
    if not certain - {""}:
        raise DamagedLog(
            f"found no column of the flight table, expected at least one of {', '.join(OWN_COLUMNS)}", row=row or 1
        )
    headings: list[ColumnRole] = []
    seen: dict[str, str] = {"": ""}
    for name in spelled:
        try:
            spoken_for = any(plain(name).startswith(f"{field}_") for field in certain & set(BY_NAME))
            role = role_of(name, strict=not spoken_for or "_sd_" in plain(name), taken=own)
        except BadValue as error:
            raise DamagedLog(f"{error}, or another name", row=row, column=printable(name.strip())) from error
        if role.key and role.key in seen:
            if role.beside:
                found = f"found a second column that means the same as {printable(seen[role.key])}, expected one"
                raise DamagedLog(found, row=row, column=printable(role.spelled))
            role = replace(role, repeats=seen[role.key])
        seen.setdefault(role.key, role.spelled)
        headings.append(role)
    return headings


def mass_column(headings: Sequence[ColumnRole], name: str) -> str:
    """The column of a mass that is not a field of a flight, or ""."""
    return next((heading.spelled for heading in headings if is_mass(heading, mass_names(name))), "")


@lru_cache(maxsize=1024)  # asked about every cell of a table
def is_mass(heading: ColumnRole, words: frozenset[str]) -> bool:
    """Whether a column that is not a field of a flight is a mass with one of these names, with its unit."""
    name, _, unit = plain(heading.spelled).rpartition("_")
    return not heading.field and bool({name, usual_name(name)} & words) and bool(units.named("mass", unit))
