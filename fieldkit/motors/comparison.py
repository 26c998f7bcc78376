"""Compare the catalog with a table of tests: certification letters, stated values, curves.

The table has one row per test, with the columns `manufacturer`, `designation`, `common_name`, `delays`, `source` and
those of `FIGURES`. Its `note` may start with `basis=letter`, `basis=stated` or `basis=curve`, best first; curves whose
note contains `file class cert` come before others. Of each value, the tests with the best basis count. A mass that a
note calls doubtful is not compared. Neither is the propellant mass of a curve of Cesaroni, or of AeroTech's Redline:
such files state the mass lost, with liner, delay and charge.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fieldkit.errors import AmbiguousMotor, BadValue, UnknownMotor
from fieldkit.motors.catalogue import Catalogue
from fieldkit.motors.motor import PLUGGED_DELAY, Motor, delays_text
from fieldkit.motors.names import maker_of

FIGURES: Mapping[str, tuple[str, str]] = {
    "tested_impulse_ns": ("total_impulse_ns", "N s"),
    "tested_average_n": ("average_n", "N"),
    "tested_peak_n": ("peak_n", "N"),
    "tested_burn_s": ("burn_s", "s"),
    "propellant_g": ("propellant_g", "g"),
    "loaded_g": ("loaded_g", "g"),
}
"""Columns of a table of tests: the corresponding field of a correction, and its unit."""
BASES = ("letter", "stated", "curve", "curve")
"""What the values of a row are based on, best first; the last is a curve that is no certification."""
_CERTIFICATION = "file class cert"
_DOUBTFUL_MASS = "mass of the file doubtful"
MASSES = {"propellant_g": "propellant", "loaded_g": "loaded"}
"""Columns of masses, and the words for them in a note that calls one doubtful."""
DIFFERENCE = 0.05
"""Smallest relative difference that is reported: the measured scatter of a motor type. [1]"""
NAMES = ("manufacturer", "designation", "common_name")


@dataclass(frozen=True, slots=True)
class Difference:
    """A value of a motor that differs between the catalog and a test, in the unit of the field."""

    motor: Motor
    field: str
    unit: str
    listed: float
    tested: float
    basis: str
    source: str

    @property
    def ratio(self) -> float:
        """Relative difference of the tested value from the listed one. [1]"""
        return self.tested / self.listed - 1

    def json(self) -> dict[str, object]:
        """Ready for JSON."""
        return {
            "maker": self.motor.maker,
            "motor": self.motor.designation,
            "field": self.field,
            "unit": self.unit,
            "catalogue": self.listed,
            "tested": self.tested,
            "off": self.ratio,
            "basis": self.basis,
            "source": self.source,
        }


@dataclass(frozen=True, slots=True)
class DelayDifference:
    """Delays that a test document of a motor lists, at least one of which the catalog lacks. [s]"""

    motor: Motor
    tested: tuple[float, ...]
    basis: str
    source: str

    def json(self) -> dict[str, object]:
        """Ready for JSON."""
        return {
            "maker": self.motor.maker,
            "motor": self.motor.designation,
            "catalogue": delays_text(self.motor.delays),
            "tested": delays_text(self.tested),
            "basis": self.basis,
            "source": self.source,
        }


@dataclass(frozen=True, slots=True)
class CatalogueComparison:
    """Result for a table of tests: rows, motors found, unknown names, and values and delays that differ."""

    rows: int
    motors: int
    unknown: tuple[str, ...]
    differences: tuple[Difference, ...]
    delays: tuple[DelayDifference, ...]


def compare_tests(catalogue: Catalogue, content: bytes, name: str) -> CatalogueComparison:
    """Catalog values that differ from a table of tests by more than `DIFFERENCE`, largest difference first.

    If a motor has several tests, the mean of those with the best basis counts. Raises BadValue that names the row and
    the column.
    """
    table = csv.DictReader(content.decode("utf-8-sig", "replace").splitlines())
    try:
        lines = list(table)
    except csv.Error as error:
        raise BadValue(f"{name}, row {table.line_num + 1}: found {error}, expected a table of tests") from error
    if not set(NAMES[:2]) <= set(table.fieldnames or ()):
        raise BadValue(f"{name}: found the columns {table.fieldnames}, expected manufacturer, designation and figures")
    tests: dict[Motor, list[_Test]] = {}
    unknown = []
    for number, row in enumerate(lines, start=2):
        motor = _motor(catalogue, row)
        if motor is None:
            unknown.append(" ".join(row.get(key) or "" for key in NAMES[:2]).strip())
        else:
            tests.setdefault(motor, []).append(_test(motor, row, f"{name}, row {number}", name))
    found = [one for of_motor in tests.values() for one in _differences(of_motor)]
    found.sort(key=lambda one: -abs(one.ratio))
    delays = tuple(one for of_motor in tests.values() if (one := _delay_difference(of_motor)))
    return CatalogueComparison(len(lines), len(tests), tuple(dict.fromkeys(unknown)), tuple(found), delays)


@dataclass(frozen=True, slots=True)
class _Test:
    """A row: its motor, the place of its basis in `BASES`, its values by column, delays [s], and source."""

    motor: Motor
    basis: int
    figures: Mapping[str, float]
    delays: tuple[float, ...]
    source: str


def _test(motor: Motor, row: Mapping[str, str | None], where: str, table: str) -> _Test:
    note = row.get("note") or ""
    basis = _basis(note)
    doubtful = {column for column, word in MASSES.items() if f"{word} {_DOUBTFUL_MASS}" in note}
    if basis >= BASES.index("curve") and _states_mass_lost(motor):
        doubtful.add("propellant_g")
    values = {column: _number(row.get(column), f"{where}, {column}") for column in FIGURES}
    figures = {column: value for column, value in values.items() if value is not None and column not in doubtful}
    return _Test(motor, basis, figures, _delays(row.get("delays") or ""), row.get("source") or table)


def _states_mass_lost(motor: Motor) -> bool:
    """Whether curve files of this motor state the mass lost to burnout instead of the propellant."""
    return motor.maker == "Cesaroni" or (motor.maker == "AeroTech" and motor.propellant == "Redline")


_ONE_DELAY = re.compile(r"(\d+)A?|P")


def _delays(text: str) -> tuple[float, ...]:
    """Delays as a table has them: `4,7,10`, `P`, `14A`; empty if one is not understood. [s]"""
    found = [_ONE_DELAY.fullmatch(part.strip()) for part in text.split(",")]
    seconds = [float(one[1]) if one[1] else PLUGGED_DELAY for one in found if one]
    return tuple(sorted(seconds)) if len(seconds) == len(found) else ()


def listed_figures(motor: Motor) -> dict[str, float]:
    """The values of a motor by the columns of a table of tests, in the units of the columns."""
    return {
        "tested_impulse_ns": motor.total_impulse,
        "tested_average_n": motor.rated_thrust,
        "tested_peak_n": motor.certified_peak or motor.peak_thrust,
        "tested_burn_s": motor.burn_time,
        "propellant_g": motor.propellant_mass * 1e3,
        "loaded_g": motor.loaded_mass * 1e3,
    }


def _differences(tests: Sequence[_Test]) -> list[Difference]:
    """The values of one motor that differ: of each column, the mean of the tests with the best basis."""
    motor, found = tests[0].motor, []
    listed = listed_figures(motor)
    for column, (field, unit) in FIGURES.items():
        having = [one for one in tests if column in one.figures]
        best = [one for one in having if one.basis == min(each.basis for each in having)]
        if not best or listed[column] <= 0:
            continue
        tested = sum(one.figures[column] for one in best) / len(best)
        if abs(tested / listed[column] - 1) > DIFFERENCE:
            found.append(Difference(motor, field, unit, listed[column], tested, _named(best[0]), best[0].source))
    return found


def _delay_difference(tests: Sequence[_Test]) -> DelayDifference | None:
    """The delays of one motor by its best document that states any, if the catalog lacks one of them.

    A document that has only the longest delay says nothing about those drilled from it.
    """
    stated = [one for one in tests if one.delays]
    if not stated:
        return None
    best = min(stated, key=lambda one: one.basis)
    motor = best.motor
    if set(best.delays) <= set(motor.delays):
        return None
    return DelayDifference(motor, best.delays, _named(best), best.source)


def _named(test: _Test) -> str:
    return BASES[test.basis] if test.basis < len(BASES) else ""


_SOLD_DELAYS = re.compile(r"-\d+(?:,\d+)+([A-Z]*)$")
"""The delays for sale at the end of a designation: `B6W-4,6`, `D22-4,7,10W`."""


def _motor(catalogue: Catalogue, row: Mapping[str, str | None]) -> Motor | None:
    """The motor that a row names, by designation or else common name, if exactly one matches its maker."""
    designation = row.get("designation") or ""
    for name in (designation, _SOLD_DELAYS.sub(r"\1", designation), row.get("common_name")):
        for maker in (row.get("manufacturer") or "").split("/"):
            try:
                found = catalogue.find(name, maker_of(maker)) if name else None
            except (UnknownMotor, AmbiguousMotor):
                continue
            if found is not None and found.motor.maker == maker_of(maker):
                return found.motor
    return None


def _basis(note: str) -> int:
    """The place in `BASES` of what a note says a row is based on, beyond its end if it does not."""
    start = note.strip().removeprefix("basis=")
    place = next((place for place, basis in enumerate(BASES) if start.startswith(basis)), len(BASES))
    return place + (place == BASES.index("curve") and _CERTIFICATION not in note)


def _number(text: str | None, where: str) -> float | None:
    if not (text or "").strip():
        return None
    try:
        value = float(text or "")
    except ValueError:
        value = float("nan")
    if not 0 < value < 1e6:
        raise BadValue(f"{where}: found {(text or '')[:20]!r}, expected a number above zero")
    return value
