"""Model versions by rocket, the active one, and the saved predictions."""

from collections.abc import Mapping
from dataclasses import asdict, fields
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, func, insert, select

from fieldkit.errors import LedgerError
from fieldkit.ledger.checksums import seal, sound_rows
from fieldkit.ledger.journal import ChangeRecorder, now
from fieldkit.ledger.records import StoredPrediction, Version
from fieldkit.ledger.rows import Row
from fieldkit.ledger.tables import active_versions
from fieldkit.ledger.tables import predictions as made
from fieldkit.ledger.tables import versions as kept

FIELDS = tuple(field.name for field in fields(StoredPrediction))


def keep_version(recorder: ChangeRecorder, rocket: str, payload: Mapping[str, Any], *, activate: bool) -> Version:
    """Save a model of a rocket under its next number."""
    last = recorder.connection.scalar(select(func.max(kept.c.number)).where(kept.c.rocket == rocket)) or 0
    at = now()
    recorder.insert(kept, [{"rocket": rocket, "number": last + 1, "at": at, "payload": dict(payload)}])
    if activate:
        _use(recorder, rocket, last + 1)
    return Version(rocket, last + 1, datetime.fromisoformat(at), dict(payload), activate)


def versions(connection: Connection, rocket: str) -> list[Version]:
    """The models of a rocket, oldest first."""
    in_use = sound_rows(connection, select(active_versions).where(active_versions.c.rocket == rocket))
    used = {row["number"] for row in in_use}
    return [
        Version(rocket, row["number"], datetime.fromisoformat(row["at"]), row["payload"], row["number"] in used)
        for row in sound_rows(connection, select(kept).where(kept.c.rocket == rocket).order_by(kept.c.number))
    ]


def activate(recorder: ChangeRecorder, rocket: str, number: int | None) -> bool:
    """Activate a saved model version, or none; False if it is already active. Raises LedgerError."""
    stored = {version.number: version.active for version in versions(recorder.connection, rocket)}
    if number is not None and number not in stored:
        known = ", ".join(map(str, (0, *stored)))
        raise LedgerError(f"{rocket} has no model version {number}, expected one of: {known} (0 is no correction)")
    if number is None:
        recorder.delete(active_versions, active_versions.c.rocket == rocket)
    elif not stored[number]:
        _use(recorder, rocket, number)
    return recorder.has_changes


def _use(recorder: ChangeRecorder, rocket: str, number: int) -> None:
    recorder.delete(active_versions, active_versions.c.rocket == rocket)
    recorder.insert(active_versions, [{"rocket": rocket, "number": number}])


def keep_prediction(
    connection: Connection, payload: Mapping[str, Any], digest: str, rocket: str, flight_id: str
) -> StoredPrediction:
    """Save a prediction, or return the existing one with the same content and inputs."""
    new, row = _numbered(connection, payload, digest, rocket, flight_id)
    if row:
        connection.execute(insert(made).values(row))
        seal(connection, made, [(new.number,)])
    return new


def keep_plan(
    recorder: ChangeRecorder, payload: Mapping[str, Any], digest: str, rocket: str, flight_id: str
) -> StoredPrediction:
    """Like `keep_prediction`, for a planned flight, as an undoable change."""
    new, row = _numbered(recorder.connection, payload, digest, rocket, flight_id)
    recorder.insert(made, [row] if row else [])
    return new


def _numbered(
    connection: Connection, payload: Mapping[str, Any], digest: str, rocket: str, flight_id: str
) -> tuple[StoredPrediction, Row]:
    """A prediction under the next number and its row, or the existing one and no row."""
    for prediction in predictions(connection, rocket, flight_id, digest):
        if prediction.payload == payload:
            return prediction, {}
    last = connection.scalar(select(func.max(made.c.number))) or 0
    new = StoredPrediction(last + 1, datetime.fromisoformat(now()), rocket, flight_id, digest, dict(payload))
    return new, asdict(new) | {"at": new.at.isoformat()}


def predictions(
    connection: Connection, rocket: str | None, flight_id: str | None, digest: str | None = None
) -> list[StoredPrediction]:
    """The saved predictions, oldest first."""
    query = select(made).order_by(made.c.number)
    if rocket is not None:
        query = query.where(made.c.rocket == rocket)
    if flight_id is not None:
        query = query.where(made.c.flight_id == flight_id)
    if digest is not None:
        query = query.where(made.c.digest == digest)
    return [
        StoredPrediction(**{name: row[name] for name in FIELDS} | {"at": datetime.fromisoformat(row["at"])})
        for row in sound_rows(connection, query)
    ]
