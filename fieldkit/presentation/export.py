"""Flights as a table or a JSON document with the columns of the flight table."""

import csv
import io
from collections.abc import Sequence

from fieldkit.flight import COLUMNS, LOGGED, MEASURED, Flight, table_headers, table_row
from fieldkit.flight.readout import render_sd
from fieldkit.safe_text import as_cell

NUMBERS = {column.header for column in COLUMNS + LOGGED} | {column.sd_header for column in MEASURED}
"""Headers of purely numeric columns, whose values may be negative."""


def csv_table(flights: Sequence[Flight]) -> str:
    """A flight table (RFC 4180) that imports as the same flights and contains nothing that a spreadsheet would
    compute."""
    out = io.StringIO(newline="")
    headers = table_headers(flights)
    writer = csv.writer(out)
    writer.writerow(map(as_cell, headers))
    for row in map(table_row, flights):
        writer.writerow(row.get(name, "") if name in NUMBERS else as_cell(row.get(name, "")) for name in headers)
    return out.getvalue()


def document(flight: Flight) -> dict[str, object]:
    """A flight as JSON: numbers in the unit of their column, None for "not recorded", otherwise text.

    Standard deviations, sources of readouts and values from logs are included if they are recorded.
    """
    row: dict[str, object] = dict(table_row(flight))
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
