"""A readout that is off by the ratio of two units: the number was read in one and meant in the other."""

from dataclasses import dataclass
from math import log

from fieldkit.flight.columns import Column
from fieldkit.spelled_units import rounded, with_unit
from fieldkit.units import UNITS

CONFUSED = {
    "length": (("m", "ft"),),
    "speed": (("m/s", "mph"), ("mph", "km/h"), ("m/s", "km/h"), ("m/s", "ft/s")),
    "acceleration": (("g", "m/s2"),),
}
"""Units that altimeters and programs show for the same readouts, by quantity."""
MAX_SD = 0.15
"""Largest standard deviation of a log ratio that distinguishes two units: mph and km/h are 0.48 apart. [1]"""
MAX_DISTANCE, MIN_ADVANTAGE = 2.0, 1.0
"""A ratio agrees with that of two units within this many standard deviations [1], and must have a log density this much
higher there than at any other ratio. [nat]"""
LEAST_SD = 0.02
"""Least standard deviation of a log ratio: displays round. [1]"""


@dataclass(frozen=True, slots=True)
class UnitSlip:
    """A number that was meant in one unit and read in another."""

    number: float
    meant: str
    read: str

    @property
    def typed(self) -> str:
        """The number with the unit that was meant, as it is typed: `918ft`."""
        return f"{self.number:.6g}{self.meant}"

    @property
    def words(self) -> str:
        """`918 ft taken for 918 m`."""
        number = rounded(self.number)
        return f"{with_unit(number, self.meant)} taken for {with_unit(number, self.read)}"


def unit_slip(column: Column, value: float, log_ratio: float, sd: float) -> UnitSlip | None:
    """The two units that explain by how much a value [SI] differs from the expected one, whose log ratio has a standard
    deviation; None if no pair does, or several do about as well.

    Derivation: a number N meant in a unit of a SI units and read in one of b is N b, and b/a times what it should be.
    """
    confused = CONFUSED.get(column.quantity, ())
    sd = max(sd, LEAST_SD)
    if not sd <= MAX_SD:
        return None
    factor = {name: unit.factor for name, unit in UNITS[column.quantity].items()}
    pairs = [*confused, *((read, meant) for meant, read in confused)]
    far = {pair: abs(log_ratio - log(factor[pair[1]] / factor[pair[0]])) / sd for pair in pairs}
    first, second = (*sorted(far, key=lambda pair: far[pair])[:2], None, None)[:2]
    if first is None or not far[first] <= MAX_DISTANCE:
        return None
    if second is not None and far[second] ** 2 - far[first] ** 2 < 2 * MIN_ADVANTAGE:
        return None
    meant, read = first
    return UnitSlip(value / factor[read], meant, read)
