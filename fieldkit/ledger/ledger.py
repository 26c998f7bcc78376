"""`Ledger`: stores and returns flights; every command can be undone.

Every method that makes changes is one transaction: it is applied completely or not at all, even in a power failure.
Each raises LedgerError if the ledger cannot be read or written, or if an id is unknown. Queries for flights are in
`shown.py`, other records in `beside.py`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger import book, drafts, journal, naming
from fieldkit.ledger.beside import BesideFlights
from fieldkit.ledger.journal import Change, ChangeRecorder, UndoStep
from fieldkit.ledger.records import Added, Renewal
from fieldkit.ledger.rows import merged
from fieldkit.ledger.shown import FlightsOut


class Ledger(FlightsOut, BesideFlights):
    """An open ledger; use it in a `with` statement. Get one from `Ledger.open`."""

    def add(
        self,
        flights: Iterable[Flight | IncomingFlight],
        *,
        log: bytes | None = None,
        source: str = "",
        command: str = "import",
        draft: str | None = None,
        renewals: Sequence[Renewal] = (),
        dry_run: bool = False,
    ) -> Added:
        """Add flights; `log` and `source` apply to those that do not come with their own.

        A flight that is in the ledger, in its current or its imported state, is a duplicate and changes nothing; so is
        a flight from the same bytes, whatever a newer parser reads from them. A flight that exists with other content,
        or that cannot be stored, is a conflict. `renewals` are stored flights updated from additional files. `draft` is
        the draft that these flights complete: it is deleted with the import, and restored if the import is undone. A
        dry run reports what would happen. Raises LedgerError if the ledger cannot be written.
        """
        original = None if log is None else Original.of(log)
        incoming_flights = [
            one if isinstance(one, IncomingFlight) else IncomingFlight(one, original, source) for one in flights
        ]
        with self._changing(keep=not dry_run) as recorder:
            renewed = [one.id for one in renewals if _renew(recorder, one)]
            added = book.add(recorder, incoming_flights)
            if draft:
                drafts.put_away(recorder, draft)
            if added.new or renewed:
                files = _listed(list(dict.fromkeys(Path(one.source).name for one in incoming_flights if one.source)))
                more = [f"more files of {_listed(renewed)}"] if renewed else []
                what = [_listed(added.new) + (f" from {files}" if files else "")] if added.new else []
                recorder.sign(command, "; ".join(what + more))
        return added

    def edit(self, id: str, **changes: object) -> Flight:
        """Change fields of a flight and return it. Raises LedgerError if another flight has the new name, BadValue."""
        what = f"{id} ({', '.join(changes)})"
        return self._alter(id, "edit", what, lambda flight: _edited(flight, changes))

    def edit_all(
        self, ids: Sequence[str], what: str, beside: Mapping[str, drafts.Content] | None = None, /, **changes: object
    ) -> int:
        """Change fields of several flights, and the drafts `beside`, as one change named `what`; returns the number of
        flights changed."""
        with self._changing() as recorder:
            stored = naming.resolve_all(recorder.connection, ids) if changes else []
            done = sum(book.replace(recorder, one, _edited(one.flight, changes)) for one in stored)
            kept = [name for name, content in (beside or {}).items() if drafts.change(recorder, name, content)]
            if done or kept:
                recorder.sign("edit", f"{what} ({', '.join([*changes, *kept])})")
        return done

    def edit_each(self, changes: Mapping[str, Mapping[str, object]], command: str, what: str) -> int:
        """Change fields of several flights, each its own, as one change of a `command`; returns the number of flights
        changed."""
        with self._changing() as recorder:
            stored = naming.resolve_all(recorder.connection, list(changes))
            done = [
                id
                for one, (id, own) in zip(stored, changes.items(), strict=True)
                if book.replace(recorder, one, _edited(one.flight, own))
            ]
            if done:
                recorder.sign(command, f"{_listed(done)} from {what}")
        return len(done)

    def renew(self, renewals: Sequence[Renewal], command: str = "remeasure", *, dry_run: bool = False) -> int:
        """Update flights from their files as one change; returns the number of flights changed."""
        with self._changing(keep=not dry_run) as recorder:
            done = [one.id for one in renewals if _renew(recorder, one)]
            if done:
                recorder.sign(command, _listed(done))
        return len(done)

    def tag(self, id: str, *tags: str) -> Flight:
        """Add tags to a flight, each once."""

        def tagged(flight: Flight) -> Flight:
            return flight.with_changes(tags=tuple(dict.fromkeys((*flight.tags, *tags))))

        return self._alter(id, "tag", f"{id} {' '.join(tags)}", tagged)

    def untag(self, id: str, *tags: str) -> Flight:
        """Remove tags from a flight. Raises LedgerError for a tag that it does not have."""

        def untagged(flight: Flight) -> Flight:
            for tag in tags:
                if tag not in flight.tags:
                    raise LedgerError(f"{id} has no tag {tag!r}, it has {', '.join(flight.tags) or 'none'}")
            return flight.with_changes(tags=tuple(tag for tag in flight.tags if tag not in tags))

        return self._alter(id, "untag", f"{id} {' '.join(tags)}", untagged)

    def _alter(self, id: str, command: str, what: str, change: Callable[[Flight], Flight]) -> Flight:
        with self._changing() as recorder:
            stored = naming.resolve(recorder.connection, id)
            flight = change(stored.flight)
            if book.replace(recorder, stored, flight):
                recorder.sign(command, what)
        return flight

    def remove(self, *ids: str) -> list[Flight]:
        """Remove flights and return them; `undo` restores them."""
        with self._changing() as recorder:
            gone = list({stored.entry: stored for stored in naming.resolve_all(recorder.connection, ids)}.values())
            for stored in gone:
                book.remove(recorder, stored)
            if gone:
                recorder.sign("remove", _listed(ids))
        return [stored.flight for stored in gone]

    def undo_step(self) -> UndoStep:
        """What `undo` would undo. Raises LedgerError if there is nothing."""
        with self._reading() as connection:
            step = journal.undo_step(connection)
        return replace(step, own=step.change.number in self.own_changes)

    def undo(self, number: int | None = None) -> Change:
        """Undo the last change and return it. Raises LedgerError if there is none, or if its number is not the one
        given."""
        with self._writing() as connection:
            return replace(journal.undo(connection, number), undone=True)

    def redo(self) -> Change:
        """Redo the last undone change. Raises LedgerError if there is none, or if another change came in between."""
        with self._writing() as connection:
            return journal.redo(connection)

    def length(self) -> int:
        """Number of changes: a different number means that another process has changed the ledger."""
        with self._reading() as connection:
            return journal.length(connection)

    def history(self) -> list[Change]:
        """Every change, including undo and redo, oldest first."""
        with self._reading() as connection:
            return journal.history(connection)


def _renew(recorder: ChangeRecorder, one: Renewal) -> bool:
    stored = naming.resolve(recorder.connection, one.id)
    return book.renew(recorder, stored, merged(stored.flight, one.was, one.flight), one.entered, one.others)


def _edited(flight: Flight, changes: Mapping[str, object]) -> Flight:
    """A flight with some fields changed; an edited readout loses its measurement uncertainty."""
    edited = flight.with_changes(**changes)
    typed = [name for name, value in edited.readouts().items() if value != flight.number(name)]
    return edited.with_source(typed, "typed")


def _listed(ids: Sequence[str], most: int = 4) -> str:
    more = len(ids) - most
    return ", ".join(ids[:most]) + (f" and {more} more" if more > 0 else "")
