"""`Ledger`: flights go in and come out, and each command can be taken back.

Every method that changes something is one transaction: it happens as a whole or not at all, also when the
power goes. Each raises LedgerError where the ledger cannot be read or written.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

from sqlalchemy import Connection, Engine

from fieldkit.arrival import Arrival, Original
from fieldkit.errors import LedgerError
from fieldkit.flight import BY_NAME, Flight
from fieldkit.ledger import book, drafts, finding, journal, logs, models, naming, opening, past, starts
from fieldkit.ledger.journal import Change, Pen
from fieldkit.ledger.records import Added, Past, Prediction, Renewal, Start, Version


class Ledger:
    """An open ledger; use it in a `with`. Get one from `Ledger.open`."""

    def __init__(self, engine: Engine, name: str) -> None:
        self._engine = engine
        self.name = name
        self.trouble = ""
        """Why no backup could be made before a change, empty where one could; the change was made all the same."""

    @classmethod
    def open(cls, where: str | Path | None = None) -> "Ledger":
        """The ledger at a path or URL, made or upgraded where needed.

        None stands for FIELDKIT_LEDGER, or the file in the user's data folder.
        """
        url = opening.location(where)
        engine = opening.connect(url)
        try:
            opening.bring_up_to_date(engine)
        except BaseException:
            engine.dispose()
            raise
        return cls(engine, opening.name_of(url))

    def __enter__(self) -> "Ledger":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file or the server."""
        self._engine.dispose()

    # Flights

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

        A flight that is there already, as it is now or as it once came in, is a duplicate and changes
        nothing; so is one of the same bytes, whatever a newer parser reads in them. One that is there with
        other content, or cannot be kept, is a conflict. `renewals` are flights that further files came of.
        `draft` is one that these flights finish, dropped
        with them. A dry run says what would happen.
        """
        original = None if log is None else Original.of(log)
        arrivals = [one if isinstance(one, Arrival) else Arrival(one, original, source) for one in flights]
        with self._changing(keep=not dry_run) as pen:
            renewed = [one.id for one in renewals if _renew(pen, one)]
            added = book.add(pen, arrivals)
            if added.new or renewed:
                files = ", ".join(dict.fromkeys(Path(one.source).name for one in arrivals if one.source))
                more = [f"further files of {_listed(renewed)}"] if renewed else []
                what = [_listed(added.new) + (f" from {files}" if files else "")] if added.new else []
                pen.sign(command, "; ".join(what + more))
            if draft:
                drafts.drop(pen.connection, draft)
        return added

    def flights(
        self, rocket: str | None = None, ids: Sequence[str] | None = None, tag: str | None = None
    ) -> list[Flight]:
        """Flights by date and then by entry, those without a date last; of one rocket, named by id, with a tag."""
        with self._reading() as connection:
            entries = None if ids is None else [held.entry for held in naming.resolve_all(connection, ids)]
            return [held.flight for held in finding.load(connection, rocket=rocket, tag=tag, entries=entries)]

    def flight(self, id: str) -> Flight:
        """The flight with this id: its flight_id where that is unique, else `rocket/flight_id`.

        Raises LedgerError that suggests near ones, or lists those that it may mean.
        """
        with self._reading() as connection:
            return naming.resolve(connection, id).flight

    def entered(self, id: str) -> Flight | None:
        """A flight as it came in, None where it was not edited since."""
        with self._reading() as connection:
            return naming.resolve(connection, id).entered

    def ids(self, flights: Sequence[Flight]) -> list[str]:
        """The id that names each of these flights of the ledger."""
        identities = [(flight.rocket, flight.flight_id) for flight in flights]
        with self._reading() as connection:
            names = naming.ids(connection, identities)
        return [names[identity] for identity in identities]

    def log(self, id: str) -> bytes | None:
        """The original bytes of a flight's log, or None where there is none."""
        with self._reading() as connection:
            return logs.log_of(connection, naming.resolve(connection, id))

    def other_logs(self, id: str) -> list[bytes]:
        """The original bytes of the other files that a flight's logger wrote of it."""
        with self._reading() as connection:
            return logs.other_logs_of(connection, naming.resolve(connection, id))

    def names(self, field: str, rocket: str | None = None) -> list[str]:
        """Every `rocket`, `config`, `motor` or `site` that flights name, the last used first."""
        with self._reading() as connection:
            return finding.names(connection, field, rocket)

    def latest(self, rocket: str | None = None, config: str | None = None) -> Flight | None:
        """The flight entered last, whose set-up the next one is likely to share."""
        with self._reading() as connection:
            return finding.latest(connection, rocket, config)

    def next_flight_id(self, rocket: str) -> str:
        """The next free number, as a flight_id, for a rocket."""
        with self._reading() as connection:
            return finding.next_flight_id(connection, rocket)

    def edit(self, id: str, **changes: object) -> Flight:
        """Change fields of a flight and return it. Raises LedgerError when another bears the new name."""
        what = f"{id} ({', '.join(changes)})"
        return self._alter(id, "edit", what, lambda flight: _edited(flight, changes))

    def edit_all(self, ids: Sequence[str], what: str, **changes: object) -> int:
        """Change fields of several flights as one command, named by `what`; how many it changed."""
        with self._changing() as pen:
            held = naming.resolve_all(pen.connection, ids)
            done = sum(book.replace(pen, one, _edited(one.flight, changes)) for one in held)
            if done:
                pen.sign("edit", f"{what} ({', '.join(changes)})")
        return done

    def renew(self, renewals: Sequence[Renewal], command: str = "remeasure", *, dry_run: bool = False) -> int:
        """Take over what the files of flights say now, as one command; how many flights it changed."""
        with self._changing(keep=not dry_run) as pen:
            done = [one.id for one in renewals if _renew(pen, one)]
            if done:
                pen.sign(command, _listed(done))
        return len(done)

    def tag(self, id: str, *tags: str) -> Flight:
        """Put tags on a flight, each once."""

        def tagged(flight: Flight) -> Flight:
            return flight.with_changes(tags=tuple(dict.fromkeys((*flight.tags, *tags))))

        return self._alter(id, "tag", f"{id} {' '.join(tags)}", tagged)

    def untag(self, id: str, *tags: str) -> Flight:
        """Take tags off a flight. Raises LedgerError for one that it does not bear."""

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
        """Take flights out and return them; `undo` brings them back."""
        with self._changing() as pen:
            gone = list({held.entry: held for held in naming.resolve_all(pen.connection, ids)}.values())
            for held in gone:
                book.remove(pen, held)
            if gone:
                pen.sign("remove", _listed(ids))
        return [held.flight for held in gone]

    # The journal

    def undo(self) -> Change:
        """Take back the last change in force and return it. Raises LedgerError when nothing is left."""
        with self._writing() as connection:
            return replace(journal.undo(connection), undone=True)

    def redo(self) -> Change:
        """Do again what was undone last. Raises LedgerError when nothing was, or a change came between."""
        with self._writing() as connection:
            return journal.redo(connection)

    def history(self) -> list[Change]:
        """Every change, undo and redo, oldest first."""
        with self._reading() as connection:
            return journal.history(connection)

    # Models and what they said

    def keep_version(self, rocket: str, payload: Mapping[str, Any], *, activate: bool = True) -> Version:
        """Keep a model of a rocket, under the next number, and predict with it from now on."""
        with self._changing() as pen:
            version = models.keep_version(pen, rocket, payload, activate=activate)
            pen.sign("model", f"version {version.number} of {rocket}" + (", in use" if activate else ""))
        return version

    def versions(self, rocket: str) -> list[Version]:
        """The models kept for a rocket, oldest first."""
        with self._reading() as connection:
            return models.versions(connection, rocket)

    def active_version(self, rocket: str) -> Version | None:
        """The model that predictions for a rocket use; None for the one every rocket starts with."""
        return next((version for version in self.versions(rocket) if version.active), None)

    def activate(self, rocket: str, number: int | None) -> None:
        """Predict with another kept model of a rocket, or with None of them.

        Raises LedgerError for a number that is not among its versions.
        """
        with self._changing() as pen:
            if models.activate(pen, rocket, number):
                pen.sign("model", f"{rocket} uses " + (f"version {number}" if number else "the first model"))

    def keep_prediction(
        self, payload: Mapping[str, Any], *, digest: str, rocket: str = "", flight_id: str = ""
    ) -> Prediction:
        """Keep a prediction, once for the same digest, flight and payload.

        It is a record of what was said and no change of the flyer's, so `undo` passes it by.
        """
        with opening.writing(self._engine) as connection:
            return models.keep_prediction(connection, payload, digest, rocket, flight_id)

    def predictions(self, rocket: str | None = None, flight_id: str | None = None) -> list[Prediction]:
        """The predictions made, oldest first; of one rocket, or for one flight."""
        with self._reading() as connection:
            return models.predictions(connection, rocket, flight_id)

    def before(self, flights: Sequence[Flight]) -> list[Past]:
        """How the rocket of each of these flights stood just before the flight came in."""
        if not flights:
            return []
        with self._reading() as connection:
            return past.before(connection, flights)

    def keep_start(self, start: Start) -> bool:
        """Keep a starting configuration in place of an older one; False where it is there already."""
        with self._changing() as pen:
            if kept := starts.keep(pen, start):
                pen.sign("ork", " ".join((start.rocket, start.config)).strip() + f" from {start.source}")
        return kept

    def starts(self, rocket: str) -> list[Start]:
        """The starting configurations of a rocket, by name."""
        with self._reading() as connection:
            return starts.starts(connection, rocket)

    # Drafts

    def keep_draft(self, name: str, content: Mapping[str, Any]) -> None:
        """Keep what was typed so far under a name, in place of what was there."""
        with opening.writing(self._engine) as connection:
            drafts.keep(connection, name, content)

    def draft(self, name: str) -> dict[str, Any] | None:
        """What was typed so far, or None."""
        with self._reading() as connection:
            return drafts.draft(connection, name)

    def drop_draft(self, name: str) -> None:
        """Forget a draft, if there is one."""
        with opening.writing(self._engine) as connection:
            drafts.drop(connection, name)

    def _reading(self) -> AbstractContextManager[Connection]:
        return opening.reading(self._engine)

    @contextmanager
    def _writing(self, *, keep: bool = True) -> Iterator[Connection]:
        if keep:
            self.trouble = opening.keep_backup(self._engine) or self.trouble
        with opening.writing(self._engine, keep=keep) as connection:
            yield connection

    @contextmanager
    def _changing(self, *, keep: bool = True) -> Iterator[Pen]:
        with self._writing(keep=keep) as connection:
            yield Pen(connection)


def _renew(pen: Pen, one: Renewal) -> bool:
    return book.renew(pen, naming.resolve(pen.connection, one.id), one.flight, one.entered, one.others)


def _edited(flight: Flight, changes: Mapping[str, object]) -> Flight:
    """A flight with some fields changed; a figure that was typed has no uncertainty of a measurement."""
    typed = {BY_NAME[name].sd_header for name in changes if name in BY_NAME and changes[name] != flight.number(name)}
    edited = flight.with_changes(**changes)
    return edited.with_changes(extra={name: text for name, text in edited.extra.items() if name not in typed})


def _listed(ids: Sequence[str], most: int = 4) -> str:
    more = len(ids) - most
    return ", ".join(ids[:most]) + (f" and {more} more" if more > 0 else "")
