"""A checksum in every row with user data: SQLite stores none, so a flipped bit would go unnoticed.

It covers all columns of a row, and for a flight also its tags. Empty columns do not count, so columns added by a newer
schema leave it unchanged. It is updated in the transaction that changes the row, and checked whenever the row is read.
"""

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from zlib import crc32

from sqlalchemy import Column, ColumnElement, Connection, Select, Table, bindparam, select, tuple_, update

from fieldkit.ledger.rows import DamagedRow, Row
from fieldkit.ledger.tables import MAX_ROWS_BY_NAME, flights, tags

CHECKSUM = "checksum"
"""Name of the checksum column."""
_AS_JSON = json.JSONEncoder(sort_keys=True).encode
_WITHOUT_SPACES = json.JSONEncoder(separators=(",", ":")).encode
SEPARATE_COLUMN = "images"
"""A long column that is usually not read, with its own checksum in `images_checksum`."""


def checksum(row: Mapping[str, Any]) -> int:
    """Checksum of a row. [1]"""
    return checksum_of(
        {name: row[name] for name in row if row[name] is not None and name not in (CHECKSUM, SEPARATE_COLUMN)}
    )


def checksum_of(document: Any) -> int:
    """CRC-32 of a document as JSON; a list, which may be that of a long import, is written element by element. [1]"""
    if not isinstance(document, list):
        return crc32(_AS_JSON(document).encode())
    written = JsonList()
    for element in document:
        written.add_sum(element)
    return written.checksum


@dataclass(frozen=True, slots=True)
class JsonText:
    """A document that is written as JSON already; the database stores its text."""

    text: str


def as_json(document: Any) -> str:
    """What the database stores of a document."""
    return document.text if isinstance(document, JsonText) else json.dumps(document)


class JsonList:
    """A list that is written as JSON while it is made: that of a long import takes half the memory of the rows."""

    def __init__(self) -> None:
        self._text = bytearray(b"[")
        self._sum = crc32(b"[")
        self._separated = False

    def __bool__(self) -> bool:
        return len(self._text) > 1

    @property
    def checksum(self) -> int:
        """As `checksum_of` the list. [1]"""
        return crc32(b"]", self._sum)

    def add_sum(self, element: Any) -> None:
        """Count an element in the checksum only."""
        self._sum = crc32((", " * self._separated + _AS_JSON(element)).encode(), self._sum)
        self._separated = True

    def extend(self, elements: Iterable[Any]) -> None:
        """Add elements, which are not kept."""
        texts = []
        for one in elements:
            self.add_sum(one)
            texts.append(_WITHOUT_SPACES(one))
        if texts:
            self._text += ("," * bool(self) + ",".join(texts)).encode()

    def close(self) -> JsonText:
        """The whole list as JSON; it is released here."""
        self._text += b"]"
        whole, self._text = self._text, bytearray(b"[")
        return JsonText(whole.decode())


def checked(row: Row) -> Row:
    """Return the row. Raises DamagedRow if it does not match its checksum."""
    try:
        sound = row[CHECKSUM] == checksum(row)
        if sound and row.get(SEPARATE_COLUMN) is not None:
            sound = row[f"{SEPARATE_COLUMN}_checksum"] == checksum_of(row[SEPARATE_COLUMN])
    except TypeError:  # damage has turned a text into bytes
        sound = False
    if not sound:
        name = " of ".join(str(row[key]) for key in ("flight_id", "number", "config", "rocket") if row.get(key))
        raise DamagedRow(f"a row of {name} does not match its checksum")
    return row


def seal(connection: Connection, table: Table, keys: Collection[tuple[Any, ...]]) -> None:
    """Update the checksums of the existing rows with these primary keys."""
    at = [column == bindparam(f"at_{column.name}") for column in table.primary_key]
    change = update(table).where(*at).values({CHECKSUM: bindparam("sum")})
    for rows in _rows_at(connection, table, keys):
        places = ({f"at_{one.name}": row[one.name] for one in table.primary_key} for row in rows)
        if sums := [place | {"sum": checksum(row)} for place, row in zip(places, rows, strict=True)]:
            connection.execute(change, sums)


def check(
    connection: Connection,
    table: Table,
    keys: Collection[tuple[Any, ...]],
    columns: Sequence[Column[Any]] | None = None,
) -> None:
    """Check the rows with these primary keys. Raises DamagedRow if one does not match its checksum.

    `columns` are the columns that the table has, which are fewer in an older schema.
    """
    for rows in _rows_at(connection, table, keys, columns):
        for row in rows:
            checked(row)


def sound_rows(connection: Connection, query: Select[Any]) -> list[Row]:
    """The rows of one table that a query selects. Raises DamagedRow."""
    return [checked(row) for row in _rows(connection, query)]


def sound_flights(connection: Connection, query: Select[Any]) -> list[Row]:
    """The flight rows that a query selects, each with its `tags` in order. Raises DamagedRow."""
    return [checked(row) for row in _with_tags(connection, query)]


def _rows_at(
    connection: Connection,
    table: Table,
    keys: Collection[tuple[Any, ...]],
    columns: Sequence[Column[Any]] | None = None,
) -> Iterator[list[Row]]:
    """The rows with these primary keys, some at a time."""
    read = _with_tags if table is flights else _rows
    some, query = list(keys), select(*(columns or table.columns))
    for start in range(0, len(some), MAX_ROWS_BY_NAME):
        yield read(connection, query.where(_among(table, some[start : start + MAX_ROWS_BY_NAME])))


def _among(table: Table, keys: Collection[tuple[Any, ...]]) -> ColumnElement[bool]:
    columns = list(table.primary_key)
    return tuple_(*columns).in_(keys) if len(columns) > 1 else columns[0].in_([key for (key,) in keys])


def _rows(connection: Connection, query: Select[Any]) -> list[Row]:
    columns = query.selected_columns.keys()
    return [dict(zip(columns, row, strict=True)) for row in connection.execute(query)]


def _with_tags(connection: Connection, query: Select[Any]) -> list[Row]:
    found = _rows(connection, query)
    labels: dict[int, list[str]] = {row["entry"]: [] for row in found}
    for label in connection.execute(_labels(labels)):
        if label.entry in labels:
            labels[label.entry].append(label.tag)
    for row in found:
        row["tags"] = labels[row["entry"]]
    return found


def _labels(entries: Collection[int]) -> Select[Any]:
    """A query for the tags of these flights, or of more flights if there are many."""
    query = select(tags).order_by(tags.c.entry, tags.c.position)
    return query.where(tags.c.entry.in_(entries)) if len(entries) <= MAX_ROWS_BY_NAME else query
