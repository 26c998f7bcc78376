"""The location of a ledger: a SQLite file or a database on a PostgreSQL server."""

import os
from pathlib import Path
from urllib.parse import unquote

from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError

from fieldkit.errors import LedgerError
from fieldkit.paths import data_file, expanded, ledger_trouble

_DRIVERS = {"sqlite": "sqlite", "postgresql": "postgresql+psycopg", "postgres": "postgresql+psycopg"}

FILE_MODES = ("ro", "rw", "rwc")
"""Modes in which SQLite may open a file, in its URL syntax."""


def location(where: str | Path | None) -> URL:
    """The URL of a ledger named by a path or URL, by FIELDKIT_LEDGER, or the one in the user's data folder.

    Raises LedgerError for an empty name, for a URL that is neither SQLite's nor PostgreSQL's, and for a file that
    SQLite must not open.
    """
    if where is None:
        where = os.environ.get("FIELDKIT_LEDGER") or data_file("ledger.db")
    if not str(where).strip():
        raise LedgerError(f"found the ledger {str(where)!r}, expected a path or a URL such as sqlite:///FILE")
    if isinstance(where, Path) or "://" not in where:
        return _keeping(URL.create("sqlite", database=str(expanded(where))), str(where))
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
    """A SQLite URL. Raises LedgerError for one that stores nothing, or that has options a ledger does not need.

    The only option supported is the mode: a ledger may be opened read-only.
    """
    uri = url.query.get("uri") == "true"
    file = str(url.database or "").removeprefix("file:" if uri else "")
    if not file or file.startswith(":") or url.query.get("mode") == "memory":
        raise LedgerError(f"found the ledger {where!r}, which would store nothing, expected sqlite:///FILE")
    modes = {"uri", "mode"} if uri else set()
    if not set(url.query) <= modes or url.query.get("mode", "rwc") not in FILE_MODES or "?" in file:
        raise LedgerError(f"found the ledger {where!r}, expected sqlite:///FILE and nothing after it")
    place = Path(unquote(file) if uri else file)
    if trouble := ledger_trouble(place) or ledger_trouble(place.resolve()):
        raise LedgerError(f"{place}: {trouble}")
    return url


def name_of(url: URL) -> str:
    """The name of a ledger for messages: its path, or its URL without the password."""
    return str(url.database) if url.drivername == "sqlite" and url.database else url.render_as_string()


def file_of(url: URL) -> Path | None:
    """The file of a ledger, None for one in memory, on a server, or opened by a SQLite URL.

    For a link, it is the file that the link points to: SQLite's journal and the backups are next to that file.
    """
    if url.get_backend_name() != "sqlite" or not url.database or "uri" in url.query:
        return None
    file = Path(str(url.database))
    return file.resolve() if file.is_symlink() else file
