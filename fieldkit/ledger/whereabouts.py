"""Where a ledger is: a file of SQLite, or a database on a PostgreSQL server."""

import os
from pathlib import Path

from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError

from fieldkit.errors import LedgerError
from fieldkit.paths import data_file

_DRIVERS = {"sqlite": "sqlite", "postgresql": "postgresql+psycopg", "postgres": "postgresql+psycopg"}

FILE_MODES = ("ro", "rw", "rwc")
"""How SQLite may open a file, in a URL of its own."""


def location(where: str | Path | None) -> URL:
    """The URL of a ledger named by a path or URL, by FIELDKIT_LEDGER, or the one in the user's data folder.

    Raises LedgerError for a URL that is neither SQLite's nor PostgreSQL's.
    """
    where = where or os.environ.get("FIELDKIT_LEDGER") or data_file("ledger.db")
    if isinstance(where, Path) or "://" not in where:
        return _keeping(URL.create("sqlite", database=str(Path(where).expanduser())), str(where))
    try:
        url = make_url(where)
    except ArgumentError:
        raise LedgerError(f"found the ledger {where!r}, expected a path or a URL such as sqlite:///FILE") from None
    dialect = url.get_backend_name()
    if dialect not in _DRIVERS:
        raise LedgerError(f"found a ledger on {dialect}, expected sqlite or postgresql")
    if dialect == "sqlite":
        url = _keeping(url, where)
    return url if "+" in url.drivername else url.set(drivername=_DRIVERS[dialect])


def _keeping(url: URL, where: str) -> URL:
    """A URL of SQLite itself. Raises LedgerError for one that keeps nothing, or asks for what a ledger does not need.

    Of what SQLite takes in a URL of its own there is the mode: a ledger may be opened to be read alone.
    """
    uri = url.query.get("uri") == "true"
    file = str(url.database or "").removeprefix("file:" if uri else "")
    if not file or file.startswith(":") or url.query.get("mode") == "memory":
        raise LedgerError(f"found the ledger {where!r}, which would store nothing, expected sqlite:///FILE")
    modes = {"uri", "mode"} if uri else set()
    if not set(url.query) <= modes or url.query.get("mode", "rwc") not in FILE_MODES or "?" in file:
        raise LedgerError(f"found the ledger {where!r}, expected sqlite:///FILE and nothing after it")
    return url


def name_of(url: URL) -> str:
    """A ledger's name for messages: its path, or its URL without the password."""
    return str(url.database) if url.drivername == "sqlite" and url.database else url.render_as_string()


def file_of(url: URL) -> Path | None:
    """The file of a ledger, None for one in memory, on a server, or opened by a URL of SQLite's own.

    Of a link it is the file that the link names: there SQLite keeps its journal, and backups are kept.
    """
    if url.get_backend_name() != "sqlite" or not url.database or "uri" in url.query:
        return None
    file = Path(str(url.database))
    return file.resolve() if file.is_symlink() else file
