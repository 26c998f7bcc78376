"""The journal: what every command changed, as rows before and after, for undo.

Undo and redo are journal entries too; which changes are in effect follows from reading the journal from the start.
Entries are never modified.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import ColumnElement, Connection, Table, and_, delete, func, insert, select, update

from fieldkit.errors import LedgerError
from fieldkit.ledger import checksums
from fieldkit.ledger.checksums import CHECKSUM
from fieldkit.ledger.rows import Row
from fieldkit.ledger.tables import MAX_ROWS_BY_NAME, drafts, flights, journal, metadata, predictions, tags


@dataclass(frozen=True, slots=True)
class Change:
    """One entry of the journal; `undone` is whether it is currently undone."""

    number: int
    at: datetime
    command: str
    what: str
    undone: bool = False


@dataclass(frozen=True, slots=True)
class UndoStep:
    """The change that undo would undo, the number of flights that it would remove, and whether it was made through this
    open ledger, not by another program or in an earlier session."""

    change: Change
    flights: int
    own: bool = False


@dataclass(frozen=True, slots=True)
class Image:
    """A row of a table before and after a change, or its key and the changed columns; None if it did not exist."""

    table: str
    before: Row | None
    after: Row | None

    def swapped(self) -> "Image":
        """The image that undoes this change."""
        return Image(self.table, self.after, self.before)


Key = tuple[Any, ...]
"""A primary key."""


class ChangeRecorder:
    """Changes rows and records their previous state; `sign` writes all of it to the journal."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.number: int | None = None
        """The number of its entry in the journal, once it is signed."""
        self._images = checksums.JsonList()
        self._unsealed: dict[Table, set[Key]] = {}

    @property
    def has_changes(self) -> bool:
        """Whether a row was changed."""
        return bool(self._images)

    def insert(self, table: Table, rows: Sequence[Row]) -> None:
        """Add rows; a column that a row lacks is empty."""
        empty = dict.fromkeys(name for row in rows for name in row)
        for start in range(0, len(rows), MAX_ROWS_BY_NAME):
            self.connection.execute(insert(table), [empty | row for row in rows[start : start + MAX_ROWS_BY_NAME]])
        self._record(Image(table.name, None, row) for row in rows)

    def update(self, table: Table, key: Row, values: Row) -> None:
        """Change some columns of the row with a primary key."""
        changed = [table.c[name] for name in (*key, *values)]
        before = dict(self.connection.execute(select(*changed).where(_at(table, key))).mappings().one())
        self.connection.execute(update(table).where(_at(table, key)).values(**values))
        self._record([Image(table.name, before, key | values)])

    def delete(self, table: Table, where: ColumnElement[bool]) -> None:
        """Delete rows."""
        gone = self.connection.execute(select(table).where(where)).mappings().all()
        self.connection.execute(delete(table).where(where))
        self._record(Image(table.name, _without_checksum(dict(row)), None) for row in gone)

    def _record(self, images: Iterable[Image]) -> None:
        images = list(images)
        for table, keys in _keys_by_table(images).items():
            self._unsealed.setdefault(table, set()).update(keys)
        self._images.extend([one.table, one.before, one.after] for one in images)

    def seal(self) -> None:
        """Update the checksums of the rows changed since the last time."""
        while self._unsealed:
            checksums.seal(self.connection, *self._unsealed.popitem())

    def sign(self, command: str, what: str) -> None:
        """Update the checksums of the rows changed so far, and enter the changes in the journal as one command."""
        self.seal()
        total = self._images.checksum
        self.number = _enter(
            self.connection, command=command, what=what, images=self._images.close(), images_checksum=total
        )


def undo_step(connection: Connection) -> UndoStep:
    """What `undo` would undo. Raises LedgerError if there is nothing."""
    done, _ = _done_and_undone(connection)
    if not done:
        raise LedgerError("nothing left to undo")
    change, images = _whole(connection, done[-1])
    return UndoStep(change, sum(image.before is None for image in images if image.table == flights.name))


def undo(connection: Connection, number: int | None = None) -> Change:
    """Undo the last change in effect. Raises LedgerError if there is none, or if it does not have this number."""
    done, _ = _done_and_undone(connection)
    if not done:
        raise LedgerError("nothing left to undo")
    if number not in (None, done[-1]):
        raise LedgerError("nothing undone: another program has changed the ledger meanwhile")
    change, images = _whole(connection, done[-1])
    _apply(connection, [image.swapped() for image in reversed(images)])
    _enter(connection, command="undo", what=_named(change), target=change.number)
    return change


