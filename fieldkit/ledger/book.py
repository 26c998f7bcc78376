"""Add, replace, renew and remove flights in the tables."""

import shlex
from collections.abc import Mapping, Sequence

from sqlalchemy import Connection, func, select

from fieldkit.errors import BadValue, LedgerError
from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.flight.storable import check_keys
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger.finding import Identity, StoredFlight, find, of_logs
from fieldkit.ledger.journal import ChangeRecorder
from fieldkit.ledger.logs import keep_log
from fieldkit.ledger.naming import ids
from fieldkit.ledger.records import Added, Conflict
from fieldkit.ledger.rows import Row, agrees, differences, row_of, same, without_empty_numbers
from fieldkit.ledger.tables import MAX_ROWS_BY_NAME, flights, tags


class KnownFlights:
    """The flights in the ledger that may match new ones, by rocket and flight_id."""

    def __init__(self, connection: Connection, new: Sequence[Flight]) -> None:
        self.now: dict[tuple[str, str], tuple[Flight, str | None]] = {}
        self.once: dict[tuple[str, str], list[tuple[Flight, str | None]]] = {}
        for stored in find(connection, [(flight.rocket, flight.flight_id) for flight in new]):
            self.note(stored.flight, stored.log_digest)
            if one := stored.entered:
                self.once.setdefault((one.rocket, one.flight_id), []).append((one, stored.log_digest))

    def note(self, flight: Flight, log_digest: str | None = None) -> None:
        """Register a flight and the digest of its log."""
        self.now[flight.rocket, flight.flight_id] = flight, log_digest

    def named(self, rocket: str, flight_id: str) -> Flight | None:
        """The stored flight with this name now."""
        return self.now.get((rocket, flight_id), (None, None))[0]

    def match(self, incoming: IncomingFlight) -> Flight | None:
        """The stored flight that equals an incoming one, in its current or its imported state; a match of the bytes
        suffices, whatever the current parser reads from them."""
        flight = incoming.flight
        identity = flight.rocket, flight.flight_id
        known = [one for one in (self.now.get(identity), *self.once.get(identity, ())) if one]
        return next((one for one, log in known if same(one, flight) or self._reread(one, log, incoming)), None)

    def _reread(self, one: Flight, log_digest: str | None, incoming: IncomingFlight) -> bool:
        return (
            incoming.log is not None
            and log_digest == incoming.log.digest
            and incoming.given is not None
            and agrees(one, incoming.given)
            and not lacks_files(one, incoming.flight)
        )


def lacks_files(stored: Flight, flight: Flight) -> bool:
    """Whether an incoming flight has more files than the stored one."""
    return not set(flight.origin.others) <= set(stored.origin.others)


def add(recorder: ChangeRecorder, incoming_flights: Sequence[IncomingFlight]) -> Added:
    """Add flights, some at a time, as the rows of a long import fill the memory; see `Ledger.add`."""
    elsewhere = _by_log(recorder.connection, incoming_flights)
    new: list[Identity] = []
    conflicts: list[Conflict] = []
    for start in range(0, len(incoming_flights), MAX_ROWS_BY_NAME):
        rows, refused = _add_some(recorder, incoming_flights[start : start + MAX_ROWS_BY_NAME], elsewhere)
        new += rows
        conflicts += refused
    names = ids(recorder.connection, new)
    return Added(tuple(names.values()), len(incoming_flights) - len(new) - len(conflicts), tuple(conflicts))


def _add_some(
    recorder: ChangeRecorder,
    incoming_flights: Sequence[IncomingFlight],
    elsewhere: Mapping[tuple[str, str] | None, Flight],
) -> tuple[list[Identity], list[Conflict]]:
    """Add flights; returns the new ones and the conflicts, the others are duplicates."""
    known, conflicts = KnownFlights(recorder.connection, [one.flight for one in incoming_flights]), []
    entry = recorder.connection.scalar(select(func.max(flights.c.entry))) or 0
    rows: list[Row] = []
    originals: dict[str, Original] = {}
    for incoming in incoming_flights:
        flight = incoming.flight
        if known.match(incoming):
            continue
        if (other := elsewhere.get(_log_identity(incoming))) and other.rocket != flight.rocket:
            if flight.rocket or not agrees(other, incoming.given or {}):
                conflicts.append(Conflict(incoming, _other_rocket(recorder.connection, other, flight)))
        elif error := _objection(flight, known.named(flight.rocket, flight.flight_id)):
            conflicts.append(Conflict(incoming, error))
        else:
            known.note(flight)
            originals |= {one.digest: one for one in (incoming.log, *incoming.others) if one}
            digest = incoming.log.digest if incoming.log else None
            entry += 1
            beside = {"entry": entry, "log_digest": digest, "source": incoming.source}
            rows.append(without_empty_numbers(row_of(flight) | beside))
    for original in originals.values():
        keep_log(recorder.connection, original)
    labels = [tag for row in rows for tag in _tag_rows(row["entry"], row.pop("tags"))]
    recorder.insert(flights, rows)
    recorder.insert(tags, labels)
    recorder.seal()
    return [(row["rocket"], row["flight_id"]) for row in rows], conflicts


