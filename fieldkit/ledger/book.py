"""Flights in the tables: taking in, finding, replacing and taking out."""

import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from sqlalchemy import Connection, func, insert, or_, select

from fieldkit.arrival import OTHER_LOGS, Arrival, Original
from fieldkit.errors import BadValue, LedgerError
from fieldkit.flight import Flight
from fieldkit.ledger.journal import Pen
from fieldkit.ledger.records import Added, Conflict
from fieldkit.ledger.rows import Row, agrees, differences, flight_of, row_of, same
from fieldkit.ledger.tables import flights, logs, tags


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
        for held in load(connection, rockets={flight.rocket for flight in new}):
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
    names = ids(pen.connection) if rows else {}
    return Added(tuple(names[row["rocket"], row["flight_id"]] for row in rows), duplicates, tuple(conflicts))


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
    rockets: Iterable[str] | None = None,
    entries: Sequence[int] | None = None,
) -> list[Held]:
    """Flights by date and then by entry; of a rocket, of those once of these rockets, or at these entries."""
    query = select(flights).order_by(flights.c.date_time.nulls_last(), flights.c.entry)
    if rocket is not None:
        query = query.where(flights.c.rocket == rocket)
    if rockets is not None:
        query = query.where(or_(flights.c.rocket.in_(list(rockets)), flights.c.entered.is_not(None)))
    if entries is not None:
        query = query.where(flights.c.entry.in_(entries))
    rows = [dict(row) for row in connection.execute(query).mappings()]
    labels: dict[int, list[str]] = {row["entry"]: [] for row in rows}
    for label in connection.execute(select(tags).order_by(tags.c.entry, tags.c.position)):
        if label.entry in labels:
            labels[label.entry].append(label.tag)
    return [
        Held(
            row["entry"],
            flight_of(row, labels[row["entry"]]),
            flight_of(row["entered"], row["entered"]["tags"]) if row["entered"] else None,
            row["log_digest"],
        )
        for row in rows
    ]


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
    if identity != (held.flight.rocket, held.flight.flight_id) and identity in ids(pen.connection):
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


def remove(pen: Pen, held: Held) -> None:
    """Take a flight out; its log's bytes stay."""
    pen.delete(tags, tags.c.entry == held.entry)
    pen.delete(flights, flights.c.entry == held.entry)


def _tag_rows(entry: int, labels: Sequence[str]) -> list[Row]:
    return [{"entry": entry, "position": position, "tag": tag} for position, tag in enumerate(labels)]


def ids(connection: Connection) -> dict[tuple[str, str], str]:
    """The id of every flight: its flight_id where that says enough, else `rocket/flight_id`."""
    identities = [tuple(row) for row in connection.execute(select(flights.c.rocket, flights.c.flight_id))]
    meant: dict[str, int] = {}
    for rocket, flight_id in identities:
        for name in {flight_id, f"{rocket}/{flight_id}"}:
            meant[name] = meant.get(name, 0) + 1
    return {(r, f): f if meant[f] == 1 else f"{r}/{f}" for r, f in identities}


def resolve(connection: Connection, id: str) -> Held:
    """The flight that an id means. Raises LedgerError that suggests near ones, or lists several."""
    known = ids(connection)
    found = [identity for identity in known if id in (identity[1], "/".join(identity))]
    if len(found) > 1:  # one of them may bear the id in full
        found = [identity for identity in found if known[identity] == id] or found
    if len(found) > 1:
        raise LedgerError(f"{id} may be {' or '.join(sorted(known[one] for one in found))}")
    if not found:
        near = get_close_matches(id, known.values(), n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}?" if near else f"the ledger holds {len(known)} flights"
        raise LedgerError(f"no flight {id!r}; {hint}")
    rocket, flight_id = found[0]
    where = (flights.c.rocket == rocket) & (flights.c.flight_id == flight_id)
    entry = connection.scalar(select(flights.c.entry).where(where))
    return load(connection, entries=[entry or 0])[0]


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
    content = connection.scalar(select(logs.c.content).where(logs.c.digest == digest))
    return None if content is None else zlib.decompress(content)
