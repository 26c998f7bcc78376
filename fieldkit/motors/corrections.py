"""Corrections to the catalog: values from certifications, makers and tests that replace nominal or wrong ones."""

import csv
from collections.abc import Iterable
from dataclasses import astuple, dataclass
from io import StringIO
from pathlib import Path

from fieldkit.errors import BadValue
from fieldkit.files import read_own

DATA = Path(__file__).parents[1] / "data" / "motor_corrections.csv"
"""Corrections to the data of ThrustCurve.org, each with its source and confidence."""

QUANTITIES = {
    "total_impulse_ns": ("total impulse", "N s"),
    "average_n": ("average thrust", "N"),
    "peak_n": ("peak thrust", "N"),
    "burn_s": ("burn time", "s"),
    "propellant_g": ("propellant", "g"),
    "loaded_g": ("loaded mass", "g"),
    "length_mm": ("length", "mm"),
}
"""Numeric fields: the name and unit of each."""
TEXTS = ("designation", "name", "class", "delays")
"""Fields that are text; delays are written as `4,6,8,P`."""
CONFIDENCES = ("sure", "likely", "open")
"""Based on two independent documents, or on one and arithmetic; on one document; on conflicting documents, in which
case the correction is not applied."""


@dataclass(frozen=True, slots=True)
class Correction:
    """A value of a motor: as in the catalog, as corrected, the confidence, and the source document.

    An `open` correction is not applied; its `value` is the other document's, empty if it has none.
    """

    field: str
    was: str
    value: str
    confidence: str
    source: str

    @property
    def applied(self) -> bool:
        """Whether the catalog uses `value` instead of `was`."""
        return self.confidence != "open"

    def text(self, *, before: bool = True) -> str:
        """The correction in a line: `total impulse 4.29 N s instead of 5 (sure: NAR test figures)`; the previous value
        only with `before`."""
        what, unit = QUANTITIES.get(self.field, (self.field, ""))
        now, was = f"{self.value} {unit}".strip(), self.was or "none"
        if self.applied:
            instead = f" instead of {was}" if before and self.field != "motor" else ""
            return f"{what} {now}{instead} ({self.confidence}: {self.source})"
        other = f"; {now} in another document" if self.value else ""
        return f"{what} {was}{other} (open: {self.source})"

    def json(self) -> dict[str, object]:
        """Ready for JSON."""
        return {
            "field": self.field,
            "was": self.was,
            "value": self.value,
            "confidence": self.confidence,
            "source": self.source,
        }


def read_corrections(path: Path = DATA) -> dict[tuple[str, str], list[Correction]]:
    """The corrections in a table by maker and designation. Raises BadValue that names the row, OSError."""
    found: dict[tuple[str, str], list[Correction]] = {}
    for number, row in enumerate(csv.DictReader(StringIO(read_own(path), newline="")), start=2):
        one = Correction(row["field"], row["was"], row["value"], row["confidence"], row["source"])
        if one.field not in (*QUANTITIES, *TEXTS):
            raise BadValue(f"{path.name}, row {number}: found the field {one.field!r}, expected a known one")
        if one.confidence not in CONFIDENCES or not one.source:
            raise BadValue(f"{path.name}, row {number}: expected one of {', '.join(CONFIDENCES)} and a source")
        found.setdefault((row["maker"], row["designation"]), []).append(one)
    return found


def as_rows(corrections: Iterable[Correction]) -> list[list[str]]:
    """The corrections as lists of texts, as stored in the shipped catalog."""
    return [list(astuple(one)) for one in corrections]
