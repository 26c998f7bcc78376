"""Explain ledger errors in one line that a flyer can act on, and offer a backup if the file is damaged."""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from json import JSONDecodeError

from sqlalchemy import Engine
from sqlalchemy.exc import DBAPIError

from fieldkit.errors import LedgerError, UnusableLedger
from fieldkit.flight.storable import MAX_KEY_SIZE
from fieldkit.ledger import backups, soundness
from fieldkit.ledger.rows import DamagedRow
from fieldkit.ledger.schema import missing
from fieldkit.ledger.soundness import PATIENCE
from fieldkit.ledger.whereabouts import file_of, name_of

_SQLITE = {
    "SQLITE_NOTADB": "this file is not a ledger, expected a file made by fieldkit",
    "SQLITE_CORRUPT": "the file is damaged",
    "SQLITE_READONLY_DBMOVED": "the file was moved, removed or replaced; nothing was changed, open it again",
    "SQLITE_READONLY": "the ledger is read-only, expected a writable file and folder",
    "SQLITE_FULL": "the disk is full; nothing was changed, free some space and try again",
    "SQLITE_BUSY": f"another program has locked it for {PATIENCE:.0f} s, or its network folder does not support locks; "
    "nothing was changed, try again",
    "SQLITE_LOCKED": "another program has locked the ledger; nothing was changed, try again",
    "SQLITE_CANTOPEN": "cannot open the file, expected one in an existing, readable folder",
    "SQLITE_IOERR_READ": "the disk cannot be read; nothing was changed",
    "SQLITE_IOERR": "the disk failed; check `fieldkit history` for the change before trying again",
    "SQLITE_PERM": "no permission to use the file",
}

_SERVER = {
    "54000": f"names of a planned flight are too long for a server, expected at most {MAX_KEY_SIZE} bytes together; "
    "nothing was changed",
}
"""Reasons by PostgreSQL's codes; 54000 is a row that exceeds a limit, as that of an index on names, of which only a
planned flight can have longer ones."""
_GARBLED_TEXT_MESSAGES = ("Could not decode to UTF-8", "malformed JSON")
"""SQLite's messages, which have no code of their own, about invalid text."""


@contextmanager
def explained(engine: Engine) -> Iterator[None]:
    """Raise UnusableLedger for errors of the whole ledger that the flyer can fix, and LedgerError for those of one
    entry; bugs pass through unchanged."""
    try:
        yield
    except DBAPIError as error:
        if why := _reason(error) or _damage(engine):
            raise UnusableLedger(f"{name_of(engine.url)}: {why}{_offered(engine, why)}") from error
        raise
    except (DamagedRow, JSONDecodeError, UnicodeDecodeError, zlib.error) as error:
        why = f"the file is damaged ({error})"
        raise LedgerError(f"{name_of(engine.url)}: {why}{_offered(engine, why)}") from error
    except UnicodeEncodeError as error:
        raise LedgerError(f"found {error.object!r}, expected text in Unicode") from error
    except (TypeError, ValueError, LookupError) as error:  # from a damaged row
        if why := _damage(engine):
            raise UnusableLedger(f"{name_of(engine.url)}: {why}{_offered(engine, why)}") from error
        raise


def _reason(error: DBAPIError) -> str | None:
    """An error that the user can fix, or None if it is a bug or file damage."""
    code = getattr(error.orig, "sqlite_errorname", "")
    for start, why in _SQLITE.items():
        if code.startswith(start):
            return why
    message = " ".join(str(error.orig).split())
    if message.startswith(_GARBLED_TEXT_MESSAGES):
        return f"the file is damaged ({message})"
    state = getattr(error.orig, "sqlstate", None)
    if state in _SERVER:
        return _SERVER[state]
    refused = state in ("25006", "42501")  # read-only transaction, insufficient privilege
    if refused or (not code and (error.connection_invalidated or type(error).__name__ == "OperationalError")):
        return message
    return None


def _damage(engine: Engine) -> str | None:
    """What is wrong with a ledger's file, after an error that a sound file cannot cause."""
    file = file_of(engine.url)
    if file is None or not file.exists():
        return None
    fault = soundness.file_fault(file, thorough=True) or _missing(engine)
    return f"the file is damaged ({fault})" if fault else None


def _missing(engine: Engine) -> str:
    with engine.connect() as connection:
        return missing(connection)


def _offered(engine: Engine, why: str) -> str:
    """How to restore a damaged ledger, empty for other errors."""
    file = file_of(engine.url)
    is_damaged = why.startswith("the file is damaged") or (
        why == _SQLITE["SQLITE_NOTADB"] and file and backups.backups(file)
    )
    return f"; {backups.offer(file)}" if is_damaged and file else ""
