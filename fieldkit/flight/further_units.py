"""Further columns of a flight table whose unit is known: the same number in another unit, under that header."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight.columns import BY_NAME, MOTOR_TEMPERATURE, READOUTS, TWO_DEVICES
from fieldkit.flight.flight import Flight
from fieldkit.flight.recovery import RECOVERY_COLUMNS, UNCERTAIN_WEATHER

LIFT_OFF_MASS = "liftoff_mass_g"
"""Extra column of a flight on an unknown motor: what it weighed on the pad."""


@dataclass(frozen=True, slots=True)
class FurtherColumn:
    """A further column that is a number: `unit` is its own, as its header spells it; `difference` is whether it is a
    standard deviation."""

    name: str
    quantity: str
    unit: str
    difference: bool = False

    def header(self, unit: str = "") -> str:
        """Its header, in another unit if one is given."""
        return f"{self.name}_{unit or self.unit}"

    def value(self, text: str, unit: str) -> float:
        """A text in a unit as an SI value. Raises BadValue."""
        return (units.parse_difference if self.difference else units.parse)(text, self.quantity, unit)

    def render(self, value: float, unit: str) -> str:
        """An SI value as a text in a unit."""
        return (units.render_difference if self.difference else units.render)(value, self.quantity, unit)


def _column(header: str, quantity: str, *, difference: bool = False) -> FurtherColumn:
    name, _, unit = header.rpartition("_")
    return FurtherColumn(name, quantity, unit, difference)


COLUMNS = (
    *(FurtherColumn(name, quantity, unit) for name, (quantity, unit, _) in RECOVERY_COLUMNS.items()),
    _column(MOTOR_TEMPERATURE, "temperature"),
    _column(LIFT_OFF_MASS, "mass"),
    *(_column(column.stated_header, column.quantity) for column in READOUTS),
    *(
        _column(column.sd_header, column.quantity, difference=True)
        for column in (*(BY_NAME[name] for name in UNCERTAIN_WEATHER), *TWO_DEVICES)
    ),
)
"""The further columns that fieldkit knows as numbers with a unit."""
_BY_HEADER = {
    column.header(unit): (column, unit) for column in COLUMNS for unit in units.UNITS[column.quantity] if unit.isalnum()
}
_COLUMN_OF = _BY_HEADER | {column.name: (column, column.unit) for column in COLUMNS if column.name in RECOVERY_COLUMNS}
"""Each header with its column and unit; those of the recovery may be without one."""


def in_units(extra: Mapping[str, str], unit_of: Callable[[str], str]) -> Mapping[str, str]:
    """Further columns with the numbers among them in the units that `unit_of` has for their own; texts that are no
    numbers, and columns that fieldkit does not know, as they are."""
    if _COLUMN_OF.keys().isdisjoint(extra):
        return extra
    found: dict[str, str] = {}
    for header, text in extra.items():
        if header in _COLUMN_OF:
            column, unit = _COLUMN_OF[header]
            renamed = column.header(unit_of(column.unit))
            if renamed != header and renamed not in {*extra, *found}:
                with suppress(BadValue):
                    header, text = renamed, column.render(column.value(text, unit), unit_of(column.unit))
        found[header] = text
    return found


def in_own_units(extra: Mapping[str, str]) -> Mapping[str, str]:
    """Further columns with the numbers among them in the units of a ledger, whatever unit their header names."""
    return in_units(extra, lambda unit: unit)


def with_units(flight: Flight, unit_of: Callable[[str], str] = lambda unit: unit) -> Flight:
    """A flight whose further columns are as `in_units`, by default in the units of a ledger."""
    return flight.with_changes(extra=in_units(flight.extra, unit_of))


def amounts(extra: Mapping[str, str]) -> dict[str, float | str]:
    """Further columns to be compared: numbers with a unit in SI, by the header in the unit of a ledger."""
    found: dict[str, float | str] = {}
    for header, text in in_own_units(extra).items():
        found[header] = text
        if header in _BY_HEADER:
            with suppress(BadValue):
                column, unit = _BY_HEADER[header]
                found[header] = column.value(text, unit)
    return found
