"""The state of the ledger before a flight was added: reads the journal backward in memory and changes nothing."""

import sys
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from sqlalchemy import Connection, Table, select

from fieldkit.flight import Flight
from fieldkit.ledger.checksums import sound_flights, sound_rows
from fieldkit.ledger.journal import Image
from fieldkit.ledger.records import Past
from fieldkit.ledger.rows import Row, flight_of
from fieldkit.ledger.tables import MAX_ROWS_BY_NAME, active_versions, flights, journal, metadata, tags

TableRows = dict[str, dict[tuple[Any, ...], Row]]
"""The rows of each table by their primary key."""


def before(connection: Connection, wanted: Sequence[Flight]) -> list[Past]:
    """The state of each flight's rocket just before the flight was added; the current state if it never was.

    Reads only the changes since then, and the rows that they or these rockets have: of 100,000 flights most are old.
    """
    entries = [_entry(connection, one) for one in wanted]
    changes = _Changes(connection)
    moments = changes.added(entry for entry in entries if entry is not None)
    rows = _rows(connection, {one.rocket for one in wanted}, changes.read)
    latest_first = sorted((moments[entry], n) for n, entry in enumerate(entries) if entry in moments)
    found = {n: _past(rows, wanted[n].rocket) for n, entry in enumerate(entries) if entry not in moments}
    for number, images in changes.read:
        for image in reversed(images):
            _apply(rows, image.swapped())
        while latest_first and latest_first[-1][0] == number:
            _, n = latest_first.pop()
            found[n] = _past(rows, wanted[n].rocket)
    return [found[n] for n in range(len(wanted))]


def _entry(connection: Connection, flight: Flight) -> int | None:
    """The entry number of a flight in the ledger."""
    names = flights.c.rocket == flight.rocket, flights.c.flight_id == flight.flight_id
    entry: int | None = connection.scalar(select(flights.c.entry).where(*names))
    return entry


class _Changes:
    """The changes in the journal, the latest first; `read` has those read so far, each with its images."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self.read: list[tuple[int, list[Image]]] = []

    def added(self, entries: Iterable[int]) -> dict[int, int]:
        """The change that last added each of these flights, by entry number, as far as there is one; undoing a removal
        does not count."""
        before = dict.fromkeys(entries, sys.maxsize)  # the change that added an entry has a lower number than this
        found: dict[int, int] = {}
        every = select(journal.c.number, journal.c.command, journal.c.target).order_by(journal.c.number.desc())
        for number, command, target in self._connection.execute(every).all() if before else ():
            images = self._images(number if target is None else target)
            self.read.append((number, [one.swapped() for one in reversed(images)] if command == "undo" else images))
            for entry in _entries(self.read[-1][1], added=True) & before.keys():
                if number < before[entry]:
                    if target is not None and entry in _entries(images, added=False):
                        before[entry] = target
                    else:
                        found[entry] = number
                        del before[entry]
            if not before:
                break
        return found

    def _images(self, number: int) -> list[Image]:
        """The images of a change that is not an undo or a redo."""
        (row,) = sound_rows(self._connection, select(journal).where(journal.c.number == number))
        return [Image(*image) for image in row["images"]]


def _entries(images: Iterable[Image], *, added: bool) -> set[int]:
    """The entry numbers of the flights that a change adds, or removes."""
    own = (one if added else one.swapped() for one in images if one.table == flights.name)
    return {one.after["entry"] for one in own if one.before is None and one.after}


def _rows(
    connection: Connection, rockets: Collection[str], changes: Iterable[tuple[int, Iterable[Image]]]
) -> TableRows:
    """The present rows of some rockets, and those that changes touch."""
    images = [image for _, some in changes for image in some if image.table in (flights.name, tags.name)]
    touched = {row["entry"] for image in images for row in (image.before, image.after) if row}
    own = set(connection.scalars(select(flights.c.entry).where(flights.c.rocket.in_(rockets))))
    entries = sorted(touched | own)
    some = [entries[start : start + MAX_ROWS_BY_NAME] for start in range(0, len(entries), MAX_ROWS_BY_NAME)]
    tables: dict[Table, list[Row]] = {
        flights: [
            row for part in some for row in sound_flights(connection, select(flights).where(flights.c.entry.in_(part)))
        ],
        tags: [
            dict(row)
            for part in some
            for row in connection.execute(select(tags).where(tags.c.entry.in_(part))).mappings()
        ],
        active_versions: sound_rows(connection, select(active_versions)),
    }
    return {table.name: {_key(table.name, row): row for row in rows} for table, rows in tables.items()}


def _key(table: str, row: Any) -> tuple[Any, ...]:
    return tuple(row[column.name] for column in metadata.tables[table].primary_key)


def _apply(rows: TableRows, image: Image) -> None:
    present = rows.get(image.table)
    if present is None:
        return
    if image.after is None:
        present.pop(_key(image.table, image.before), None)
        return
    key = _key(image.table, image.after)
    present[key] = image.after if image.before is None else present[key] | image.after


def _past(rows: TableRows, rocket: str) -> Past:
    own = [row for row in rows["flights"].values() if row["rocket"] == rocket]
    own.sort(key=lambda row: (row["date_time"] is None, row["date_time"] or "", row["entry"]))
    labels: dict[int, list[str]] = {row["entry"]: [] for row in own}
    for (entry, _), row in sorted(rows["tags"].items()):
        if entry in labels:
            labels[entry].append(row["tag"])
    used = rows["active_versions"].get((rocket,))
    return Past(tuple(flight_of(row, labels[row["entry"]]) for row in own), used["number"] if used else 0)
