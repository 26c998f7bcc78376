"""Compare the catalog with a table of tests: certification letters, stated values, curves.

The table has one row per test, with the columns `manufacturer`, `designation`, `common_name` and those of `FIGURES`;
its `note` may start with `basis=letter`, `basis=stated` or `basis=curve`, of which the best is used.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fieldkit.errors import AmbiguousMotor, BadValue, UnknownMotor
from fieldkit.motors.catalogue import Catalogue
from fieldkit.motors.motor import Motor
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
BASES = ("letter", "stated", "curve")
"""What the values of a row are based on, best first."""
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
class CatalogueComparison:
    """Result for a table of tests: rows, motors found, unknown names, and values that differ."""

    rows: int
    motors: int
    unknown: tuple[str, ...]
    differences: tuple[Difference, ...]


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
    tests: dict[int, tuple[Motor, dict[str, list[tuple[int, float, str]]]]] = {}
    unknown, rows = [], 0
    for number, row in enumerate(lines, start=2):
        rows += 1
        motor = _motor(catalogue, row)
        if motor is None:
            unknown.append(" ".join(row.get(key) or "" for key in NAMES[:2]).strip())
            continue
        _, figures = tests.setdefault(id(motor), (motor, {}))
        basis = _basis(row.get("note") or "")
        for column in FIGURES:
            if (value := _number(row.get(column), f"{name}, row {number}, {column}")) is not None:
                figures.setdefault(column, []).append((basis, value, row.get("source") or name))
    found = [one for motor, figures in tests.values() for one in _differences(motor, figures)]
    found.sort(key=lambda one: -abs(one.ratio))
    return CatalogueComparison(rows, len(tests), tuple(dict.fromkeys(unknown)), tuple(found))


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


def _differences(motor: Motor, figures: Mapping[str, Sequence[tuple[int, float, str]]]) -> list[Difference]:
    listed, found = listed_figures(motor), []
    for column, tests in figures.items():
        best = min(basis for basis, _, _ in tests)
        values = [value for basis, value, _ in tests if basis == best]
        tested = sum(values) / len(values)
        if listed[column] > 0 and abs(tested / listed[column] - 1) > DIFFERENCE:
            field, unit = FIGURES[column]
            source = next(source for basis, _, source in tests if basis == best)
            basis = BASES[best] if best < len(BASES) else ""
            found.append(Difference(motor, field, unit, listed[column], tested, basis, source))
    return found


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
    start = note.strip().removeprefix("basis=")
    return next((place for place, basis in enumerate(BASES) if start.startswith(basis)), len(BASES))


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