def _log_identity(incoming: IncomingFlight) -> tuple[str, str] | None:
    """Digest and flight_id of a flight from a file that names no rocket: the same under any rocket. None for others."""
    names_none = not incoming.flight.rocket or "rocket" in (incoming.given or {})
    return (incoming.log.digest, incoming.flight.flight_id) if incoming.log and names_none else None


def _by_log(connection: Connection, incoming_flights: Sequence[IncomingFlight]) -> dict[tuple[str, str] | None, Flight]:
    """The stored flights from the files of incoming ones that name no rocket, by digest and flight_id."""
    wanted = {one for one in map(_log_identity, incoming_flights) if one}
    stored = of_logs(connection, sorted({digest for digest, _ in wanted}))
    every = {(one.log_digest, one.flight.flight_id): one.flight for one in stored if one.log_digest}
    return {one: every[one] for one in wanted & every.keys()}


def _other_rocket(connection: Connection, stored: Flight, flight: Flight) -> str:
    """Why a flight cannot be added whose log is stored as a flight of another rocket, in one line."""
    (name,) = ids(connection, [(stored.rocket, stored.flight_id)]).values()
    owner = f"as a flight of {stored.rocket}" if stored.rocket else "without a rocket"
    column = shlex.quote(f"rocket={flight.rocket}") if flight.rocket else "COLUMN=VALUE"
    return (
        f"{flight_label(flight.flight_id)}: this log is in the ledger {owner}; "
        f"use `fieldkit edit {shlex.quote(name)} {column}` to change it"
    )


def _objection(flight: Flight, stored: Flight | None) -> str | None:
    """Why a flight cannot be added, in one line."""
    if not flight.flight_id:
        return "found a flight without an id, expected one that is unique within the rocket"
    if stored and lacks_files(stored, flight):
        return (
            f"{flight_label(flight.flight_id)} of {flight.rocket or 'no rocket'} is in the ledger without the "
            f"other files of its logger; `fieldkit remove` it and import them together again"
        )
    if stored:
        fields = ", ".join(differences(stored, flight))
        return (
            f"{flight_label(flight.flight_id)} of {flight.rocket or 'no rocket'} is in the ledger "
            f"with another {fields}; use `fieldkit edit` to change it"
        )
    try:
        check_keys(flight)
        row_of(flight)
    except BadValue as error:
        return str(error)
    return None


def replace(recorder: ChangeRecorder, stored: StoredFlight, flight: Flight) -> bool:
    """Replace a stored flight with a changed one; False if nothing changed.

    Raises LedgerError if another flight has its name, BadValue for values that cannot be stored.
    """
    before, after = row_of(stored.flight), row_of(flight)
    if before == after:
        return False
    identity = flight.rocket, flight.flight_id
    if before["tags"] != after["tags"] or identity != (stored.flight.rocket, stored.flight.flight_id):
        check_keys(flight)
    if not flight.flight_id:
        raise LedgerError("found an empty id of a flight, expected one that is unique within the rocket")
    if identity != (stored.flight.rocket, stored.flight.flight_id) and _exists(recorder.connection, identity):
        raise LedgerError(f"{flight_label(flight.flight_id)} of {flight.rocket} is already in the ledger")
    changes = {name: value for name, value in after.items() if value != before[name] and name != "tags"}
    if stored.entered is None:
        changes["entered"] = before
    if changes:
        recorder.update(flights, {"entry": stored.entry}, changes)
    if before["tags"] != after["tags"]:
        recorder.delete(tags, tags.c.entry == stored.entry)
        recorder.insert(tags, _tag_rows(stored.entry, after["tags"]))
    return True


def renew(
    recorder: ChangeRecorder, stored: StoredFlight, flight: Flight, entered: Flight | None, others: Sequence[Original]
) -> bool:
    """Update a flight, and its imported state, from its files; False if nothing changed. Raises BadValue for a
    value that the ledger cannot store.
    """
    for original in others:
        keep_log(recorder.connection, original)
    before, after = row_of(stored.flight), row_of(flight)
    changes = {name: value for name, value in after.items() if value != before[name] and name != "tags"}
    if stored.entered and entered and row_of(stored.entered) != row_of(entered):
        changes["entered"] = row_of(entered)
    if changes:
        recorder.update(flights, {"entry": stored.entry}, changes)
    return bool(changes)


def _exists(connection: Connection, identity: Identity) -> bool:
    where = (flights.c.rocket == identity[0]) & (flights.c.flight_id == identity[1])
    return connection.scalar(select(flights.c.entry).where(where)) is not None


def remove(recorder: ChangeRecorder, stored: StoredFlight) -> None:
    """Remove a flight; the bytes of its log stay in the ledger."""
    recorder.delete(tags, tags.c.entry == stored.entry)
    recorder.delete(flights, flights.c.entry == stored.entry)


def _tag_rows(entry: int, labels: Sequence[str]) -> list[Row]:
    return [{"entry": entry, "position": position, "tag": tag} for position, tag in enumerate(labels)]
