"""Flights as a table or a JSON document, in the columns of the flight table, to be read by anyone again."""

import csv
import io
from collections.abc import Sequence

from fieldkit.flight import COLUMNS, Flight, table_headers, table_row


def csv_table(flights: Sequence[Flight]) -> str:
    """A flight table that imports again as the same flights."""
    out = io.StringIO()
    writer = csv.DictWriter(out, table_headers(flights), restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(table_row(flight) for flight in flights)
    return out.getvalue()


def document(flight: Flight) -> dict[str, object]:
    """A flight as JSON: numbers in the unit of their column, None for "not recorded", else texts."""
    row: dict[str, object] = dict(table_row(flight))
    for column in COLUMNS:
        value = flight.number(column.name)
        row[column.header] = None if value is None else float(column.render(value))
    return row
