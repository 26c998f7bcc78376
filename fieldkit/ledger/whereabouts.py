"""Where a ledger is: a file of SQLite, or a database on a PostgreSQL server."""

import os
from pathlib import Path

from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError

from fieldkit.errors import LedgerError
from fieldkit.paths import data_folder

_DRIVERS = {"sqlite": "sqlite", "postgresql": "postgresql+psycopg", "postgres": "postgresql+psycopg"}


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
    if dialect == "sqlite" and url.database in (None, "", ":memory:"):
        raise LedgerError(f"found the ledger {where!r}, which would store nothing, expected sqlite:///FILE")
    return url if "+" in url.drivername else url.set(drivername=_DRIVERS[dialect])


def name_of(url: URL) -> str:
    """A ledger's name for messages: its path, or its URL without the password."""
    return str(url.database) if url.drivername == "sqlite" and url.database else url.render_as_string()


def file_of(url: URL) -> Path | None:
    """The file of a ledger, None for one in memory, on a server, or opened by a URL of SQLite's own.

    Of a link it is the file that the link names: there SQLite keeps its journal, and backups are kept.
    """
    plain = url.get_backend_name() == "sqlite" and url.database and not url.database.startswith((":", "file:"))
    if not plain:
        return None
    file = Path(str(url.database))
    return file.resolve() if file.is_symlink() else file
