"""Corrections of the catalog: figures of certifications, makers and tests that replace a nominal or mistaken one."""

import csv
from collections.abc import Iterable
from dataclasses import astuple, dataclass
from io import StringIO
from pathlib import Path

from fieldkit.errors import BadValue
from fieldkit.files import read_own

DATA = Path(__file__).parents[1] / "data" / "motor_corrections.csv"
"""Which figures of ThrustCurve.org are corrected, each with its source and how sure it is."""

QUANTITIES = {
    "total_impulse_ns": ("total impulse", "N s"),
    "average_n": ("average thrust", "N"),
    "peak_n": ("peak thrust", "N"),
    "burn_s": ("burn time", "s"),
    "propellant_g": ("propellant", "g"),
    "loaded_g": ("loaded mass", "g"),
    "length_mm": ("length", "mm"),
}
"""Fields that are numbers: what each is called, and its unit."""
TEXTS = ("designation", "name", "class", "delays")
"""Fields that are text; delays are written as `4,6,8,P`."""
CONFIDENCES = ("sure", "likely", "open")
"""Two independent documents, or one and arithmetic; one document; documents that disagree: never applied."""


@dataclass(frozen=True, slots=True)
class Correction:
    """A figure of a motor: as the catalog has it, as it should be, how sure that is, and by which document.

    An `open` correction is not applied; its `value` is what the other document says, empty if none says.
    """

    field: str
    was: str
    value: str
    confidence: str
    source: str

    @property
    def applied(self) -> bool:
        """Whether the catalog carries `value` instead of `was`."""
        return self.confidence != "open"

    def text(self, *, before: bool = True) -> str:
        """The correction in a line: `total impulse 4.29 N s instead of 5 (sure: NAR test figures)`; what it was only if
        `before` is wanted."""
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
    """The corrections of a table by maker and designation. Raises BadValue that names the row."""
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
    """The corrections as lists of texts, as the shipped catalog keeps them."""
    return [list(astuple(one)) for one in corrections]
