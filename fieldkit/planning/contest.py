"""Contest points: seasons are files in `fieldkit/data/seasons`, which score flights and plans.

Source: the rules of each season, as its file names them with their reliability.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from pathlib import Path

import numpy as np

from fieldkit import files
from fieldkit.errors import BadValue
from fieldkit.file_lock import changing
from fieldkit.flight import Flight
from fieldkit.flight.short_name import short_name
from fieldkit.paths import data_file
from fieldkit.planning.contest_flight import judged_duration, whole_feet, why_no_score
from fieldkit.planning.rules import MARKS
from fieldkit.planning.toml_values import in_order, number, problem_in, whole
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

FOLDER = Path(__file__).parents[1] / "data" / "seasons"
FIRST_MONTH = 6
"""The month of the year before in which a season starts. [1]"""
MOST_DECLARED = 100
"""Largest number of flights that may be declared. [1]"""
_BY_HAND = ("eggs", "body", "launch", "motors", "altimeter")
"""Rules of a season that the program cannot check."""
_TEXTS = (*_BY_HAND, "finals", "mark", "source")
"""Keys of a season that are text."""


@dataclass(frozen=True, slots=True)
class Season:
    """The rules of one season, in SI; `per_metre` and `per_second` are points, the `best` of `declared` flights count.

    `mass` and `impulse` are upper limits on the pad, `length` a lower limit; None if the season sets none. `eggs`,
    `body`, `launch`, `motors`, `altimeter` and `finals` are its other rules, `finals_range` the targets that
    finals may have, except `finals_never` [m]. `mark` is the reliability of its text, `marks` that of less reliable
    limits, by name.
    """

    year: int
    target: float
    window: tuple[float, float]
    per_metre: float
    per_second: float
    best: int
    declared: int
    checked: bool
    remarks: str
    mass: float | None = None
    impulse: float | None = None
    length: float | None = None
    eggs: str = ""
    body: str = ""
    launch: str = ""
    motors: str = ""
    altimeter: str = ""
    finals: str = ""
    finals_range: tuple[float, float] | None = None
    finals_never: float | None = None
    mark: str = "U"
    source: str = ""
    marks: Mapping[str, str] = field(default_factory=dict)

    def points(self, apogee: Float[Array, "*draw"], duration: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
        """Points of flights; fewer are better, and an unknown duration (nan) adds none. [1]"""
        late = np.maximum(np.maximum(self.window[0] - duration, duration - self.window[1]), 0.0)
        return np.asarray(self.per_metre * np.abs(apogee - self.target) + self.per_second * np.nan_to_num(late))

    def sums(self, points: Float[Array, "draw declared"]) -> Float[Array, "draw"]:
        """The score: the sum over the best of the declared flights. [1]"""
        return np.asarray(np.sort(points, axis=1)[:, : self.best].sum(axis=1))

    def announced(self, target: float | None, window: tuple[float, float] | None) -> "Season":
        """The same rules with the target [m] and window [s] of the day, if announced."""
        return replace(self, target=target or self.target, window=window or self.window)

    @property
    def caveat(self) -> str:
        """A warning about an unverified rule; empty for a verified one."""
        if self.checked:
            return ""
        how = MARKS.get(self.mark, "unverified")
        return (
            f"The rule of {self.year} ({self.remarks}) has this source: {self.source or 'none named'} ({how}). Check "
            "it against the season's rules before you rely on it."
        )

    @property
    def egg_count(self) -> int | None:
        """The number of eggs that a flight carries, which the text about them starts with; None if it does not. [1]"""
        number = self.eggs.partition(" ")[0]
        return int(number) if number.isdecimal() else None

    @property
    def by_hand(self) -> list[tuple[str, str]]:
        """Its rules that the program cannot check, each with its name."""
        return [(name, text) for name in _BY_HAND if (text := getattr(self, name))]


def seasons(own: Path | None = None) -> list[int]:
    """The years with a file, shipped or in the user's own folder."""
    folders = (FOLDER, own) if own is not None else (FOLDER,)
    return sorted({int(file.stem) for folder in folders for file in folder.glob("*.toml") if file.stem.isdecimal()})


def season_of(day: date, own: Path | None = None) -> int:
    """The season of a day, or the nearest one that has a file: finals are in May, and by June the next season has its
    list of motors."""
    year = day.year + (day.month >= FIRST_MONTH)
    return min(seasons(own), key=lambda one: (abs(one - year), -one))