def redo(connection: Connection) -> Change:
    """Redo the last undone change. Raises LedgerError if there is none, or if something changed since."""
    _, undone = _done_and_undone(connection)
    if not undone:
        raise LedgerError("nothing left to redo")
    change, images = _whole(connection, undone[-1])
    _apply(connection, images)
    _enter(connection, command="redo", what=_named(change), target=change.number)
    return change


def history(connection: Connection) -> list[Change]:
    """Every change, oldest first."""
    in_force = set(_done_and_undone(connection)[0])
    return [
        _change(row, undone=row["target"] is None and row["number"] not in in_force) for row in _entries(connection)
    ]


def length(connection: Connection) -> int:
    """Number of entries; entry numbers start at 1."""
    return connection.scalar(select(func.max(journal.c.number))) or 0


def now() -> str:
    """The time of a change, as ISO 8601 text in UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def _done_and_undone(connection: Connection) -> tuple[list[int], list[int]]:
    """Numbers of the changes in effect, and of those that redo would restore, the next one last."""
    done: list[int] = []
    undone: list[int] = []
    for row in _entries(connection):
        number, target = row["number"], row["target"]
        if target is None:
            done.append(number)
            undone.clear()
        elif row["command"] == "undo":
            undone.append(done.pop())
        else:
            done.append(undone.pop())
    return done, undone


def _entries(connection: Connection) -> list[Row]:
    """Every entry without its images, oldest first. Raises DamagedRow."""
    columns = [column for column in journal.c if column is not journal.c.images]
    return checksums.sound_rows(connection, select(*columns).order_by(journal.c.number))


def _change(row: Row, *, undone: bool = False) -> Change:
    return Change(row["number"], datetime.fromisoformat(row["at"]), row["command"], row["what"], undone)


def _whole(connection: Connection, number: int) -> tuple[Change, list[Image]]:
    """An entry and its images. Raises DamagedRow."""
    (row,) = checksums.sound_rows(connection, select(journal).where(journal.c.number == number))
    return _change(row), [Image(*image) for image in row["images"]]


def _named(change: Change) -> str:
    return f"{change.command}: {change.what}"


def _enter(connection: Connection, **values: Any) -> int:
    """Add an entry; returns its number."""
    row = {"number": length(connection) + 1, "at": now(), **values}
    connection.execute(insert(journal).values(row | {CHECKSUM: checksums.checksum(row)}))
    return int(row["number"])


def _keys_by_table(images: Iterable[Image]) -> dict[Table, set[Key]]:
    """Primary keys of the changed rows that have a checksum; tags count as part of their flight's row."""
    keys: dict[Table, set[Key]] = {}
    for image in images:
        table = flights if image.table == tags.name else metadata.tables[image.table]
        row = image.before if image.after is None else image.after
        keys.setdefault(table, set()).add(tuple((row or {})[column.name] for column in table.primary_key))
    return keys


def _without_checksum(row: Row) -> Row:
    return {name: value for name, value in row.items() if name != CHECKSUM}


def _apply(connection: Connection, images: Collection[Image]) -> None:
    """Apply changes after checking the rows, and update their checksums. Raises DamagedRow."""
    keys_by_table = _keys_by_table(images)
    for table, keys in keys_by_table.items():
        checksums.check(connection, table, keys)
    _change_rows(connection, images)
    for table, keys in keys_by_table.items():
        checksums.seal(connection, table, keys)


def _change_rows(connection: Connection, images: Iterable[Image]) -> None:
    for image in images:
        table = metadata.tables[image.table]
        if image.before is None:
            exists = table in (drafts, predictions) and _exists(connection, table, image.after or {})
            if exists and table is predictions:
                raise LedgerError("a newer forecast exists, so this one cannot be restored; run the forecast again")
            if not exists:
                connection.execute(insert(table).values(**(image.after or {})))
        elif image.after is None:
            connection.execute(delete(table).where(_at(table, image.before)))
        else:
            connection.execute(update(table).where(_at(table, image.before)).values(**image.after))


def _exists(connection: Connection, table: Table, row: Row) -> bool:
    """Whether a row exists already, such as a draft that was saved again in the meantime."""
    return connection.scalar(select(func.count()).select_from(table).where(_at(table, row))) == 1


def _at(table: Table, row: Row) -> ColumnElement[bool]:
    return and_(*(column == row[column.name] for column in table.primary_key))
