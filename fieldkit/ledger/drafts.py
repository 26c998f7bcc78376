"""Documents saved under a name: unfinished flights, which let a killed prompt resume, sites and plans."""

import json
from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, delete, insert, select

from fieldkit.ledger.checksums import seal, sound_rows
from fieldkit.ledger.journal import ChangeRecorder
from fieldkit.ledger.tables import drafts


def keep(connection: Connection, name: str, content: Mapping[str, Any]) -> None:
    """Save a draft under a name, replacing the previous one."""
    drop(connection, name)
    connection.execute(insert(drafts).values(name=name, content=dict(content)))
    seal(connection, drafts, [(name,)])


def change(pen: ChangeRecorder, name: str, content: Mapping[str, Any]) -> bool:
    """Save a draft under a name as a change that can be undone; False if it is unchanged."""
    kept = json.loads(json.dumps(dict(content)))  # as it will be after a round trip through JSON
    if draft(pen.connection, name) == kept:
        return False
    pen.delete(drafts, drafts.c.name == name)
    pen.insert(drafts, [{"name": name, "content": kept}])
    return True


def put_away(pen: ChangeRecorder, name: str) -> bool:
    """Delete a draft as an undoable change, unless it was edited since; False if there is none."""
    if draft(pen.connection, name) is None:
        return False
    pen.delete(drafts, drafts.c.name == name)
    return True


def draft(connection: Connection, name: str) -> dict[str, Any] | None:
    """The draft under a name, or None."""
    found = sound_rows(connection, select(drafts).where(drafts.c.name == name))
    return dict(found[0]["content"]) if found else None


def drop(connection: Connection, name: str) -> None:
    """Delete the draft under a name, if there is one."""
    connection.execute(delete(drafts).where(drafts.c.name == name))
