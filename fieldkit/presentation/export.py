"""Flights as a table or a JSON document with the columns of the flight table."""

import csv
import io
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from fieldkit import units
from fieldkit.flight import COLUMNS, LOGGED, MEASURED, Column, Flight, table_headers, table_row
from fieldkit.flight.further_units import with_units
from fieldkit.flight.readout import render_sd
from fieldkit.quantities import SYSTEMS, unit_of
from fieldkit.safe_text import as_cell

NUMBERS = {column.header for column in COLUMNS + LOGGED} | {column.sd_header for column in MEASURED}
"""Headers of purely numeric columns, whose values may be negative."""


def csv_table(flights: Sequence[Flight], system: str = "SI") -> str:
    """A flight table (RFC 4180) that imports as the same flights and contains nothing that a spreadsheet would
    compute; its headers name the units of a system, also those of further columns with a known unit."""
    flights = [with_units(flight, partial(_unit_of, system)) for flight in flights]
    out = io.StringIO(newline="")
    headers = table_headers(flights)
    own = {column.header: _in_units(column, system).header for column in COLUMNS + LOGGED}
    own |= {column.sd_header: _in_units(column, system).sd_header for column in MEASURED}
    writer = csv.writer(out)
    writer.writerow(as_cell(own.get(name, name)) for name in headers)
    for flight in flights:
        row = table_row(flight) | _numbers(flight, system)
        writer.writerow(row.get(name, "") if name in NUMBERS else as_cell(row.get(name, "")) for name in headers)
    return out.getvalue()


def _unit_of(system: str, unit: str) -> str:
    """The unit of a system for that of a further column, as a header spells it."""
    shown = SYSTEMS[system].get("m/s" if unit == "mps" else unit, unit)
    return shown if shown.isalpha() else unit


def _in_units(column: Column, system: str) -> Column:
    """A column in the unit of a system, or in its own if a header cannot name that unit."""
    unit = unit_of(column, system)
    return replace(column, unit=unit, suffix=unit) if unit.isalpha() else column


def _numbers(flight: Flight, system: str) -> dict[str, str]:
    """The numbers of a flight and their standard deviations in the units of a system, by their headers in SI."""
    row = {}
    for column in COLUMNS + LOGGED:
        own = _in_units(column, system)
        if (value := flight.number(column.name)) is not None:
            row[column.header] = own.render(value)
        if column in MEASURED and column.name in flight.sd:
            row[column.sd_header] = units.render_difference(flight.sd[column.name], column.quantity, own.unit)
    return row


def document(flight: Flight) -> dict[str, object]:
    """A flight as JSON: numbers in the unit of their column, None for "not recorded", otherwise text.

    Standard deviations, sources of readouts and values from logs are included if they are recorded.
    """
    row: dict[str, object] = dict(table_row(with_units(flight)))
    for column in COLUMNS:
        value = flight.number(column.name)
        row[column.header] = None if value is None else float(column.render(value))
    for column in LOGGED:
        if (value := flight.number(column.name)) is not None:
            row[column.header] = float(column.render(value))
    for column in MEASURED:
        if column.name in flight.sd:
            row[column.sd_header] = float(render_sd(column.name, flight.sd[column.name]))
    return row
