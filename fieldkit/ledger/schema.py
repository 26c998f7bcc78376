"""The version of a ledger's schema, missing tables or columns, and upgrades.

Alembic is imported only if a ledger is new or older than this program.
"""

import re
from pathlib import Path

from sqlalchemy import Connection, inspect, text
from sqlalchemy.exc import DBAPIError

from fieldkit.errors import LedgerError, shortened
from fieldkit.ledger.rows import DamagedRow
from fieldkit.ledger.tables import metadata
from fieldkit.ledger.whereabouts import name_of

MIGRATIONS = Path(__file__).parent / "migrations"
STEPS = tuple(sorted(path.stem for path in (MIGRATIONS / "versions").glob("m[0-9]*.py")))
"""Every version of the schema that this program knows, oldest first."""
_FOREIGN = """
SELECT type AS kind, name FROM sqlite_master WHERE type IN ('view', 'trigger')
UNION ALL SELECT 'virtual table', name FROM sqlite_master WHERE type = 'table' AND sql LIKE 'CREATE VIRTUAL%'
UNION ALL SELECT 'computed column', c.name FROM sqlite_master AS m, pragma_table_xinfo(m.name) AS c
    WHERE m.type = 'table' AND m.sql NOT LIKE 'CREATE VIRTUAL%' AND c.hidden > 0
UNION ALL SELECT 'index of an expression', m.name FROM sqlite_master AS m, pragma_index_xinfo(m.name) AS c
    WHERE m.type = 'index' AND c.cid = -2
"""
"""What no fieldkit creates, cheapest first."""


def version(connection: Connection) -> str | None:
    """The schema version of a ledger; None for an empty database.

    Raises LedgerError for another program's tables and those of a newer fieldkit, DamagedRow for a version that never
    existed.
    """
    name = name_of(connection.engine.url)
    tables = inspect(connection)
    if tables.has_table("alembic_version"):
        versions = list(connection.scalars(text("SELECT version_num FROM alembic_version LIMIT 2")))
        if len(versions) > 1:
            raise LedgerError(
                f"{name}: found two versions of its tables, {versions[0]} and {versions[1]}, expected one"
            )
        found = str(versions[0] if versions else None)
        if found in STEPS:
            return found
        if re.match(r"m\d{3}_", found):
            if found[:4] > STEPS[-1][:4]:
                raise LedgerError(f"{name}: made by a newer fieldkit ({found}), expected {STEPS[-1]} or older")
            raise DamagedRow(f"found the version {found}, expected one of {', '.join(STEPS)}")
    elif not tables.get_table_names():
        return None
    raise LedgerError(f"{name}: found another program's tables, expected a ledger or an empty database")


def check_objects(connection: Connection) -> None:
    """Raise LedgerError for a SQLite ledger with a view, a trigger, a virtual table, a column that is computed, or an
    index of what is: no fieldkit made it, and each of them would run what its maker wrote."""
    if connection.dialect.name != "sqlite":
        return
    found = connection.execute(text(f"{_FOREIGN} LIMIT 1")).first()
    if found is not None:
        raise LedgerError(
            f"{name_of(connection.engine.url)}: found the {found.kind} {shortened(str(found.name))} in it, which no "
            "ledger has; import its flights from an export instead"
        )


def missing(connection: Connection) -> str:
    """A table or column missing from a ledger of the newest version, or why that is unknown; otherwise empty."""
    try:
        there = inspect(connection)
        for name, table in metadata.tables.items():
            if not there.has_table(name):
                return f"table {name} is missing"
            if lost := set(table.columns.keys()) - {column["name"] for column in there.get_columns(name)}:
                return f"column {min(lost)} of {name} is missing"
    except DBAPIError as error:  # names that are no longer valid text
        return " ".join(str(error.orig).split())
    return ""


def upgrade(connection: Connection, step: str = "head") -> None:
    """Create or upgrade the tables to the newest version, or to an older one."""
    from alembic import command  # takes 0.09 s to import
    from alembic.config import Config  # takes 0.2 s more

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    command.upgrade(config, step)
