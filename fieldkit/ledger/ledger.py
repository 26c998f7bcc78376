"""`Ledger`: stores and returns flights, model versions, forecasts, configurations of rockets and drafts; every command
can be undone.

It is read in one consistent state. Every method that makes changes is one transaction: it is applied completely or not
at all, even in a power failure. Each raises LedgerError if the ledger cannot be read or written, or for an unknown id.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from datetime import date
from pathlib import Path
from types import TracebackType
from typing import Any

from sqlalchemy import Connection, Engine

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.importing.incoming import IncomingFlight
from fieldkit.ledger import book, drafts, finding, journal, logs, models, naming, opening, past, rockets, whereabouts
from fieldkit.ledger.drafts import Content
from fieldkit.ledger.journal import Change, ChangeRecorder, UndoStep
from fieldkit.ledger.records import (
    Added,
    Contents,
    FlightSummary,
    NewPrediction,
    Past,
    Renewal,
    StoredPrediction,
    Version,
)
from fieldkit.ledger.rows import Row, flight_of, merged, summary_of
from fieldkit.rocket import Configuration, Rocket


class Ledger:
    """An open ledger; use it in a `with` statement. Get one from `Ledger.open`."""

    def __init__(self, engine: Engine, name: str) -> None:
        self._engine = engine
        self.name = name
        self.trouble = ""
        """Why the backup before a change failed, empty if it did not; the change was made anyway."""
        self.remarks: list[str] = []
        """Remarks on the ledger's flights for the user, one line each, in the order found."""
        self.own_changes: set[int] = set()
        """Numbers of the changes made through this object."""

    @classmethod
    def open(cls, where: str | Path | None = None) -> "Ledger":
        """Open the ledger at a path or URL; create or upgrade it if needed.

        None means FIELDKIT_LEDGER, or the file in the user's data folder. Raises LedgerError.
        """
        url = whereabouts.location(where)
        engine = opening.connect(url)
        try:
            opening.bring_up_to_date(engine)
            opening.never_recreate(engine)
        except BaseException:
            engine.dispose()
            raise
        return cls(engine, whereabouts.name_of(url))

    def __enter__(self) -> "Ledger":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def remark(self, *lines: str) -> None:
        """Add a remark on the flights, once."""
        self.remarks += [line for line in dict.fromkeys(lines) if line not in self.remarks]

    def close(self) -> None:
        """Close the file or the connection."""
        self._engine.dispose()

    def _reading(self) -> AbstractContextManager[Connection]:
        return opening.reading(self._engine)

    @contextmanager
    def _writing(self, *, keep: bool = True) -> Iterator[Connection]:
        missed = opening.keep_backup(self._engine) if keep else ""
        with opening.writing(self._engine, keep=keep) as connection:
            yield connection
        self.trouble = missed or self.trouble

    @contextmanager
    def _changing(self, *, keep: bool = True) -> Iterator[ChangeRecorder]:
        with self._writing(keep=keep) as connection:
            recorder = ChangeRecorder(connection)
            yield recorder
        if keep and recorder.number is not None:
            self.own_changes.add(recorder.number)

    def add(
        self,
        flights: Iterable[Flight | IncomingFlight],
        *,
        command: str = "import",
        draft: str | None = None,
        renewals: Sequence[Renewal] = (),
        dry_run: bool = False,
    ) -> Added:
        """Add flights.

        A flight that is in the ledger, in its current or its imported state, is a duplicate and changes nothing; so is
        a flight from the same bytes, whatever a newer parser reads from them. A flight that exists with other content,
        or that cannot be stored, is a conflict. `renewals` are stored flights updated from additional files. `draft` is
        the draft that these flights complete: it is deleted with the import, and restored if the import is undone. A
        dry run reports what would happen. Raises LedgerError if the ledger cannot be written.
        """
        incoming_flights = [one if isinstance(one, IncomingFlight) else IncomingFlight(one) for one in flights]
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
        return self._alter(id, "edit", f"({', '.join(changes)})", lambda flight: _edited(flight, changes))

    def edit_all(
        self, ids: Sequence[str], what: str, beside: Mapping[str, Content] | None = None, /, **changes: object
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

    def edit_each(
        self,
        changes: Mapping[str, Mapping[str, object]],
        command: str,
        what: str,
        corrections: Mapping[str, Version] | None = None,
    ) -> int:
        """Change fields of several flights, each its own, and move the models in use of other rockets in `corrections`
        to those that it names, as one change of a `command`, which `what` describes after their ids; returns the number
        of flights changed."""
        with self._changing() as recorder:
            stored = naming.resolve_all(recorder.connection, list(changes))
            done = [
                id
                for one, (id, own) in zip(stored, changes.items(), strict=True)
                if book.replace(recorder, one, _edited(one.flight, own))
            ]
            for rocket, version in (corrections or {}).items():
                models.activate(recorder, version.rocket, None)
                models.keep_version(recorder, rocket, version.payload, activate=True)
            if done:
                recorder.sign(command, f"{_listed(done)} {what}")
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

        return self._alter(id, "tag", " ".join(tags), tagged)

    def untag(self, id: str, *tags: str) -> Flight:
        """Remove tags from a flight. Raises LedgerError for a tag that it does not have."""

        def untagged(flight: Flight) -> Flight:
            for tag in tags:
                if tag not in flight.tags:
                    raise LedgerError(f"{id} has no tag {tag!r}, it has {', '.join(flight.tags) or 'none'}")
            return flight.with_changes(tags=tuple(tag for tag in flight.tags if tag not in tags))

        return self._alter(id, "untag", " ".join(tags), untagged)

    def _alter(self, id: str, command: str, what: str, change: Callable[[Flight], Flight]) -> Flight:
        with self._changing() as recorder:
            stored = naming.resolve(recorder.connection, id)
            (name,), flight = naming.ids_of(recorder.connection, [stored]), change(stored.flight)
            if book.replace(recorder, stored, flight):
                recorder.sign(command, f"{name} {what}")
        return flight

    def remove(self, *ids: str) -> list[Flight]:
        """Remove flights and return them; `undo` restores them."""
        with self._changing() as recorder:
            gone = list({stored.entry: stored for stored in naming.resolve_all(recorder.connection, ids)}.values())
            names = naming.ids_of(recorder.connection, gone)
            for stored in gone:
                book.remove(recorder, stored)
            if gone:
                recorder.sign("remove", _listed(names))
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

    def flights(
        self,
        rocket: str | None = None,
        ids: Sequence[str] | None = None,
        tag: str | None = None,
        since: date | None = None,
        last: int | None = None,
    ) -> list[Flight]:
        """Flights in the order flown; of one rocket, with these ids, with a tag, flown since a day, the `last` ones.

        They are sorted by date and then by entry; a flight without a date comes after the flights of its rocket that
        were entered earlier.
        """
        with self._reading() as connection:
            entries = None if ids is None else [stored.entry for stored in naming.resolve_all(connection, ids)]
            found = finding.load(connection, rocket=rocket, tag=tag, entries=entries, since=since, last=last)
        return [stored.flight for stored in found]

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

    def ids_meant(self, texts: Sequence[str]) -> list[str]:
        """The ids that typed texts stand for: all flights of a rocket for its name, else the text itself."""
        with self._reading() as connection:
            return naming.ids_meant(connection, texts)

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

    def rockets_flown(self) -> list[str]:
        """Every rocket in the flights, that of the latest flight first; one without any date comes last."""
        with self._reading() as connection:
            return finding.rockets_flown(connection)

    def contents(self) -> Contents:
        """Numbers of flights, rockets and logs, and the days flown, without reading a flight."""
        with self._reading() as connection:
            return finding.contents(connection)

    def first_day(self) -> date | None:
        """The day of the earliest flight with a motor, a mass and an apogee; None without a dated one."""
        with self._reading() as connection:
            return finding.first_day(connection)

    def elevations(self) -> dict[str, float]:
        """The elevation of every site in the flights, as recorded latest. [m]"""
        with self._reading() as connection:
            return finding.elevations(connection)

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

    def keep_version(self, rocket: str, payload: Mapping[str, Any], *, activate: bool = True) -> Version:
        """Save a model of a rocket under the next number, and activate it by default."""
        with self._changing() as recorder:
            version = models.keep_version(recorder, rocket, payload, activate=activate)
            recorder.sign("model", f"version {version.number} of {rocket}" + (", in use" if activate else ""))
        return version

    def versions(self, rocket: str) -> list[Version]:
        """The saved model versions of a rocket, oldest first."""
        with self._reading() as connection:
            return models.versions(connection, rocket)

    def active_version(self, rocket: str) -> Version | None:
        """The active model version of a rocket; None for the plain model."""
        return next((version for version in self.versions(rocket) if version.active), None)

    def activate(self, rocket: str, number: int | None) -> None:
        """Activate another saved model version of a rocket, or with None the plain model.

        Raises LedgerError if the number is not among its versions.
        """
        with self._changing() as recorder:
            if models.activate(recorder, rocket, number):
                recorder.sign("model", f"{rocket} uses " + (f"version {number}" if number else "no correction"))

    def keep_prediction(
        self, payload: Mapping[str, Any], *, digest: str, rocket: str = "", flight_id: str = ""
    ) -> StoredPrediction:
        """Save a prediction, once per digest, flight and payload.

        It is a record and not a change by the user, so `undo` skips it.
        """
        with opening.writing(self._engine) as connection:
            return models.keep_prediction(connection, payload, digest, rocket, flight_id)

    def keep_predictions(self, made: Sequence[NewPrediction]) -> None:
        """Save several predictions as in `keep_prediction`, all or none."""
        with opening.writing(self._engine) as connection:
            for one in made:
                models.keep_prediction(connection, one.payload, one.digest, one.rocket, one.flight_id)

    def keep_plan(
        self, payload: Mapping[str, Any], *, digest: str, what: str, rocket: str = "", flight_id: str = ""
    ) -> StoredPrediction:
        """Save the prediction of a planned flight; `what` names it in the history, and `undo` undoes it."""
        with self._changing() as recorder:
            kept = models.keep_plan(recorder, payload, digest, rocket, flight_id)
            if recorder.has_changes:
                recorder.sign("forecast", what)
        return kept

    def predictions(self, rocket: str | None = None, flight_id: str | None = None) -> list[StoredPrediction]:
        """The saved predictions of all rockets, of one rocket, or for one flight, oldest first."""
        with self._reading() as connection:
            return models.predictions(connection, rocket, flight_id)

    def keep_design(self, design: Configuration) -> bool:
        """Save the design of a configuration, replacing an older one; False if it is a duplicate. What was weighed and
        measured is kept. Raises BadValue for names that not every kind of ledger can store."""
        with self._changing() as recorder:
            if changed := rockets.keep(recorder, design.rocket, design.config, rockets.design_of(design)):
                recorder.sign("ork", " ".join((design.rocket, design.config)).strip() + f" from {design.source}")
        return changed

    def rocket(self, name: str) -> Rocket:
        """A rocket with what is known of its configurations apart from its flights."""
        with self._reading() as connection:
            return Rocket(name, tuple(rockets.configurations_of(connection, name)))

    def rockets(self) -> list[Rocket]:
        """The rockets of which something is known apart from their flights, by name."""
        with self._reading() as connection:
            return [Rocket(name, tuple(own)) for name, own in rockets.by_rocket(connection).items()]

    def keep_draft(self, name: str, content: Content) -> None:
        """Save a draft under a name, replacing the previous one; see `drafts.Content`."""
        with opening.writing(self._engine) as connection:
            drafts.keep(connection, name, content)

    def change_draft(self, name: str, content: Content, command: str, what: str) -> bool:
        """Save a document under a name as a change that `undo` undoes; False if it is unchanged."""
        with self._changing() as recorder:
            if changed := drafts.change(recorder, name, content):
                recorder.sign(command, what)
        return changed

    def change_drafts(
        self, contents: Mapping[str, Content], command: str, what: str, stated: Sequence[Configuration] = ()
    ) -> bool:
        """Save several documents, as in `change_draft`, and the `stated` masses and diameters of configurations, as one
        change. Raises BadValue for names of configurations that not every kind of ledger can store."""
        with self._changing() as recorder:
            changed = [drafts.change(recorder, name, content) for name, content in contents.items()]
            changed += [rockets.keep(recorder, one.rocket, one.config, rockets.body_of(one)) for one in stated]
            if any(changed):
                recorder.sign(command, what)
        return any(changed)

    def draft(self, name: str) -> dict[str, Any] | None:
        """The draft under a name, or None."""
        with self._reading() as connection:
            return drafts.draft(connection, name)

    def drop_draft(self, name: str) -> bool:
        """Delete a draft, which `undo` restores; False if there is none."""
        with self._changing() as recorder:
            if dropped := drafts.put_away(recorder, name):
                recorder.sign("start over", "the unfinished flight")
        return dropped


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
