"""Flights read from a ledger: listed, named, with their logs, and in earlier states."""

from collections.abc import Iterator, Sequence

from fieldkit.flight import Flight
from fieldkit.ledger import finding, logs, naming, past
from fieldkit.ledger.opened import OpenLedger
from fieldkit.ledger.records import FlightSummary, Past
from fieldkit.ledger.rows import Row, flight_of, summary_of


class FlightsOut(OpenLedger):
    """Reading a ledger."""

    def flights(
        self, rocket: str | None = None, ids: Sequence[str] | None = None, tag: str | None = None
    ) -> list[Flight]:
        """Flights in the order flown; of one rocket, named by id, with a tag.

        That is by date and then by entry; one without a date comes after those of its rocket that were entered
        before it.
        """
        with self._reading() as connection:
            entries = None if ids is None else [held.entry for held in naming.resolve_all(connection, ids)]
            return [held.flight for held in finding.load(connection, rocket=rocket, tag=tag, entries=entries)]

    def pages(self, rocket: str | None = None, tag: str | None = None) -> Iterator[list[tuple[str, Flight]]]:
        """The same flights some at a time, each with the id that names it; all of one state of the ledger."""
        for page in self._named_pages(rocket, tag):
            yield [(name, flight_of(row, row["tags"])) for name, row in page]

    def summaries(self, rocket: str | None = None, tag: str | None = None) -> Iterator[list[FlightSummary]]:
        """What a list shows of the same flights, some at a time: a third less work than whole flights."""
        for page in self._named_pages(rocket, tag):
            yield [summary_of(name, row) for name, row in page]

    def _named_pages(self, rocket: str | None, tag: str | None) -> Iterator[list[tuple[str, Row]]]:
        with self._reading() as connection:
            for rows in finding.row_pages(connection, rocket=rocket, tag=tag):
                names = naming.ids(connection, [(row["rocket"], row["flight_id"]) for row in rows])
                yield [(names[row["rocket"], row["flight_id"]], row) for row in rows]

    def flight(self, id: str) -> Flight:
        """The flight with this id: its flight_id if that is unique, else `rocket/flight_id`.

        Raises LedgerError that suggests near ones, or lists those that it may mean.
        """
        with self._reading() as connection:
            return naming.resolve(connection, id).flight

    def entered(self, id: str) -> Flight | None:
        """A flight as it was imported, None if it was not edited since."""
        with self._reading() as connection:
            return naming.resolve(connection, id).entered

    def ids(self, flights: Sequence[Flight]) -> list[str]:
        """The id that names each of these flights of the ledger."""
        identities = [(flight.rocket, flight.flight_id) for flight in flights]
        with self._reading() as connection:
            names = naming.ids(connection, identities)
        return [names[identity] for identity in identities]

    def log(self, id: str) -> bytes | None:
        """The original bytes of a flight's log, or None if there is none."""
        with self._reading() as connection:
            return logs.log_of(connection, naming.resolve(connection, id))

    def other_logs(self, id: str) -> list[bytes]:
        """The original bytes of the other files that a flight's logger wrote of it."""
        with self._reading() as connection:
            return logs.other_logs_of(connection, naming.resolve(connection, id))

    def names(self, field: str, rocket: str | None = None) -> list[str]:
        """Every `rocket`, `config`, `motor` or `site` named in the flights, most recent first."""
        with self._reading() as connection:
            return finding.names(connection, field, rocket)

    def latest(self, rocket: str | None = None, config: str | None = None) -> Flight | None:
        """The flight entered last, whose setup the next one is likely to share."""
        with self._reading() as connection:
            return finding.latest(connection, rocket, config)

    def next_flight_id(self, rocket: str) -> str:
        """The next free number, as a flight_id, for a rocket."""
        with self._reading() as connection:
            return finding.next_flight_id(connection, rocket)

    def before(self, flights: Sequence[Flight]) -> list[Past]:
        """The state of the rocket of each of these flights just before the flight was added."""
        if not flights:
            return []
        with self._reading() as connection:
            return past.before(connection, flights)
