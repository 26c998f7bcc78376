"""Finding, opening and upgrading a ledger, on SQLite or PostgreSQL.

SQLite keeps its rollback journal and `synchronous=EXTRA`: a finished command survives a power cut, and the
ledger stays one file that can be copied at any time, which a write-ahead log beside it would not allow.
Alembic is imported only when a ledger is new or older than this program.
"""

import os
import re
import sqlite3
import zlib
from collections.abc import Iterator
from contextlib import closing, contextmanager
from json import JSONDecodeError
from pathlib import Path

from sqlalchemy import Connection, Engine, create_engine, event, func, inspect, select, text
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError
from sqlalchemy.pool import ConnectionPoolEntry

from fieldkit.errors import LedgerError
from fieldkit.ledger import backups
from fieldkit.ledger.rows import DamagedRow
from fieldkit.ledger.tables import journal, metadata
from fieldkit.places import data_folder

PATIENCE = 15.0
"""How long a command waits for another one that is writing. [s]"""
SMALLEST = 512
"""No SQLite database that holds anything is smaller, and it takes a smaller file for an empty one. [byte]"""
MIGRATIONS = Path(__file__).parent / "migrations"
STEPS = tuple(sorted(path.stem for path in (MIGRATIONS / "versions").glob("m[0-9]*.py")))
"""Every version of the schema that this program knows, oldest first."""

_DRIVERS = {"sqlite": "sqlite", "postgresql": "postgresql+psycopg", "postgres": "postgresql+psycopg"}
_LOCK = 0x666B  # any number that nobody else on the server is likely to use
_SQLITE = {
    "SQLITE_NOTADB": "this file is not a ledger, expected a file made by fieldkit",
    "SQLITE_CORRUPT": "the file is damaged",
    "SQLITE_READONLY": "the ledger is read-only, expected a file and folder that may be written",
    "SQLITE_FULL": "the disk is full; nothing was changed, free some space and try again",
    "SQLITE_BUSY": f"another program has kept it locked for {PATIENCE:.0f} s; nothing was changed, try again",
    "SQLITE_LOCKED": "another program has locked the ledger; nothing was changed, try again",
    "SQLITE_CANTOPEN": "cannot open the file, expected one in a folder that exists and may be read",
    "SQLITE_IOERR": "the disk failed to read or write; nothing was changed",
    "SQLITE_PERM": "no permission to use the file",
}

_GARBLED = ("Could not decode to UTF-8", "malformed JSON")
"""How SQLite says, without a code of its own, that a text is not what was written."""


def location(where: str | Path | None) -> URL:
    """The URL of a ledger named by a path or URL, by FIELDKIT_LEDGER, or the one in the user's data folder.

    Raises LedgerError for a URL that is neither SQLite's nor PostgreSQL's.
    """
    where = where or os.environ.get("FIELDKIT_LEDGER") or data_folder() / "ledger.db"
    if isinstance(where, Path) or "://" not in where:
        return URL.create("sqlite", database=str(Path(where).expanduser()))
    try:
        url = make_url(where)
    except ArgumentError:
        raise LedgerError(f"found the ledger {where!r}, expected a path or a URL such as sqlite:///FILE") from None
    dialect = url.get_backend_name()
    if dialect not in _DRIVERS:
        raise LedgerError(f"found a ledger on {dialect}, expected sqlite or postgresql")
    return url if "+" in url.drivername else url.set(drivername=_DRIVERS[dialect])


def name_of(url: URL) -> str:
    """A ledger's name for messages: its path, or its URL without the password."""
    return str(url.database) if url.drivername == "sqlite" and url.database else url.render_as_string()


def file_of(url: URL) -> Path | None:
    """The file of a ledger, None for one in memory, on a server, or opened by a URL of SQLite's own."""
    plain = url.get_backend_name() == "sqlite" and url.database and not url.database.startswith((":", "file:"))
    return Path(str(url.database)) if plain else None


def connect(url: URL) -> Engine:
    """An engine whose connections keep what they are told; touches no file yet."""
    sqlite = url.get_backend_name() == "sqlite"
    try:
        engine = create_engine(url, connect_args={"timeout": PATIENCE} if sqlite else {})
    except ModuleNotFoundError as error:
        raise LedgerError(f"{name_of(url)}: needs {error.name}; install fieldkit[postgres]") from error
    except (ArgumentError, NoSuchModuleError) as error:
        raise LedgerError(f"{name_of(url)}: {error}") from error
    if sqlite:
        event.listen(engine, "connect", _prepare_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
    else:
        event.listen(engine, "begin", _begin_server)
    return engine


def _prepare_sqlite(connection: object, _entry: ConnectionPoolEntry) -> None:
    connection.isolation_level = None  # type: ignore[attr-defined]  # transactions are begun below
    for setting in ("foreign_keys = ON", "synchronous = EXTRA"):
        connection.execute(f"PRAGMA {setting}")  # type: ignore[attr-defined]


def _begin_sqlite(connection: Connection) -> None:
    writes = connection.get_execution_options().get("writes")
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _begin_server(connection: Connection) -> None:
    if connection.get_execution_options().get("writes"):
        connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_LOCK})")


@contextmanager
def reading(engine: Engine) -> Iterator[Connection]:
    """A connection that sees one state of the ledger."""
    with _explained(engine), engine.connect() as connection:
        yield connection


@contextmanager
def writing(engine: Engine, *, keep: bool = True) -> Iterator[Connection]:
    """A connection whose changes are kept together at the end, or not at all; one writer at a time."""
    with _explained(engine), engine.execution_options(writes=True).connect() as connection:
        yield connection
        if keep:
            connection.commit()


