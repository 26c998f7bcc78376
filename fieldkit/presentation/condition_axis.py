"""Conditions of flights along an axis: a title with the unit, and values in it."""

import numpy as np

from fieldkit import units
from fieldkit.quantities import ShownUnits, spelled, unit_of
from fieldkit.selection.recorded_columns import BY_HEADER
from fieldkit.shapes import Array, Float


def in_units(header: str, values: Float[Array, "flight"], system: str) -> tuple[str, Float[Array, "flight"]]:
    """The title and the values of one of `columns_of`, given in SI, in the unit of a system."""
    if header == "expected_top_speed_mps":
        shown = ShownUnits(system)
        return f"expected top speed [{shown.speed_unit}]", values / shown.speed_factor
    column = BY_HEADER.get(header)
    if column is None:
        return header.replace("_", " "), values
    name = unit_of(column, system)
    unit = units.unit(column.quantity, name) if column.quantity else None
    if unit is None:
        return column.title.lower(), values
    return f"{column.title.lower()} [{spelled(name)}]", np.array([unit.from_si(float(value)) for value in values])
