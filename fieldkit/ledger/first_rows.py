"""The latest flights of a ledger read without SQLAlchemy, whose import takes as long as that of Textual: the app lists
them while the rest is imported."""

import os
import sqlite3
from contextlib import closing
from datetime import datetime
from math import isfinite
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fieldkit.flight import Flight
from fieldkit.paths import data_file, expanded, ledger_trouble

SELECT_NEWEST = """SELECT flight_id, rocket, config, motor, apogee, date_time, log FROM flights
ORDER BY date_time DESC, entry DESC LIMIT ?"""
HAS_UNUSUAL = """SELECT EXISTS (SELECT 1 FROM flights WHERE date_time IS NULL OR flight_id LIKE '%/%')
OR EXISTS (SELECT 1 FROM flights GROUP BY flight_id HAVING count(*) > 1)"""
"""Whether flights without a date, or with ids that are not unique or contain a slash, make a list more than a sort by
date."""


def first_rows(where: str | Path | None, most: int) -> list[tuple[str, Flight]]:
    """The latest flights of a ledger with their ids, newest first, with only the fields that a list shows, unchecked.

    Empty if the ledger is not a SQLite file, cannot be read immediately, or has flights that are not simple to list;
    then `Ledger` reads them or reports why it cannot.
    """
    where = where or os.environ.get("FIELDKIT_LEDGER") or data_file("ledger.db")
    if "://" in str(where):
        return []
    file = expanded(where).absolute()
    if ledger_trouble(file) or ledger_trouble(file.resolve()):
        return []
    try:
        with closing(sqlite3.connect(f"file:{quote(str(file))}?mode=ro", uri=True, timeout=0)) as connection:
            connection.execute("PRAGMA trusted_schema = OFF")
            if connection.execute(HAS_UNUSUAL).fetchone() != (0,):
                return []
            return [_listed(row) for row in connection.execute(SELECT_NEWEST, (most,))]
    except (sqlite3.Error, TypeError, ValueError):
        return []


def _listed(row: tuple[Any, ...]) -> tuple[str, Flight]:
    """A flight from its row. Raises TypeError or ValueError for values that no ledger has unless it is damaged."""
    id, rocket, config, motor, apogee, moment, log = row
    height = None if apogee is None else float(apogee)
    if not (all(isinstance(text, str) for text in (id, rocket, config, motor, log)) and isfinite(height or 0.0)):
        raise ValueError("found a damaged row")
    when = datetime.fromisoformat(moment)
    return id, Flight(id, rocket, config=config, motor=motor, apogee=height, date_time=when, log=log)
