"""An open ledger: read one consistent state, or change it completely or not at all."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from types import TracebackType
from typing import TypeVar

from sqlalchemy import Connection, Engine

from fieldkit.ledger import opening, whereabouts
from fieldkit.ledger.journal import ChangeRecorder

Kind = TypeVar("Kind", bound="OpenLedger")


class OpenLedger:
    """Base class of the parts of a ledger; use it in a `with` statement."""

    def __init__(self, engine: Engine, name: str) -> None:
        self._engine = engine
        self.name = name
        self.trouble = ""
        """Why the backup before a change failed, empty if it did not; the change was made anyway."""
        self.remarks: list[str] = []
        """Remarks on the ledger's flights for the user, one line each, in the order found."""
        self.own_changes: set[int] = set()
        """Numbers of the changes made through this object."""

    @classmethod
    def open(cls: type[Kind], where: str | Path | None = None) -> Kind:
        """Open the ledger at a path or URL; create or upgrade it if needed.

        None means FIELDKIT_LEDGER, or the file in the user's data folder. Raises LedgerError.
        """
        url = whereabouts.location(where)
        engine = opening.connect(url)
        try:
            opening.bring_up_to_date(engine)
            opening.never_recreate(engine)
        except BaseException:
            engine.dispose()
            raise
        return cls(engine, whereabouts.name_of(url))

    def __enter__(self: Kind) -> Kind:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def remark(self, *lines: str) -> None:
        """Add a remark on the flights, once."""
        self.remarks += [line for line in dict.fromkeys(lines) if line not in self.remarks]

    def close(self) -> None:
        """Close the file or the connection."""
        self._engine.dispose()

    def _reading(self) -> AbstractContextManager[Connection]:
        return opening.reading(self._engine)

    @contextmanager
    def _writing(self, *, keep: bool = True) -> Iterator[Connection]:
        missed = opening.keep_backup(self._engine) if keep else ""
        with opening.writing(self._engine, keep=keep) as connection:
            yield connection
        self.trouble = missed or self.trouble

    @contextmanager
    def _changing(self, *, keep: bool = True) -> Iterator[ChangeRecorder]:
        with self._writing(keep=keep) as connection:
            recorder = ChangeRecorder(connection)
            yield recorder
        if keep and recorder.number is not None:
            self.own_changes.add(recorder.number)
