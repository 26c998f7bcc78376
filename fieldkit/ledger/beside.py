"""Records of a ledger other than flights: models, predictions, configurations of rockets, drafts."""

from collections.abc import Mapping, Sequence
from typing import Any

from fieldkit.ledger import drafts, models, opening, rockets
from fieldkit.ledger.drafts import Content
from fieldkit.ledger.opened import OpenLedger
from fieldkit.ledger.records import NewPrediction, StoredPrediction, Version
from fieldkit.rocket import Configuration, Rocket


class BesideFlights(OpenLedger):
    """Saving model versions, forecasts, configurations of rockets and drafts. Each method raises LedgerError if the
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
