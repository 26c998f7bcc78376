"""The journal: what every command changed, as rows before and after, so that it can be taken back.

Undo and redo are changes too and stand in the journal themselves; which changes are in force follows from
reading it from the start. Nothing in it is ever altered.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import ColumnElement, Connection, Table, and_, delete, func, insert, select, update

from fieldkit.errors import LedgerError
from fieldkit.ledger.rows import Row
from fieldkit.ledger.tables import journal, metadata


@dataclass(frozen=True, slots=True)
class Change:
    """One entry of the journal; `undone` says whether it is out of force now."""

    number: int
    at: datetime
    command: str
    what: str
    undone: bool = False


@dataclass(frozen=True, slots=True)
class Image:
    """One row of one table, or its key and what changed, before and after; None where it was not there."""

    table: str
    before: Row | None
    after: Row | None

    def swapped(self) -> "Image":
        """The image of taking this change back."""
        return Image(self.table, self.after, self.before)


class Pen:
    """Changes rows and remembers how they were; `sign` enters it all in the journal."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.images: list[Image] = []

    def insert(self, table: Table, rows: Sequence[Row]) -> None:
        """Add rows."""
        if rows:
            self.connection.execute(insert(table), list(rows))
            self.images += [Image(table.name, None, row) for row in rows]

    def update(self, table: Table, key: Row, values: Row) -> None:
        """Change some columns of the row at a primary key."""
        changed = [table.c[name] for name in (*key, *values)]
        before = dict(self.connection.execute(select(*changed).where(_at(table, key))).mappings().one())
        self.connection.execute(update(table).where(_at(table, key)).values(**values))
        self.images.append(Image(table.name, before, key | values))

    def delete(self, table: Table, where: ColumnElement[bool]) -> None:
        """Take rows out."""
        gone = self.connection.execute(select(table).where(where)).mappings().all()
        self.connection.execute(delete(table).where(where))
        self.images += [Image(table.name, dict(row), None) for row in gone]

    def sign(self, command: str, what: str) -> None:
        """Enter the changes made so far in the journal as one command."""
        images = [[image.table, image.before, image.after] for image in self.images]
        _enter(self.connection, command=command, what=what, images=images)


def undo(connection: Connection) -> Change:
    """Take back the last change in force. Raises LedgerError when there is none."""
    done, _ = _standing(connection)
    if not done:
        raise LedgerError("nothing left to undo")
    change, images = _change(connection, done[-1])
    _apply(connection, [image.swapped() for image in reversed(images)])
    _enter(connection, command="undo", what=_named(change), target=change.number)
    return change


def redo(connection: Connection) -> Change:
    """Do again what was undone last. Raises LedgerError when nothing was, or something changed since."""
    _, undone = _standing(connection)
    if not undone:
        raise LedgerError("nothing left to redo")
    change, images = _change(connection, undone[-1])
    _apply(connection, images)
    _enter(connection, command="redo", what=_named(change), target=change.number)
    return change


def history(connection: Connection) -> list[Change]:
    """Every change, oldest first."""
    in_force = set(_standing(connection)[0])
    columns = (journal.c.number, journal.c.at, journal.c.command, journal.c.what, journal.c.target)
    return [
        Change(
            number=number,
            at=datetime.fromisoformat(at),
            command=command,
            what=what,
            undone=target is None and number not in in_force,
        )
        for number, at, command, what, target in connection.execute(select(*columns).order_by(journal.c.number))
    ]


def now() -> str:
    """The moment of a change, as ISO 8601 text in UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def _standing(connection: Connection) -> tuple[list[int], list[int]]:
    """Numbers of the changes in force, and of those a redo would bring back, the next one last."""
    done: list[int] = []
    undone: list[int] = []
    columns = (journal.c.number, journal.c.command, journal.c.target)
    for number, command, target in connection.execute(select(*columns).order_by(journal.c.number)):
        if target is None:
            done.append(number)
            undone.clear()
        elif command == "undo":
            undone.append(done.pop())
        else:
            done.append(undone.pop())
    return done, undone


def _change(connection: Connection, number: int) -> tuple[Change, list[Image]]:
    row = connection.execute(select(journal).where(journal.c.number == number)).one()
    images = [Image(table, before, after) for table, before, after in row.images]
    return Change(row.number, datetime.fromisoformat(row.at), row.command, row.what), images


def _named(change: Change) -> str:
    return f"{change.command}: {change.what}"


def _enter(connection: Connection, **values: Any) -> None:
    last = connection.scalar(select(func.max(journal.c.number))) or 0
    connection.execute(insert(journal).values(number=last + 1, at=now(), **values))


def _apply(connection: Connection, images: Iterable[Image]) -> None:
    for image in images:
        table = metadata.tables[image.table]
        if image.before is None:
            connection.execute(insert(table).values(**(image.after or {})))
        elif image.after is None:
            connection.execute(delete(table).where(_at(table, image.before)))
        else:
            connection.execute(update(table).where(_at(table, image.before)).values(**image.after))


def _at(table: Table, row: Row) -> ColumnElement[bool]:
    return and_(*(column == row[column.name] for column in table.primary_key))
