"""Check that a ledger's file has not changed since it was written: SQLite's own check, then every row's checksum.

SQLite detects a malformed page, but not a changed letter or digit. The checksums do, but take longer; rows that are
identical in a backup of the ledger, which was checked when it was made, are skipped.
"""

import sqlite3
import zlib
from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from json import JSONDecodeError
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, FromClause, MetaData, Table, and_, create_engine, inspect, or_, select, text
from sqlalchemy.engine import URL
from sqlalchemy.exc import DBAPIError

from fieldkit.errors import LedgerError
from fieldkit.ledger.checksums import CHECKSUM, check
from fieldkit.ledger.logs import check_logs
from fieldkit.ledger.rows import DamagedRow
from fieldkit.ledger.schema import STEPS, missing, version
from fieldkit.ledger.tables import flights, logs, metadata, tags

PATIENCE = 15.0
"""How long a command or a backup waits for a writing process. [s]"""
Keys = Collection[tuple[Any, ...]]
"""Primary keys of rows."""

_DAMAGE = ("SQLITE_CORRUPT", "SQLITE_NOTADB")
_HEADING = "*** in database main *** "
"""What SQLite writes above the first damaged page."""
_PAST_TABLE = "past"


def opened(file: Path) -> closing[sqlite3.Connection]:
    """Open an existing database for a `with` statement; SQLite would create a missing one."""
    return closing(sqlite3.connect(f"{file.absolute().as_uri()}?mode=rw", uri=True, timeout=PATIENCE))


def fault(file: Path, *, since: Path | None = None) -> str:
    """What is wrong with a ledger's file, in one line; empty if nothing. Raises sqlite3.Error.

    `since` is a sound backup of it.
    """
    return file_fault(file) or row_fault(file, since=since)


def file_fault(file: Path, *, thorough: bool = False) -> str:
    """What SQLite finds wrong with a database, in one line; empty if nothing. Raises sqlite3.Error.

    A `thorough` check also compares every index with its table, which takes longer.
    """
    check = "integrity_check" if thorough else "quick_check"
    try:
        with opened(file) as ledger:
            message = str(ledger.execute(f"PRAGMA {check}(1)").fetchone()[0])
    except sqlite3.DatabaseError as error:
        message = damage_in(error)
    return "" if message == "ok" else " ".join(message.split()).removeprefix(_HEADING)


def row_fault(file: Path, *, since: Path | None = None) -> str:
    """The first damaged row of a ledger, empty if there is none. Raises sqlite3.Error.

    Rows that are identical in `since`, a sound backup, are skipped. So are all rows of a newer fieldkit with unknown
    columns.
    """
    try:
        with _connected(file) as connection:
            return _first_fault(connection, _changed_keys(connection, since) if since else {})
    except LedgerError:
        return ""
    except (DamagedRow, JSONDecodeError, UnicodeDecodeError, zlib.error) as error:
        return str(error)
    except DBAPIError as error:  # also raised when the connection is opened or closed
        if not isinstance(error.orig, sqlite3.DatabaseError):
            raise
        return damage_in(error.orig)


def damage_in(error: sqlite3.DatabaseError) -> str:
    """SQLite's report of damage, in one line; other errors are raised again."""
    message = " ".join(str(error).split())
    if getattr(error, "sqlite_errorname", "").startswith(_DAMAGE) or message.startswith("Could not decode"):
        return message
    raise error


@contextmanager
def _connected(file: Path) -> Iterator[Connection]:
    engine = create_engine(URL.create("sqlite", database=str(file)), connect_args={"timeout": PATIENCE})
    try:
        with engine.connect() as connection:
            yield connection
    finally:
        engine.dispose()


def _changed_keys(connection: Connection, copy: Path) -> dict[Table, Keys]:
    """Rows that a backup lacks or has with other content, by table; empty if it is damaged or has other tables."""
    try:
        connection.execute(text(f"ATTACH :copy AS {_PAST_TABLE}"), {"copy": str(copy)})
        step = f"SELECT :newest IN (SELECT version_num FROM {_PAST_TABLE}.alembic_version)"
        newest = connection.scalar(text(step), {"newest": STEPS[-1]})
        return {table: _changed(connection, table) for table in metadata.sorted_tables} if newest else {}
    except DBAPIError:
        return {}


def _first_fault(connection: Connection, changed_keys: dict[Table, Keys]) -> str:
    """What a ledger has lost, empty for nothing. Raises DamagedRow for the first bad row, of the given ones or all."""
    if version(connection) == STEPS[-1] and (lost := missing(connection)):
        return lost
    if orphan := connection.execute(text("PRAGMA main.foreign_key_check")).first():
        return f"a row of {orphan[0]} refers to a missing row of {orphan[2]}"
    there = inspect(connection)
    for table in (table for table in metadata.sorted_tables if there.has_table(table.name)):
        names = {column["name"] for column in there.get_columns(table.name)}
        keys = changed_keys[table] if table in changed_keys else _all(connection, table)
        if CHECKSUM in names:
            check(connection, table, keys, [one for one in table.columns if one.name in names])
        elif table is logs:
            check_logs(connection, [digest for (digest,) in keys])
    return ""


def _all(connection: Connection, table: Table) -> Keys:
    return [tuple(row) for row in connection.execute(select(*table.primary_key))]


def _changed(connection: Connection, table: Table) -> Keys:
    """Rows that differ from the backup or are missing from it, including flights whose tags differ."""
    past = _past(table)
    at = and_(*(column == past.c[column.name] for column in table.primary_key))
    other = or_(*(column.is_distinct_from(past.c[column.name]) for column in table.columns))
    found = {tuple(row) for row in connection.execute(select(*table.primary_key).outerjoin(past, at).where(other))}
    return found | _retagged(connection) if table is flights else found


def _past(table: Table) -> FromClause:
    """A table of the backup, aliased because both databases use the same names."""
    return table.to_metadata(MetaData(), schema=_PAST_TABLE).alias(f"{_PAST_TABLE}_{table.name}")


def _retagged(connection: Connection) -> set[tuple[Any, ...]]:
    past = _past(tags)
    gone = select(past).except_(select(tags)).subquery()
    new = select(tags).except_(select(past)).subquery()
    return {tuple(row) for row in connection.execute(select(gone.c.entry).union(select(new.c.entry)))}
