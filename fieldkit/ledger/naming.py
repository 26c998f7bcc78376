"""The id of a flight: its flight_id if unique, else rocket/flight_id. In place of an id, `last` is the flight entered
most recently, and the beginning of an id is the only flight whose id begins so."""

from collections.abc import Collection, Iterator, Mapping, Sequence

from sqlalchemy import Connection, or_, select, tuple_

from fieldkit.errors import LedgerError, nearest
from fieldkit.ledger.finding import Identity, StoredFlight, find, latest
from fieldkit.ledger.finding import names as field_names
from fieldkit.ledger.rows import known_names
from fieldkit.ledger.tables import MAX_ROWS_BY_NAME, flights
from fieldkit.quantities import counted

LATEST_FLIGHT = "last"
"""Refers to the flight that was entered most recently, unless a flight has this name."""
MIN_BEGINNING = 4
"""Length from which the beginning of an id may stand for it, so that 1 never means flight 10. [1]"""
MAX_LISTED = 5
"""Number of listed ids with the same beginning. [1]"""
MAX_SLASHES = 10_000
"""Number of slashes in texts up to which each is tried as the end of a rocket's name; SQLite limits a query to 32,766
values. [1]"""


def ids(connection: Connection, wanted: Collection[Identity]) -> dict[Identity, str]:
    """The id of each of these flights: its flight_id if unique, else `rocket/flight_id`.

    A flight that another program has removed in the meantime gets the id it would have by itself.
    """
    short = {flight_id for _, flight_id in wanted}
    counts: dict[str, int] = {}
    for rocket, flight_id in _identities_meant(connection, short):
        for name in {flight_id, f"{rocket}/{flight_id}"} & short:
            counts[name] = counts.get(name, 0) + 1
    return {(r, f): f if counts.get(f, 1) == 1 else f"{r}/{f}" for r, f in wanted}


def ids_of(connection: Connection, stored: Sequence[StoredFlight]) -> list[str]:
    """The ids of stored flights, in order."""
    identities = [(one.flight.rocket, one.flight.flight_id) for one in stored]
    known = ids(connection, identities)
    return [known[identity] for identity in identities]


def _identities_meant(connection: Connection, texts: Collection[str]) -> Iterator[Identity]:
    """The flights that these texts may refer to, as `flight_id` or `rocket/flight_id`; for many texts, or many slashes
    in them, all flights.

    Raises DamagedRow.
    """
    query = select(flights.c.rocket, flights.c.flight_id)
    if len(texts) <= MAX_ROWS_BY_NAME and sum(text.count("/") for text in texts) <= MAX_SLASHES:
        halves = [(text[:at], text[at + 1 :]) for text in texts for at, letter in enumerate(text) if letter == "/"]
        pair = tuple_(flights.c.rocket, flights.c.flight_id)
        query = query.where(or_(flights.c.flight_id.in_(texts), *([pair.in_(halves)] if halves else [])))
    for rocket, flight_id in connection.execute(query):
        rocket, flight_id = known_names([rocket, flight_id])
        yield rocket, flight_id


def ids_meant(connection: Connection, texts: Sequence[str]) -> list[str]:
    """The ids that texts stand for: all flights of a rocket for its name, else the text itself."""
    flown = set(field_names(connection, "rocket", None)) & set(texts)
    taken = {name for rocket, id in _identities_meant(connection, flown) for name in (id, f"{rocket}/{id}")}
    found: list[str] = []
    for text in texts:
        if text in flown - taken:
            entered = select(flights.c.flight_id).where(flights.c.rocket == text).order_by(flights.c.entry)
            own = [(text, id) for id in connection.scalars(entered)]
            known = ids(connection, own)
            found += [known[one] for one in own]
        else:
            found.append(text)
    return list(dict.fromkeys(found))


def resolve(connection: Connection, id: str) -> StoredFlight:
    """The flight that an id refers to. Raises LedgerError that suggests similar ids, or lists the matches."""
    return resolve_all(connection, [id])[0]


def resolve_all(connection: Connection, texts: Sequence[str]) -> list[StoredFlight]:
    """The flights that ids refer to, in order. Raises LedgerError that suggests similar ids, or lists the matches."""
    known = ids(connection, list(_identities_meant(connection, set(texts))))
    by_name: dict[str, list[Identity]] = {}
    for identity in known:
        for name in {identity[1], "/".join(identity)}:
            by_name.setdefault(name, []).append(identity)
    if (
        LATEST_FLIGHT in texts
        and LATEST_FLIGHT not in by_name
        and (newest := latest(connection, None, None)) is not None
    ):
        by_name[LATEST_FLIGHT] = [(newest.rocket, newest.flight_id)]
    wanted = [_the_one(connection, text, by_name.get(text, []), known) for text in texts]
    stored = {(one.flight.rocket, one.flight.flight_id): one for one in find(connection, wanted)}
    return [stored[identity] for identity in wanted]


def _the_one(connection: Connection, id: str, found: Sequence[Identity], known: Mapping[Identity, str]) -> Identity:
    """The identity that an id refers to, among the candidates. Raises LedgerError."""
    if len(found) > 1:  # one of them may match the full id
        found = [identity for identity in found if known[identity] == id] or found
    if len(found) > 1:
        raise LedgerError(f"{id} is ambiguous: {' or '.join(sorted(known[one] for one in found))}")
    return found[0] if found else _by_beginning(connection, id)


def _by_beginning(connection: Connection, id: str) -> Identity:
    """The only flight of a rocket, or the only one whose id begins so. Raises LedgerError that suggests similar ids, or
    lists those that do."""
    everything = [
        (rocket, flight_id)
        for names in connection.execute(select(flights.c.rocket, flights.c.flight_id))
        for rocket, flight_id in [known_names(names)]
    ]
    known = ids(connection, everything)
    named = {name: identity for identity, name in known.items()}
    matches = sorted(name for name in named if name.startswith(id)) if len(id) >= MIN_BEGINNING else []
    of_rocket = [name for (rocket, _), name in known.items() if rocket == id]
    if len(of_rocket) > 1:
        first = " or ".join(of_rocket[:MAX_LISTED])
        raise LedgerError(f"{id} is a rocket with {counted(len(of_rocket), 'flight')}, expected one of them: {first}")
    if len(matches) == 1 or of_rocket:
        return named[(of_rocket or matches)[0]]
    if matches:
        more = f" or {counted(len(matches) - MAX_LISTED, 'other')}" if len(matches) > MAX_LISTED else ""
        raise LedgerError(f"{id} is ambiguous: {' or '.join(matches[:MAX_LISTED])}{more}")
    near = nearest(id, named, least=0.4)  # ids are often short
    hint = f"did you mean {' or '.join(near)}?" if near else f"the ledger holds {counted(len(everything), 'flight')}"
    raise LedgerError(f"no flight {id!r}; {hint}")
