"""A checksum in every row, of all that it says: a bit that flips on the disc is seen when the row is read."""

import json
from typing import Any
from zlib import crc32

import sqlalchemy as sa
from alembic import op

revision = "m004_checksums"
down_revision = "m003_indices"

TABLES = ("flights", "versions", "active_versions", "predictions", "configurations", "journal", "drafts")


def upgrade() -> None:
    for name in TABLES:
        op.add_column(name, sa.Column("checksum", sa.BigInteger))
    op.add_column("journal", sa.Column("images_checksum", sa.BigInteger))
    connection = op.get_bind()
    held = sa.MetaData()
    held.reflect(connection)
    labels: dict[int, list[str]] = {}
    for entry, _, tag in connection.execute(sa.select(held.tables["tags"]).order_by(sa.text("entry, position"))):
        labels.setdefault(entry, []).append(tag)
    for name in TABLES:
        _fill(connection, held.tables[name], labels)


def _fill(connection: sa.Connection, table: sa.Table, labels: dict[int, list[str]]) -> None:
    """The checksum of each row: of a flight with its tags, of the journal with that of what changed."""
    changes = []
    for found in connection.execute(sa.select(table)).mappings():
        row = {name: value for name, value in found.items() if value is not None}
        change = {f"at_{column.name}": row[column.name] for column in table.primary_key}
        if table.name == "flights":
            row["tags"] = labels.get(row["entry"], [])
        if table.name == "journal":
            images = row.pop("images", None)
            change["images_checksum"] = None if images is None else _checksum(images)
            row |= {name: value for name, value in change.items() if name == "images_checksum" and value is not None}
        changes.append(change | {"checksum": _checksum(row)})
    at = [column == sa.bindparam(f"at_{column.name}") for column in table.primary_key]
    if changes:
        connection.execute(table.update().where(*at), changes)


def _checksum(document: Any) -> int:
    return crc32(json.dumps(document, sort_keys=True).encode())