def copy_season(year: int, own: Path) -> Path:
    """The file of a year in the user's own folder; it is copied there if missing, to be checked and changed.

    Raises BadValue for a year without a file, FieldkitError for a folder that cannot be written.
    """
    file = own / f"{year}.toml"
    if not file.exists():
        season(year)
        with changing(file):
            if not file.exists():  # another program may have made it in the meantime
                files.replace(file, (FOLDER / file.name).read_bytes())
    return file


def rule_of(year: int) -> Season:
    """The rules of a year, the flyer's if there is a file of them. Raises BadValue as `season`."""
    return season(year, data_file("seasons"))


def season(year: int, own: Path | None = None) -> Season:
    """The rules of a year, from the user's own folder of seasons if it has a file.

    Raises BadValue that lists the available years, or the missing entries of a file.
    """
    file = FOLDER / f"{year}.toml"
    if own is not None and (own / f"{year}.toml").exists():
        file = own / f"{year}.toml"
    if not file.exists():
        raise BadValue(f"no season {year}, expected one of: {', '.join(map(str, seasons(own)))}")
    try:
        rule = files.read_toml(file)
        window, most = in_order(rule["window_s"], "window_s"), rule.get("limits", {})
        declared = whole(rule["declared"], "declared", 1, MOST_DECLARED)
        return Season(
            year=whole(rule["season"], "season", 1, 9999),
            target=number(rule["target_ft"], "target_ft", least=1.0) * FOOT,
            window=window,
            per_metre=number(rule["points_per_ft"], "points_per_ft") / FOOT,
            per_second=number(rule["points_per_s"], "points_per_s"),
            best=whole(rule["best"], "best", 1, declared),
            declared=declared,
            checked=bool(rule["checked"]),
            mass=_limit(most, "lift_off_mass_g", 1e-3),
            impulse=_limit(most, "impulse_ns", 1.0),
            length=_limit(most, "length_mm_at_least", 1e-3),
            finals_range=_finals(rule.get("finals_ft")),
            finals_never=_limit(rule, "finals_never_ft", FOOT),
            marks={str(name): str(mark) for name, mark in rule.get("marks", {}).items()},
            remarks=printable(str(rule.get("remarks", ""))),
            **{key: printable(str(rule[key])) for key in _TEXTS if key in rule},
        )
    except (KeyError, ValueError, TypeError, AttributeError, OSError) as error:
        found = problem_in(error)
        raise BadValue(f"{file.name}: found {found}, expected every key of a season with a valid value") from error


def _finals(feet: object) -> tuple[float, float] | None:
    """The lowest and the highest target in finals. [m]"""
    if feet is None:
        return None
    low, high = in_order(feet, "finals_ft")
    return low * FOOT, high * FOOT


def _limit(limits: Mapping[str, object], name: str, scale: float) -> float | None:
    """A limit of a season in SI, None if it sets none."""
    value = limits.get(name)
    return None if value is None else number(value, name) * scale


Scored = tuple[Flight, float | None]
"""A flight and its points; None without a score."""


def score(rule: Season, flights: Sequence[Flight]) -> list[Scored]:
    """Flights with an apogee and their points, in the given order.

    The altitude counts in whole feet, the duration as timed by two timers. Raises BadValue for a timer that is not a
    number.
    """
    return [(flight, _points(rule, flight)) for flight in flights if flight.apogee is not None]


def _points(rule: Season, flight: Flight) -> float | None:
    if why_no_score(flight, rule.egg_count) or flight.apogee is None:
        return None
    duration = judged_duration(flight)
    height = np.array(whole_feet(flight.apogee) * FOOT)
    return float(rule.points(height, np.array(np.nan if duration is None else duration)))


def declared_score(rule: Season, scored: Sequence[Scored], names: Sequence[str]) -> float:
    """The sum over the best of the declared flights, given by their ids. [1]

    A flight without a score counts as an attempt but never as one of the best. Raises BadValue for an invalid
    declaration.
    """
    points = {flight.flight_id: own for flight, own in scored}
    if unknown := [name for name in names if name not in points]:
        raise BadValue(f"declared flights: found {unknown[0]!r}, expected flights of this rocket that have an apogee")
    if not rule.best <= len(set(names)) <= rule.declared:
        wanted = f"{rule.best} to {rule.declared} flights"
        raise BadValue(f"declared flights: found {len(set(names))}, expected {wanted} such as 4,5,6")
    known = [own for name in dict.fromkeys(names) if (own := points[name]) is not None]
    if len(known) < rule.best:
        without = [
            f"{short_name(flight)} ({why_no_score(flight, rule.egg_count)})" for flight, own in scored if own is None
        ]
        reason = f"{', '.join(without)} have no score"
        raise BadValue(f"declared flights: found {len(known)} with a score, expected {rule.best}; {reason}")
    return float(rule.sums(np.array([known]))[0])
