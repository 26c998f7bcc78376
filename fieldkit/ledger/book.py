"""Flights in the tables: taking in, finding, replacing and taking out."""

import zlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from sqlalchemy import Connection, Select, func, insert, or_, select, tuple_

from fieldkit.arrival import OTHER_LOGS, Arrival, Original
from fieldkit.errors import BadValue, LedgerError
from fieldkit.flight import Flight
from fieldkit.ledger.journal import Pen
from fieldkit.ledger.records import Added, Conflict
from fieldkit.ledger.rows import Row, agrees, differences, flight_of, row_of, same
from fieldkit.ledger.tables import EDITED, flights, logs, tags

Identity = tuple[str, str]
"""A rocket and a flight_id, which together name a flight."""
LARGEST_LOG = 1 << 30
"""No log that is unpacked is larger. [byte]"""
FEW = 500
"""So many are asked for by name; of more, everything is read. [1]"""


@dataclass(frozen=True, slots=True)
class Held:
    """A flight and where it stands; `entered` is how it came in, where it was edited since."""

    entry: int
    flight: Flight
    entered: Flight | None
    log_digest: str | None


class Known:
    """The flights that new ones might be, by rocket and flight_id."""

    def __init__(self, connection: Connection, new: Sequence[Flight]) -> None:
        self.now: dict[tuple[str, str], Flight] = {}
        self.once: dict[tuple[str, str], Flight] = {}
        self.digests: dict[int, str | None] = {}
        for held in find(connection, [(flight.rocket, flight.flight_id) for flight in new]):
            self.note(held.flight)
            self.digests[id(held.flight)] = held.log_digest
            if held.entered:
                self.once[held.entered.rocket, held.entered.flight_id] = held.entered
                self.digests[id(held.entered)] = held.log_digest

    def note(self, flight: Flight) -> None:
        """Know this flight from now on."""
        self.now[flight.rocket, flight.flight_id] = flight

    def match(self, arrival: Arrival) -> Flight | None:
        """The very same flight, as it is now or as it once came in; of the same bytes, whatever is read in them now."""
        flight = arrival.flight
        identity = flight.rocket, flight.flight_id
        known = [one for one in (self.now.get(identity), self.once.get(identity)) if one]
        return next((one for one in known if same(one, flight) or self._reread(one, arrival)), None)

    def _reread(self, one: Flight, arrival: Arrival) -> bool:
        return (
            arrival.log is not None
            and self.digests.get(id(one)) == arrival.log.digest
            and arrival.given is not None
            and agrees(one, arrival.given)
            and not lacks_files(one, arrival.flight)
        )


def lacks_files(there: Flight, flight: Flight) -> bool:
    """Whether a flight as it arrives is of more files than the one that is there."""
    named = [set(one.extra.get(OTHER_LOGS, "").split()) for one in (there, flight)]
    return not named[1] <= named[0]


def add(pen: Pen, arrivals: Sequence[Arrival]) -> Added:
    """Take flights in; see `Ledger.add`."""
    known, conflicts, duplicates = Known(pen.connection, [one.flight for one in arrivals]), [], 0
    entry = pen.connection.scalar(select(func.max(flights.c.entry))) or 0
    rows: list[Row] = []
    for arrival in arrivals:
        flight = arrival.flight
        if known.match(arrival):
            duplicates += 1
        elif error := _objection(flight, known.now.get((flight.rocket, flight.flight_id))):
            conflicts.append(Conflict(arrival, error))
        else:
            known.note(flight)
            for original in (arrival.log, *arrival.others):
                if original:
                    keep_log(pen.connection, original)
            digest = arrival.log.digest if arrival.log else None
            entry += 1
            rows.append(row_of(flight) | {"entry": entry, "log_digest": digest, "source": arrival.source})
    labels = [tag for row in rows for tag in _tag_rows(row["entry"], row.pop("tags"))]
    pen.insert(flights, rows)
    pen.insert(tags, labels)
    names = ids(pen.connection, [(row["rocket"], row["flight_id"]) for row in rows])
    return Added(tuple(names.values()), duplicates, tuple(conflicts))


def _objection(flight: Flight, there: Flight | None) -> str | None:
    """Why a flight cannot be taken in, in one line."""
    if not flight.flight_id:
        return "found no flight_id, expected one that is unique within the rocket"
    if there and lacks_files(there, flight):
        return (
            f"flight {flight.flight_id} of {flight.rocket or 'no rocket'} is in the ledger without the other files "
            f"of its logger; `fieldkit remove` it and import them together again"
        )
    if there:
        fields = ", ".join(differences(there, flight))
        return (
            f"flight {flight.flight_id} of {flight.rocket or 'no rocket'} is in the ledger "
            f"with another {fields}; use `fieldkit edit` to change it"
        )
    try:
        row_of(flight)
    except BadValue as error:
        return str(error)
    return None


