"""The records everything shares: a flight, its columns, and the time series of a log.

`COLUMNS` is the single list of the numbers recorded for a flight. The flight table, the prompts, the ledger, the
exports and the JSON are all generated from it. Values are SI inside a `Flight`; a column's name carries the unit that
flyers see.
"""

from fieldkit.flight.columns import (
    BY_NAME,
    COLUMNS,
    CONDITIONS,
    FIGURES_BY_NAME,
    LOG_FIGURES,
    LOGGED,
    MEASURED,
    MOTOR_TEMPERATURE,
    READOUTS,
    SETUP,
    TWO_DEVICES,
    Column,
)
from fieldkit.flight.flight import FIELDS, Flight
from fieldkit.flight.readout import SENSORS, SOURCES, Readout
from fieldkit.flight.series import Series
from fieldkit.flight.table import TEXT_COLUMNS, read_date, table_headers, table_row
from fieldkit.flight.tags import CHECKED_TAG, KNOWN_TAGS, TAGS, read_tags

__all__ = [
    "BY_NAME",
    "CHECKED_TAG",
    "COLUMNS",
    "CONDITIONS",
    "FIELDS",
    "FIGURES_BY_NAME",
    "KNOWN_TAGS",
    "LOGGED",
    "LOG_FIGURES",
    "MEASURED",
    "MOTOR_TEMPERATURE",
    "READOUTS",
    "SENSORS",
    "SETUP",
    "SOURCES",
    "TAGS",
    "TEXT_COLUMNS",
    "TWO_DEVICES",
    "Column",
    "Flight",
    "Readout",
    "Series",
    "read_date",
    "read_tags",
    "table_headers",
    "table_row",
]
