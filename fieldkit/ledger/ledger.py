"""`Ledger`: flights go in and come out, and each command can be taken back.

Every method that changes something is one transaction: it happens as a whole or not at all, also when the
power goes. Each raises LedgerError if the ledger cannot be read or written. What is asked of a ledger is in
`shown.py`, what it holds besides flights in `beside.py`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.importing.incoming import Arrival, Original
from fieldkit.ledger import book, drafts, journal, naming
from fieldkit.ledger.beside import BesideFlights
from fieldkit.ledger.journal import Change, ChangeRecorder
from fieldkit.ledger.records import Added, Renewal
from fieldkit.ledger.shown import FlightsOut


class Ledger(FlightsOut, BesideFlights):
    """An open ledger; use it in a `with`. Get one from `Ledger.open`."""

    def add(
        self,
        flights: Iterable[Flight | Arrival],
        *,
        log: bytes | None = None,
        source: str = "",
        command: str = "import",
        draft: str | None = None,
        renewals: Sequence[Renewal] = (),
        dry_run: bool = False,
    ) -> Added:
        """Take flights in; `log` and `source` are those of each that does not arrive with its own.

        A flight that is in the ledger, as it is now or as it was first imported, is a duplicate and changes
        nothing; so is one of the same bytes, whatever a newer parser reads in them. One that is there with
        other content, or cannot be kept, is a conflict. `renewals` are flights that further files came of.
        `draft` is one that these flights finish: it goes as they come, and comes back if they are taken back.
        A dry run says what would happen.
        """
        original = None if log is None else Original.of(log)
        arrivals = [one if isinstance(one, Arrival) else Arrival(one, original, source) for one in flights]
        with self._changing(keep=not dry_run) as pen:
            renewed = [one.id for one in renewals if _renew(pen, one)]
            added = book.add(pen, arrivals)
            if draft:
                drafts.put_away(pen, draft)
            if added.new or renewed:
                files = ", ".join(dict.fromkeys(Path(one.source).name for one in arrivals if one.source))
                more = [f"more files of {_listed(renewed)}"] if renewed else []
                what = [_listed(added.new) + (f" from {files}" if files else "")] if added.new else []
                pen.sign(command, "; ".join(what + more))
        return added

    def edit(self, id: str, **changes: object) -> Flight:
        """Change fields of a flight and return it. Raises LedgerError if another flight has the new name."""
        what = f"{id} ({', '.join(changes)})"
        return self._alter(id, "edit", what, lambda flight: _edited(flight, changes))

    def edit_all(
        self, ids: Sequence[str], what: str, beside: Mapping[str, Mapping[str, Any]] | None = None, /, **changes: object
    ) -> int:
        """Change fields of several flights, and drafts `beside` them, as one change named `what`; the number of flights
        changed."""
        with self._changing() as pen:
            held = naming.resolve_all(pen.connection, ids) if changes else []
            done = sum(book.replace(pen, one, _edited(one.flight, changes)) for one in held)
            kept = [name for name, content in (beside or {}).items() if drafts.change(pen, name, content)]
            if done or kept:
                pen.sign("edit", f"{what} ({', '.join([*changes, *kept])})")
        return done

    def renew(self, renewals: Sequence[Renewal], command: str = "remeasure", *, dry_run: bool = False) -> int:
        """Update flights from their files, as one change; the number of flights changed."""
        with self._changing(keep=not dry_run) as pen:
            done = [one.id for one in renewals if _renew(pen, one)]
            if done:
                pen.sign(command, _listed(done))
        return len(done)

    def tag(self, id: str, *tags: str) -> Flight:
        """Add tags to a flight, each once."""

        def tagged(flight: Flight) -> Flight:
            return flight.with_changes(tags=tuple(dict.fromkeys((*flight.tags, *tags))))

        return self._alter(id, "tag", f"{id} {' '.join(tags)}", tagged)

    def untag(self, id: str, *tags: str) -> Flight:
        """Remove tags from a flight. Raises LedgerError for one that it does not have."""

        def untagged(flight: Flight) -> Flight:
            for tag in tags:
                if tag not in flight.tags:
                    raise LedgerError(f"{id} has no tag {tag!r}, it has {', '.join(flight.tags) or 'none'}")
            return flight.with_changes(tags=tuple(tag for tag in flight.tags if tag not in tags))

        return self._alter(id, "untag", f"{id} {' '.join(tags)}", untagged)

    def _alter(self, id: str, command: str, what: str, change: Callable[[Flight], Flight]) -> Flight:
        with self._changing() as pen:
            held = naming.resolve(pen.connection, id)
            flight = change(held.flight)
            if book.replace(pen, held, flight):
                pen.sign(command, what)
        return flight

    def remove(self, *ids: str) -> list[Flight]:
        """Remove flights and return them; `undo` restores them."""
        with self._changing() as pen:
            gone = list({held.entry: held for held in naming.resolve_all(pen.connection, ids)}.values())
            for held in gone:
                book.remove(pen, held)
            if gone:
                pen.sign("remove", _listed(ids))
        return [held.flight for held in gone]

    def undo(self) -> Change:
        """Undo the last change and return it. Raises LedgerError if there is none."""
        with self._writing() as connection:
            return replace(journal.undo(connection), undone=True)

    def redo(self) -> Change:
        """Redo the last change that was undone. Raises LedgerError if there is none, or a change came between."""
        with self._writing() as connection:
            return journal.redo(connection)

    def length(self) -> int:
        """Number of changes: if it differs from before, somebody has changed the ledger."""
        with self._reading() as connection:
            return journal.length(connection)

    def history(self) -> list[Change]:
        """Every change, undo and redo, oldest first."""
        with self._reading() as connection:
            return journal.history(connection)


def _renew(pen: ChangeRecorder, one: Renewal) -> bool:
    return book.renew(pen, naming.resolve(pen.connection, one.id), one.flight, one.entered, one.others)


def _edited(flight: Flight, changes: Mapping[str, object]) -> Flight:
    """A flight with some fields changed; a typed readout loses the uncertainty of its measurement."""
    edited = flight.with_changes(**changes)
    typed = [name for name, value in edited.readouts().items() if value != flight.number(name)]
    return edited.with_source(typed, "typed")


def _listed(ids: Sequence[str], most: int = 4) -> str:
    more = len(ids) - most
    return ", ".join(ids[:most]) + (f" and {more} more" if more > 0 else "")