def load(
    connection: Connection,
    *,
    rocket: str | None = None,
    tag: str | None = None,
    entries: Sequence[int] | None = None,
) -> list[Held]:
    """Flights by date and then by entry; of a rocket, with a tag, at these entries."""
    query = select(flights).order_by(flights.c.date_time.nulls_last(), flights.c.entry)
    if rocket is not None:
        query = query.where(flights.c.rocket == rocket)
    if tag is not None:
        query = query.where(flights.c.entry.in_(select(tags.c.entry).where(tags.c.tag == tag)))
    if entries is not None and len(entries) <= FEW:
        query = query.where(flights.c.entry.in_(entries))
    held = _all_held(connection, query)
    if entries is not None and len(entries) > FEW:
        wanted = set(entries)
        held = [one for one in held if one.entry in wanted]
    return held


def find(connection: Connection, identities: Sequence[Identity]) -> list[Held]:
    """The flights that bear one of these identities now, or bore it as they came in."""
    held: list[Held] = []
    for start in range(0, len(identities), FEW):
        some = identities[start : start + FEW]
        entered = tuple_(*(flights.c.entered[name].as_string() for name in ("rocket", "flight_id")))
        now = select(flights.c.entry).where(tuple_(flights.c.rocket, flights.c.flight_id).in_(some))
        once = select(flights.c.entry).where(EDITED, entered.in_(some))
        held += _all_held(connection, select(flights).where(flights.c.entry.in_(now.union(once))))
    return held


def _all_held(connection: Connection, query: Select[Any]) -> list[Held]:
    columns = flights.c.keys()
    rows = [dict(zip(columns, row, strict=True)) for row in connection.execute(query)]
    labels: dict[int, list[str]] = {row["entry"]: [] for row in rows}
    for label in connection.execute(_labels(labels)):
        if label.entry in labels:
            labels[label.entry].append(label.tag)
    return [_held(row, labels[row["entry"]]) for row in rows]


def _labels(entries: Collection[int]) -> Select[Any]:
    """The tags of these flights, and of others where they are many."""
    query = select(tags).order_by(tags.c.entry, tags.c.position)
    return query.where(tags.c.entry.in_(entries)) if len(entries) <= FEW else query


def _held(row: Mapping[str, Any], labels: Sequence[str]) -> Held:
    """A row and its tags as a flight. Raises LedgerError for a row that no fieldkit wrote."""
    try:
        once = flight_of(row["entered"], row["entered"]["tags"]) if row["entered"] else None
        return Held(row["entry"], flight_of(row, labels), once, row["log_digest"])
    except (ValueError, TypeError, LookupError) as error:
        raise LedgerError(f"flight {row['flight_id']!r} of {row['rocket']!r}: its row is damaged ({error})") from error


def replace(pen: Pen, held: Held, flight: Flight) -> bool:
    """Put a changed flight in a held one's place; False where nothing changed.

    Raises LedgerError when another flight bears its name, BadValue for what cannot be kept.
    """
    before, after = row_of(held.flight), row_of(flight)
    if before == after:
        return False
    identity = flight.rocket, flight.flight_id
    if not flight.flight_id:
        raise LedgerError("found an empty flight_id, expected one that is unique within the rocket")
    if identity != (held.flight.rocket, held.flight.flight_id) and _is_there(pen.connection, identity):
        raise LedgerError(f"flight {flight.flight_id} of {flight.rocket} is in the ledger already")
    changes = {name: value for name, value in after.items() if value != before[name] and name != "tags"}
    if held.entered is None:
        changes["entered"] = before
    if changes:
        pen.update(flights, {"entry": held.entry}, changes)
    if before["tags"] != after["tags"]:
        pen.delete(tags, tags.c.entry == held.entry)
        pen.insert(tags, _tag_rows(held.entry, after["tags"]))
    return True


def renew(pen: Pen, held: Held, flight: Flight, entered: Flight | None, others: Sequence[Original]) -> bool:
    """Put what a flight's files say now in its place, also in how it came in; False where nothing changed."""
    for original in others:
        keep_log(pen.connection, original)
    before, after = row_of(held.flight), row_of(flight)
    changes = {name: value for name, value in after.items() if value != before[name] and name != "tags"}
    if held.entered and entered and row_of(held.entered) != row_of(entered):
        changes["entered"] = row_of(entered)
    if changes:
        pen.update(flights, {"entry": held.entry}, changes)
    return bool(changes)


def _is_there(connection: Connection, identity: Identity) -> bool:
    where = (flights.c.rocket == identity[0]) & (flights.c.flight_id == identity[1])
    return connection.scalar(select(flights.c.entry).where(where)) is not None


def remove(pen: Pen, held: Held) -> None:
    """Take a flight out; its log's bytes stay."""
    pen.delete(tags, tags.c.entry == held.entry)
    pen.delete(flights, flights.c.entry == held.entry)


def _tag_rows(entry: int, labels: Sequence[str]) -> list[Row]:
    return [{"entry": entry, "position": position, "tag": tag} for position, tag in enumerate(labels)]


def ids(connection: Connection, wanted: Collection[Identity]) -> dict[Identity, str]:
    """The id of each of these flights: its flight_id where that says enough, else `rocket/flight_id`."""
    meant: dict[str, int] = {}
    for rocket, flight_id in _meant(connection, {flight_id for _, flight_id in wanted}):
        for name in {flight_id, f"{rocket}/{flight_id}"}:
            meant[name] = meant.get(name, 0) + 1
    return {(r, f): f if meant[f] == 1 else f"{r}/{f}" for r, f in wanted}


