"""Read flights, and the names in them, from the tables."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date, datetime
from itertools import count
from typing import Any

from sqlalchemy import ColumnElement, Connection, Select, func, select, tuple_

from fieldkit.flight import Flight
from fieldkit.ledger.checksums import sound_flights
from fieldkit.ledger.records import Contents
from fieldkit.ledger.rows import DamagedRow, Row, flight_of, known_names
from fieldkit.ledger.tables import IS_EDITED, MAX_ROWS_BY_NAME, flights, tags
from fieldkit.safe_text import whole_number

Identity = tuple[str, str]
"""A rocket and a flight_id, which together identify a flight."""


@dataclass(frozen=True, slots=True)
class StoredFlight:
    """A stored flight and its entry number; `entered` is its imported state, if it was edited since."""

    entry: int
    flight: Flight
    entered: Flight | None
    log_digest: str | None


_EARLIER_DATE = func.max(flights.c.date_time).over(
    partition_by=flights.c.rocket, order_by=flights.c.entry, rows=(None, 0)
)
_FLIGHT_DATE = func.coalesce(flights.c.date_time, _EARLIER_DATE)
"""Sort key of a flight: its date, or else the latest date among flights of its rocket entered earlier."""


PAGE = 100
"""Number of flights on the first page of a list; later pages grow, up to `MAX_ROWS_BY_NAME`. [1]"""


def row_pages(connection: Connection, *, rocket: str | None = None, tag: str | None = None) -> Iterator[list[Row]]:
    """The rows of flights in the order flown, page by page: the order of the first page is queried first, then that of
    the rest. Raises DamagedRow."""
    order = _chosen(select(flights.c.entry), rocket, tag).order_by(*_order(connection))
    first = list(connection.scalars(order.limit(PAGE)))
    if first:
        yield _at(connection, first)
    if len(first) < PAGE:
        return
    entries = list(connection.scalars(order.offset(PAGE)))
    for start in range(0, len(entries), MAX_ROWS_BY_NAME):
        yield _at(connection, entries[start : start + MAX_ROWS_BY_NAME])


def _at(connection: Connection, entries: Sequence[int]) -> list[Row]:
    """The rows of the flights with these entry numbers, in the given order."""
    query = select(flights).where(flights.c.entry.in_(entries))
    rows = {row["entry"]: row for row in sound_flights(connection, query)}
    return [rows[entry] for entry in entries]


def _order(connection: Connection, *, newest_first: bool = False) -> tuple[ColumnElement[Any], ...]:
    """The order flown. If every flight has a date, sorting is by date only, which takes half the time."""
    undated = connection.scalar(select(flights.c.entry).where(flights.c.date_time.is_(None)).limit(1))
    date: ColumnElement[Any] = flights.c.date_time if undated is None else _FLIGHT_DATE
    return (date.desc().nulls_last(), flights.c.entry.desc()) if newest_first else (date.nulls_first(), flights.c.entry)


def _chosen(query: Select[Any], rocket: str | None, tag: str | None) -> Select[Any]:
    if rocket is not None:
        query = query.where(flights.c.rocket == rocket)
    if tag is not None:
        query = query.where(flights.c.entry.in_(select(tags.c.entry).where(tags.c.tag == tag)))
    return query


def load(
    connection: Connection,
    *,
    rocket: str | None = None,
    tag: str | None = None,
    entries: Sequence[int] | None = None,
    since: date | None = None,
    last: int | None = None,
) -> list[StoredFlight]:
    """Flights in the order flown: all, of one rocket, with a tag, with these entry numbers, with a date on this day or
    later, or the `last` of them."""
    if last is not None:
        newest = _chosen(select(flights.c.entry), rocket, tag).order_by(*_order(connection, newest_first=True))
        entries = list(connection.scalars(newest.limit(last)))
    query = _chosen(select(flights), rocket, tag).order_by(_FLIGHT_DATE.nulls_first(), flights.c.entry)
    if since is not None:
        query = query.where(flights.c.date_time >= since.isoformat())
    if entries is not None and len(entries) <= MAX_ROWS_BY_NAME:
        query = query.where(flights.c.entry.in_(entries))
    stored = _all_stored(connection, query)
    if entries is not None and len(entries) > MAX_ROWS_BY_NAME:
        wanted = set(entries)
        stored = [one for one in stored if one.entry in wanted]
    return stored


def find(connection: Connection, identities: Sequence[Identity]) -> list[StoredFlight]:
    """The flights that have one of these identities now or had it when they were imported."""
    stored: list[StoredFlight] = []
    for start in range(0, len(identities), MAX_ROWS_BY_NAME):
        some = identities[start : start + MAX_ROWS_BY_NAME]
        entered = tuple_(*(flights.c.entered[name].as_string() for name in ("rocket", "flight_id")))
        now = select(flights.c.entry).where(tuple_(flights.c.rocket, flights.c.flight_id).in_(some))
        once = select(flights.c.entry).where(IS_EDITED, entered.in_(some))
        stored += _all_stored(connection, select(flights).where(flights.c.entry.in_(now.union(once))))
    return stored


def of_logs(connection: Connection, digests: Sequence[str]) -> list[StoredFlight]:
    """The flights read from logs with one of these digests."""
    stored: list[StoredFlight] = []
    for start in range(0, len(digests), MAX_ROWS_BY_NAME):
        some = digests[start : start + MAX_ROWS_BY_NAME]
        stored += _all_stored(connection, select(flights).where(flights.c.log_digest.in_(some)))
    return stored


def ever_of(connection: Connection, rocket: str) -> list[StoredFlight]:
    """The flights of a rocket, and those that were its flights when they were entered, latest entry first."""
    once = IS_EDITED & (flights.c.entered["rocket"].as_string() == rocket)
    query = select(flights).where((flights.c.rocket == rocket) | once).order_by(flights.c.entry.desc())
    return _all_stored(connection, query)


def _all_stored(connection: Connection, query: Select[Any]) -> list[StoredFlight]:
    return [_stored(row) for row in sound_flights(connection, query)]


def _stored(row: Row) -> StoredFlight:
    entered = row["entered"]
    once = flight_of(entered, entered["tags"]) if entered else None
    return StoredFlight(row["entry"], flight_of(row, row["tags"]), once, row["log_digest"])


def names(connection: Connection, field: str, rocket: str | None) -> list[str]:
    """The distinct values of one text field in the flights, most recent first. Raises DamagedRow."""
    column = flights.c[field]
    query = select(column).where(column != "").group_by(column).order_by(func.max(flights.c.entry).desc())
    return known_names(connection.scalars(query if rocket is None else query.where(flights.c.rocket == rocket)))


def rockets_flown(connection: Connection) -> list[str]:
    """Every rocket, that of the latest flight first; one without any date comes last. Raises DamagedRow."""
    flown = func.max(flights.c.date_time).desc().nulls_last(), func.max(flights.c.entry).desc()
    return known_names(connection.scalars(select(flights.c.rocket).group_by(flights.c.rocket).order_by(*flown)))


def first_day(connection: Connection) -> date | None:
    """The day of the earliest flight with a motor, a mass and an apogee; None without a dated one. Raises
    DamagedRow."""
    at, known = flights.c.date_time, (flights.c.date_time, flights.c.dry_mass, flights.c.apogee)
    wanted = [flights.c.motor != "", *(column.is_not(None) for column in known)]
    first = connection.scalar(select(at).where(*wanted).order_by(at).limit(1))
    return None if first is None else _day(first)


def contents(connection: Connection) -> Contents:
    """Numbers of flights, rockets and logs, and the days flown, as the database counts them. Raises DamagedRow."""
    at = flights.c.date_time
    columns = func.count(), func.count(flights.c.rocket.distinct()), func.min(at), func.max(at)
    count_all, rockets, first, last = connection.execute(select(*columns).select_from(flights)).one()
    with_log = connection.scalar(select(func.count()).where(flights.c.log != "")) or 0
    return Contents(count_all, rockets, None if first is None else (_day(first), _day(last)), with_log)


def _day(moment: str) -> date:
    """The day of a stored moment. Raises DamagedRow."""
    try:
        return datetime.fromisoformat(moment).date()
    except (TypeError, ValueError) as error:
        raise DamagedRow(f"found the date {moment!r}, expected one such as 2026-05-01T10:30") from error


def elevations(connection: Connection) -> dict[str, float]:
    """The elevation of every site in the flights, as recorded latest. [m] Raises DamagedRow."""
    known = select(flights.c.site, flights.c.site_elevation).where(flights.c.site_elevation.is_not(None))
    rows = connection.execute(known.order_by(_FLIGHT_DATE.nulls_first(), flights.c.entry))
    found = {row.site: row.site_elevation for row in rows}
    known_names(found)
    if not all(isinstance(elevation, float) for elevation in found.values()):
        raise DamagedRow("found an elevation that is no number")
    return found


def latest(connection: Connection, rocket: str | None, config: str | None) -> Flight | None:
    """The most recently entered flight."""
    wanted = {flights.c.rocket: rocket, flights.c.config: config}
    where = [column == value for column, value in wanted.items() if value is not None]
    entry = connection.scalar(select(func.max(flights.c.entry)).where(*where))
    return load(connection, entries=[entry])[0].flight if entry else None


def next_flight_id(connection: Connection, rocket: str) -> str:
    """One more than the highest number among a rocket's flight ids. Raises DamagedRow."""
    taken = set(known_names(connection.scalars(select(flights.c.flight_id).where(flights.c.rocket == rocket))))
    last = max((number for one in taken if (number := whole_number(one)) is not None), default=0)
    return next(id for id in map(str, count(last + 1)) if id not in taken)
