"""Queries for flights: lists, ids, logs, and earlier states."""

from collections.abc import Iterator, Sequence

from fieldkit.flight import Flight
from fieldkit.ledger import finding, logs, naming, past
from fieldkit.ledger.opened import OpenLedger
from fieldkit.ledger.records import FlightSummary, Past
from fieldkit.ledger.rows import Row, flight_of, summary_of


class FlightsOut(OpenLedger):
    """The queries of a ledger. Each raises LedgerError if the ledger cannot be read, or if an id is unknown."""

    def flights(
        self, rocket: str | None = None, ids: Sequence[str] | None = None, tag: str | None = None
    ) -> list[Flight]:
        """Flights in the order flown; of one rocket, with these ids, with a tag.

        They are sorted by date and then by entry; a flight without a date comes after the flights of its rocket that
        were entered earlier.
        """
        with self._reading() as connection:
            entries = None if ids is None else [stored.entry for stored in naming.resolve_all(connection, ids)]
            return [stored.flight for stored in finding.load(connection, rocket=rocket, tag=tag, entries=entries)]

    def pages(self, rocket: str | None = None, tag: str | None = None) -> Iterator[list[tuple[str, Flight]]]:
        """The same flights page by page, each with its id; all from one state of the ledger."""
        for page in self._named_pages(rocket, tag):
            yield [(name, flight_of(row, row["tags"])) for name, row in page]

    def summaries(self, rocket: str | None = None, tag: str | None = None) -> Iterator[list[FlightSummary]]:
        """List entries of the same flights, page by page: a third less work than whole flights."""
        for page in self._named_pages(rocket, tag):
            yield [summary_of(name, row) for name, row in page]

    def _named_pages(self, rocket: str | None, tag: str | None) -> Iterator[list[tuple[str, Row]]]:
        with self._reading() as connection:
            for rows in finding.row_pages(connection, rocket=rocket, tag=tag):
                names = naming.ids(connection, [(row["rocket"], row["flight_id"]) for row in rows])
                yield [(names[row["rocket"], row["flight_id"]], row) for row in rows]

    def flight(self, id: str) -> Flight:
        """The flight with this id: its flight_id if unique, else `rocket/flight_id`.

        Raises LedgerError that suggests similar ids, or lists the matches.
        """
        with self._reading() as connection:
            return naming.resolve(connection, id).flight

    def entered(self, id: str) -> Flight | None:
        """A flight as it was imported, None if it was not edited since."""
        with self._reading() as connection:
            return naming.resolve(connection, id).entered

    def forms(self, rocket: str) -> Iterator[tuple[Flight, Flight]]:
        """The flights that a rocket has or had, latest entry first: each as it is now, beside itself and, if it was
        edited since, beside its form as entered."""
        with self._reading() as connection:
            for stored in finding.ever_of(connection, rocket):
                yield from ((stored.flight, form) for form in (stored.flight, stored.entered) if form is not None)

    def ids(self, flights: Sequence[Flight]) -> list[str]:
        """The id of each of these flights of the ledger."""
        identities = [(flight.rocket, flight.flight_id) for flight in flights]
        with self._reading() as connection:
            names = naming.ids(connection, identities)
        return [names[identity] for identity in identities]

    def log(self, id: str) -> bytes | None:
        """The original bytes of a flight's log, or None if there is none."""
        with self._reading() as connection:
            return logs.log_of(connection, naming.resolve(connection, id))

    def other_logs(self, id: str) -> list[bytes]:
        """The original bytes of a flight's additional files."""
        with self._reading() as connection:
            return logs.other_logs_of(connection, naming.resolve(connection, id))

    def names(self, field: str, rocket: str | None = None) -> list[str]:
        """Every `rocket`, `config`, `motor` or `site` in the flights, most recent first."""
        with self._reading() as connection:
            return finding.names(connection, field, rocket)

    def latest(self, rocket: str | None = None, config: str | None = None) -> Flight | None:
        """The most recently entered flight, whose setup the next one probably shares."""
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
