"""Records of a ledger other than flights: models, predictions, starting configurations, drafts."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from sqlalchemy import Connection, and_, select

from fieldkit.flight.start import Start
from fieldkit.ledger import drafts, models, opening
from fieldkit.ledger.checksums import sound_rows
from fieldkit.ledger.drafts import Content
from fieldkit.ledger.opened import OpenLedger
from fieldkit.ledger.records import NewPrediction, StoredPrediction, Version
from fieldkit.ledger.rows import check_key
from fieldkit.ledger.tables import configurations

START_FIELDS = tuple(field.name for field in fields(Start))


class BesideFlights(OpenLedger):
    """Saving model versions, forecasts, starting configurations and drafts. Each method raises LedgerError if the
    ledger cannot be read or written."""

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
                recorder.sign("model", f"{rocket} uses " + (f"version {number}" if number else "the plain model"))

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
            if recorder.images:
                recorder.sign("forecast", what)
        return kept

    def predictions(self, rocket: str | None = None, flight_id: str | None = None) -> list[StoredPrediction]:
        """The saved predictions of all rockets, of one rocket, or for one flight, oldest first."""
        with self._reading() as connection:
            return models.predictions(connection, rocket, flight_id)

    def keep_start(self, start: Start) -> bool:
        """Save a starting configuration, replacing an older one; False if it is a duplicate. Raises BadValue for names
        that not every kind of ledger can store."""
        check_key("rocket and config", start.rocket + start.config)
        with self._changing() as recorder:
            if start in _starts(recorder.connection, start.rocket):
                return False
            named = and_(configurations.c.rocket == start.rocket, configurations.c.config == start.config)
            recorder.delete(configurations, named)
            recorder.insert(configurations, [asdict(start)])
            recorder.sign("ork", " ".join((start.rocket, start.config)).strip() + f" from {start.source}")
        return True

    def starts(self, rocket: str) -> list[Start]:
        """The starting configurations of a rocket, by name."""
        with self._reading() as connection:
            return _starts(connection, rocket)

    def designed(self) -> list[str]:
        """The rockets with a starting configuration, by name."""
        rocket = configurations.c.rocket
        with self._reading() as connection:
            return list(connection.scalars(select(rocket).distinct().order_by(rocket)))

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

    def change_drafts(self, contents: Mapping[str, Content], command: str, what: str) -> bool:
        """Save several documents, as in `change_draft`, as one change."""
        with self._changing() as recorder:
            changed = [drafts.change(recorder, name, content) for name, content in contents.items()]
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
                recorder.sign("drop", f"the draft of {name}")
        return dropped


def _starts(connection: Connection, rocket: str) -> list[Start]:
    query = select(configurations).where(configurations.c.rocket == rocket).order_by(configurations.c.config)
    return [Start(**{name: row[name] for name in START_FIELDS}) for row in sound_rows(connection, query)]
