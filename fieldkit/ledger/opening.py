"""Open and upgrade a ledger, on SQLite or PostgreSQL.

SQLite uses its rollback journal and `synchronous=EXTRA`: a finished command survives a power failure, and the ledger is
a single file that can be copied at any time, which a separate write-ahead log would not allow.
"""

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from sqlalchemy import Connection, Engine, create_engine, event, func, select
from sqlalchemy.engine import URL
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError
from sqlalchemy.pool import ConnectionPoolEntry

from fieldkit.errors import LedgerError, UnusableLedger
from fieldkit.ledger import backups
from fieldkit.ledger.checksums import as_json
from fieldkit.ledger.schema import STEPS, check_objects, upgrade, version
from fieldkit.ledger.soundness import PATIENCE
from fieldkit.ledger.tables import journal
from fieldkit.ledger.trouble import explained
from fieldkit.ledger.whereabouts import file_of, name_of
from fieldkit.quantities import counted

MIN_DATABASE_SIZE = 512
"""Minimum size of a SQLite database with content; SQLite treats a smaller file as empty. [byte]"""

SYNCHRONOUS_MODE = "EXTRA"
"""SQLite's setting with which a finished command survives a power failure."""
_LOCK = 0x666B  # any number that no other program on the server is likely to use


def connect(url: URL) -> Engine:
    """An engine whose connections write durably; does not open the file yet. Raises LedgerError."""
    sqlite = url.get_backend_name() == "sqlite"
    try:
        engine = create_engine(url, connect_args={"timeout": PATIENCE} if sqlite else {}, json_serializer=as_json)
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
    connection.isolation_level = None  # type: ignore[attr-defined]  # transactions are started below
    for setting in ("foreign_keys = ON", f"synchronous = {SYNCHRONOUS_MODE}", "trusted_schema = OFF"):
        connection.execute(f"PRAGMA {setting}")  # type: ignore[attr-defined]


def _begin_sqlite(connection: Connection) -> None:
    writes = connection.get_execution_options().get("writes")
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _begin_server(connection: Connection) -> None:
    """Begin a transaction: a writer waits for the others and sees what they wrote; all statements of a reader see the
    same state."""
    if connection.get_execution_options().get("writes"):
        connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_LOCK})")
    else:
        connection.exec_driver_sql("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ")


@contextmanager
def reading(engine: Engine) -> Iterator[Connection]:
    """A connection that reads one consistent state of the ledger. Raises LedgerError."""
    with explained(engine), engine.connect() as connection:
        yield connection


@contextmanager
def writing(engine: Engine, *, keep: bool = True) -> Iterator[Connection]:
    """A connection whose changes are all committed, or none; one writer at a time. Raises LedgerError."""
    with explained(engine), engine.execution_options(writes=True).connect() as connection:
        yield connection
        if keep:
            try:
                connection.commit()
            except DBAPIError:
                connection.invalidate()  # SQLAlchemy would keep it with its transaction open, and the ledger locked
                raise


def keep_backup(engine: Engine, *, always: bool = False) -> str:
    """Back up a ledger before a change, if a backup is due. Returns the reason if it failed, otherwise empty.

    Raises LedgerError if the ledger turns out to be damaged.
    """
    file = file_of(engine.url)
    if file is None:
        return ""
    with reading(engine) as connection:
        changes = connection.scalar(select(func.max(journal.c.number))) or 0
    try:
        if always or (backups.is_due(file, changes) and not backups.being_made(file)):
            with closing(engine.raw_connection()) as ledger:
                backups.take(ledger.driver_connection, file, changes)  # type: ignore[arg-type]
    except (OSError, sqlite3.Error) as error:
        return f"no backup could be made in {backups.folder_of(file)} ({error})"
    return ""


def bring_up_to_date(engine: Engine) -> None:
    """Create the tables of a new ledger, or upgrade those of an older one, in one transaction; for a current one this
    is a quick check.

    An older ledger is backed up first. Raises LedgerError for a database that is not a ledger, a ledger made by a newer
    fieldkit, or a missing or empty file that has backups.
    """
    _refuse_remains(file_of(engine.url))
    with reading(engine) as connection:
        check_objects(connection)
        step = version(connection)
    if step == STEPS[-1]:
        return
    if step:
        keep_backup(engine, always=True)
    with writing(engine) as connection:
        if version(connection) != STEPS[-1]:  # another process may have upgraded it while we waited
            upgrade(connection)


def never_recreate(engine: Engine) -> None:
    """Report a missing file from now on, instead of letting SQLite create an empty one."""
    file = file_of(engine.url)
    if file is None:
        return

    def there(*_: object) -> None:
        if not file.exists() or not file.stat().st_size:
            state = "gone" if not file.exists() else "empty"
            raise UnusableLedger(f"{file}: the file is {state} while it is open; {backups.offer(file)}")

    event.listen(engine, "do_connect", there)


def _refuse_remains(file: Path | None) -> None:
    """Raise LedgerError for a folder or a device, and if SQLite would start an empty database in a file that has lost
    its content."""
    if file is None or not file.parent.is_dir():
        return
    if file.exists() and not file.is_file():
        raise LedgerError(f"{file}: found a folder or a device, expected a file")
    size = file.stat().st_size if file.exists() else 0
    if 0 < size < MIN_DATABASE_SIZE:
        raise LedgerError(f"{file}: the file is damaged (cut to {counted(size, 'byte')}); {backups.offer(file)}")
    if not size and backups.backups(file):
        raise LedgerError(f"{file}: the file is {'empty' if file.exists() else 'gone'}; {backups.offer(file)}")
