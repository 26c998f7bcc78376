"""The state of the ledger before a flight was added: reads the journal backward in memory and changes nothing."""

from collections.abc import Iterator, Sequence
from typing import Any

from sqlalchemy import Connection, Table, select

from fieldkit.flight import Flight
from fieldkit.ledger.checksums import sound_flights, sound_rows
from fieldkit.ledger.journal import Image
from fieldkit.ledger.records import Past
from fieldkit.ledger.rows import Row, flight_of
from fieldkit.ledger.tables import active_versions, flights, journal, metadata, tags

TableRows = dict[str, dict[tuple[Any, ...], Row]]
"""The rows of each table by their primary key."""


def before(connection: Connection, wanted: Sequence[Flight]) -> list[Past]:
    """The state of each flight's rocket just before the flight was added; the current state if it never was."""
    changes = list(_changes(connection))
    changes_by_entry = _incoming_flights(changes)
    rows = _rows(connection)
    entries = {(row["rocket"], row["flight_id"]): row["entry"] for row in rows["flights"].values()}
    moments = {n: changes_by_entry.get(entries.get((one.rocket, one.flight_id), 0)) for n, one in enumerate(wanted)}
    found = {n: _past(rows, wanted[n].rocket) for n, moment in moments.items() if moment is None}
    latest_first = sorted((moment, n) for n, moment in moments.items() if moment is not None)
    for number, images, _ in reversed(changes):
        if not latest_first:
            break
        for image in reversed(images):
            _apply(rows, image.swapped())
        while latest_first and latest_first[-1][0] == number:
            _, n = latest_first.pop()
            found[n] = _past(rows, wanted[n].rocket)
    return [found[n] for n in range(len(wanted))]


def _changes(connection: Connection) -> Iterator[tuple[int, list[Image], int | None]]:
    """The images of every journal entry and the change that it undoes, if any, oldest first; an undo has the images of
    its target, reversed."""
    known: dict[int, list[Image]] = {}
    for row in sound_rows(connection, select(journal).order_by(journal.c.number)):
        number, target = row["number"], row["target"]
        if target is None:
            known[number] = [Image(*image) for image in row["images"]]
            yield number, known[number], None
        elif row["command"] == "undo":
            yield number, [image.swapped() for image in reversed(known[target])], target
        else:
            yield number, known[target], None


def _incoming_flights(changes: Sequence[tuple[int, Sequence[Image], int | None]]) -> dict[int, int]:
    """The change that last added each flight, by entry number; undoing a removal does not count."""
    changes_by_entry: dict[int, int] = {}
    removed: dict[tuple[int, int], int] = {}
    for number, images, undoes in changes:
        for image in images:
            if image.table != "flights":
                continue
            if image.before is None and image.after:
                entry = image.after["entry"]
                changes_by_entry[entry] = number if undoes is None else removed.get((undoes, entry), number)
            elif image.after is None and image.before:
                entry = image.before["entry"]
                removed[number, entry] = changes_by_entry.get(entry, number)
    return changes_by_entry


def _rows(connection: Connection) -> TableRows:
    tables: dict[Table, list[Row]] = {
        flights: sound_flights(connection, select(flights)),
        tags: list(map(dict, connection.execute(select(tags)).mappings())),
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