def _meant(connection: Connection, texts: Collection[str]) -> list[Identity]:
    """The flights that any of these texts may mean, as `flight_id` or as `rocket/flight_id`; of many texts, all."""
    query = select(flights.c.rocket, flights.c.flight_id)
    if len(texts) <= FEW:
        halves = [(text[:at], text[at + 1 :]) for text in texts for at, letter in enumerate(text) if letter == "/"]
        pair = tuple_(flights.c.rocket, flights.c.flight_id)
        query = query.where(or_(flights.c.flight_id.in_(texts), *([pair.in_(halves)] if halves else [])))
    return [(rocket, flight_id) for rocket, flight_id in connection.execute(query)]


def resolve(connection: Connection, id: str) -> Held:
    """The flight that an id means. Raises LedgerError that suggests near ones, or lists several."""
    return resolve_all(connection, [id])[0]


def resolve_all(connection: Connection, texts: Sequence[str]) -> list[Held]:
    """The flights that ids mean, in their order. Raises LedgerError that suggests near ones, or lists several."""
    known = ids(connection, _meant(connection, set(texts)))
    meant: dict[str, list[Identity]] = {}
    for identity in known:
        for name in {identity[1], "/".join(identity)}:
            meant.setdefault(name, []).append(identity)
    wanted = [_the_one(connection, text, meant.get(text, []), known) for text in texts]
    held = {(one.flight.rocket, one.flight.flight_id): one for one in find(connection, wanted)}
    return [held[identity] for identity in wanted]


def _the_one(connection: Connection, id: str, found: Sequence[Identity], known: Mapping[Identity, str]) -> Identity:
    """The identity that an id means, among those it may mean. Raises LedgerError."""
    if len(found) > 1:  # one of them may bear the id in full
        found = [identity for identity in found if known[identity] == id] or found
    if len(found) > 1:
        raise LedgerError(f"{id} may be {' or '.join(sorted(known[one] for one in found))}")
    if not found:
        everything = [(r, f) for r, f in connection.execute(select(flights.c.rocket, flights.c.flight_id))]
        near = get_close_matches(id, ids(connection, everything).values(), n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}?" if near else f"the ledger holds {len(everything)} flights"
        raise LedgerError(f"no flight {id!r}; {hint}")
    return found[0]


def names(connection: Connection, field: str, rocket: str | None) -> list[str]:
    """What the flights name in one of their text fields, the last used first."""
    column = flights.c[field]
    query = select(column).where(column != "").group_by(column).order_by(func.max(flights.c.entry).desc())
    return list(connection.scalars(query if rocket is None else query.where(flights.c.rocket == rocket)))


def latest(connection: Connection, rocket: str | None, config: str | None) -> Flight | None:
    """The flight entered last."""
    wanted = {flights.c.rocket: rocket, flights.c.config: config}
    where = [column == value for column, value in wanted.items() if value is not None]
    entry = connection.scalar(select(func.max(flights.c.entry)).where(*where))
    return load(connection, entries=[entry])[0].flight if entry else None


def next_flight_id(connection: Connection, rocket: str) -> str:
    """One more than the highest number among a rocket's flight ids."""
    taken = connection.scalars(select(flights.c.flight_id).where(flights.c.rocket == rocket))
    return str(max((int(one) for one in taken if one.isdecimal()), default=0) + 1)


def keep_log(connection: Connection, original: Original) -> None:
    """Keep a log's bytes under their digest, once."""
    if connection.scalar(select(logs.c.digest).where(logs.c.digest == original.digest)) is None:
        row = {"digest": original.digest, "size": original.size, "content": original.packed}
        connection.execute(insert(logs).values(**row))


def log_of(connection: Connection, held: Held) -> bytes | None:
    """The original bytes of a held flight's log."""
    return _content(connection, held.log_digest)


def other_logs_of(connection: Connection, held: Held) -> list[bytes]:
    """The original bytes of the further files of a held flight."""
    contents = [_content(connection, digest) for digest in held.flight.extra.get(OTHER_LOGS, "").split()]
    return [content for content in contents if content is not None]


def _content(connection: Connection, digest: str | None) -> bytes | None:
    row = connection.execute(select(logs.c.content, logs.c.size).where(logs.c.digest == digest)).first()
    return None if row is None else _unpacked(row.content, row.size)


def _unpacked(packed: bytes, size: int) -> bytes:
    """The bytes of a log, never more than its row says. Raises LedgerError for another size, zlib.error."""
    if not 0 <= size <= LARGEST_LOG:
        raise LedgerError(f"found a log of {size} bytes, expected at most {LARGEST_LOG}")
    unpacking = zlib.decompressobj()
    content = unpacking.decompress(packed, size + 1)
    if len(content) != size:
        raise LedgerError(f"found a log of another size than the {size} bytes of its row, which is damaged")
    return content