@contextmanager
def _explained(engine: Engine) -> Iterator[None]:
    try:
        yield
    except DBAPIError as error:
        if why := _reason(error) or _damage(engine):
            raise LedgerError(f"{name_of(engine.url)}: {why}{_offered(engine, why)}") from error
        raise
    except (DamagedRow, JSONDecodeError, UnicodeDecodeError, zlib.error) as error:
        why = f"the file is damaged ({error})"
        raise LedgerError(f"{name_of(engine.url)}: {why}{_offered(engine, why)}") from error
    except UnicodeEncodeError as error:
        raise LedgerError(f"found {error.object!r}, expected text in Unicode") from error
    except (TypeError, ValueError, LookupError) as error:  # of a row that reads as no row of ours can
        if why := _damage(engine):
            raise LedgerError(f"{name_of(engine.url)}: {why}{_offered(engine, why)}") from error
        raise


def _reason(error: DBAPIError) -> str | None:
    """What the flyer can mend, or None where the fault is ours or the file's."""
    code = getattr(error.orig, "sqlite_errorname", "")
    for start, why in _SQLITE.items():
        if code.startswith(start):
            return why
    said = " ".join(str(error.orig).split())
    if said.startswith(_GARBLED):
        return f"the file is damaged ({said})"
    state = getattr(error.orig, "sqlstate", None)
    refused = state in ("25006", "42501")  # read-only transaction, insufficient privilege
    if refused or (not code and (error.connection_invalidated or type(error).__name__ == "OperationalError")):
        return said
    return None


def _damage(engine: Engine) -> str | None:
    """What is wrong with a ledger's file, where something failed that goes through on every sound one."""
    file = file_of(engine.url)
    fault = (backups.fault(file, thorough=True) or _missing(engine)) if file else ""
    return f"the file is damaged ({fault})" if fault else None


def _missing(engine: Engine) -> str:
    """A table or a column that a ledger has lost, or why not even that can be told; empty where all are there."""
    try:
        with engine.connect() as connection:
            there = inspect(connection)
            for name, table in metadata.tables.items():
                if not there.has_table(name):
                    return f"without its table {name}"
                if lost := set(table.columns.keys()) - {column["name"] for column in there.get_columns(name)}:
                    return f"without the column {min(lost)} of {name}"
    except DBAPIError as error:  # of names that are no text any more
        return " ".join(str(error.orig).split())
    return ""


def _offered(engine: Engine, why: str) -> str:
    """How to get a damaged ledger back, empty for another trouble."""
    file = file_of(engine.url)
    hurt = why.startswith("the file is damaged") or (why == _SQLITE["SQLITE_NOTADB"] and file and backups.backups(file))
    return f"; {backups.offer(file)}" if hurt and file else ""


def keep_backup(engine: Engine, *, always: bool = False) -> str:
    """Copy a ledger before it is changed, where that is due; why it could not be done, empty where it was not.

    Raises LedgerError where the ledger turns out to be damaged.
    """
    file = file_of(engine.url)
    if file is None:
        return ""
    with reading(engine) as connection:
        changes = connection.scalar(select(func.max(journal.c.number))) or 0
        if not (always or backups.is_due(file, changes)):
            return ""
    try:
        with closing(engine.raw_connection()) as ledger:
            backups.take(ledger.driver_connection, file, changes)  # type: ignore[arg-type]
    except (OSError, sqlite3.Error) as error:
        return f"no backup could be made in {backups.folder_of(file)} ({error})"
    return ""


def bring_up_to_date(engine: Engine) -> None:
    """Make a new ledger's tables, or upgrade an older one's, in one transaction; a current one costs a look.

    An older one is copied before. Raises LedgerError for a database that is not a ledger, one made by a newer
    fieldkit, or a file that is gone or empty while copies of it are kept.
    """
    _refuse_remains(file_of(engine.url))
    with reading(engine) as connection:
        version = _version(connection)
    if version == STEPS[-1]:
        return
    if version:
        keep_backup(engine, always=True)
    with writing(engine) as connection:
        if _version(connection) != STEPS[-1]:  # it may have been upgraded while we waited
            _upgrade(connection)


def _refuse_remains(file: Path | None) -> None:
    """Raises LedgerError where SQLite would begin anew in a file that has lost what it held."""
    if file is None or not file.parent.is_dir():
        return
    size = file.stat().st_size if file.exists() else 0
    if 0 < size < SMALLEST:
        raise LedgerError(f"{file}: the file is damaged (cut to {size} bytes); {backups.offer(file)}")
    if not size and backups.backups(file):
        raise LedgerError(f"{file}: the file is {'empty' if file.exists() else 'gone'}; {backups.offer(file)}")


def _version(connection: Connection) -> str | None:
    """The step a ledger is at; None for an empty database."""
    name = name_of(connection.engine.url)
    tables = inspect(connection)
    if tables.has_table("alembic_version"):
        version = connection.scalar(text("SELECT version_num FROM alembic_version"))
        if version in STEPS:
            return str(version)
        if version and re.match(r"m\d{3}_", version):
            if version[:4] > STEPS[-1][:4]:
                raise LedgerError(f"{name}: made by a newer fieldkit ({version}), expected {STEPS[-1]} or older")
            raise DamagedRow(f"found the version {version}, expected one of {', '.join(STEPS)}")
    elif not tables.get_table_names():
        return None
    raise LedgerError(f"{name}: holds another program's tables, expected a ledger or an empty database")


def _upgrade(connection: Connection) -> None:
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
