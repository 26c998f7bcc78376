"""Documents saved under a name: unfinished flights, which let a killed prompt resume, sites and plans."""

import json
from collections.abc import Callable, Mapping
from typing import Any

from sqlalchemy import Connection, delete, insert, select

from fieldkit.ledger.checksums import seal, sound_rows
from fieldkit.ledger.journal import ChangeRecorder
from fieldkit.ledger.tables import drafts

Content = Mapping[str, Any] | Callable[[dict[str, Any]], Mapping[str, Any]]
"""A document, or a change of the saved one (empty if absent), which no other process changes in the meantime."""


def keep(connection: Connection, name: str, content: Content) -> None:
    """Save a draft under a name, replacing the previous one."""
    kept = _changed(draft(connection, name), content)
    connection.execute(delete(drafts).where(drafts.c.name == name))
    connection.execute(insert(drafts).values(name=name, content=kept))
    seal(connection, drafts, [(name,)])


def _changed(stored: dict[str, Any] | None, content: Content) -> dict[str, Any]:
    return dict(content(stored or {}) if callable(content) else content)


def change(recorder: ChangeRecorder, name: str, content: Content) -> bool:
    """Save a draft under a name as a change that can be undone; False if it is unchanged."""
    stored = draft(recorder.connection, name)
    kept = json.loads(json.dumps(_changed(stored, content)))  # as it will be after a round trip through JSON
    if stored == kept:
        return False
    recorder.delete(drafts, drafts.c.name == name)
    recorder.insert(drafts, [{"name": name, "content": kept}])
    return True


def put_away(recorder: ChangeRecorder, name: str) -> bool:
    """Delete a draft as a change that can be undone; False if there is none."""
    if draft(recorder.connection, name) is None:
        return False
    recorder.delete(drafts, drafts.c.name == name)
    return True


def draft(connection: Connection, name: str) -> dict[str, Any] | None:
    """The draft under a name, or None."""
    found = sound_rows(connection, select(drafts).where(drafts.c.name == name))
    return dict(found[0]["content"]) if found else None
