"""Standard deviations and sources of readouts in columns of their own.

What analysis of logs measured stood as text among the extra columns, `apogee_sd_m`. It is moved, in flights, in how
they came in, and in the journal, so that undo brings it back where it belongs. A text that is no number above zero, or
stands beside no readout, stays where it is. A row that is not as it was written stays as it is, too, to be found so.
"""

import json
import math
from typing import Any
from zlib import crc32

import sqlalchemy as sa
from alembic import op

revision = "m005_readouts"
down_revision = "m004_checksums"

Row = dict[str, Any]

MOVED_COLUMNS = {
    "apogee_sd_m": ("apogee", 1.0),
    "top_speed_sd_mps": ("top_speed", 1.0),
    "burn_time_sd_s": ("burn_time", 1.0),
    "peak_accel_sd_g": ("peak_accel", 9.80665),
    "avg_accel_sd_g": ("avg_accel", 9.80665),
    "coast_to_apogee_sd_s": ("coast_to_apogee", 1.0),
    "apogee_to_eject_sd_s": ("apogee_to_eject", 1.0),
    "eject_altitude_sd_m": ("eject_altitude", 1.0),
    "descent_speed_sd_mps": ("descent_speed", 1.0),
    "duration_sd_s": ("duration", 1.0),
}
"""The readout of each extra column, and its unit in SI."""


def upgrade() -> None:
    for name in ("readout_sd", "readout_source"):
        op.add_column("flights", sa.Column(name, sa.JSON))
    connection = op.get_bind()
    held = sa.MetaData()
    held.reflect(connection)
    labels: dict[int, list[str]] = {}
    for entry, _, tag in connection.execute(sa.select(held.tables["tags"]).order_by(sa.text("entry, position"))):
        labels.setdefault(entry, []).append(tag)
    for row in _rows(connection, held.tables["flights"]):
        _write(connection, held.tables["flights"], row, _flight(row), {"tags": labels.get(row["entry"], [])})
    for row in _rows(connection, held.tables["journal"]):
        _write(connection, held.tables["journal"], row, _journal(row), {})


def _rows(connection: sa.Connection, table: sa.Table) -> list[Row]:
    return [dict(row) for row in connection.execute(sa.select(table)).mappings()]


def _flight(row: Row) -> Row:
    """What changes in a row of flights."""
    moved, entered = _moved(row), row["entered"] and _moved(row["entered"])
    changes = {name: moved[name] for name in ("extra", "readout_sd") if moved[name] != row[name]}
    return changes | ({"entered": entered} if entered != row["entered"] else {})


def _journal(row: Row) -> Row:
    """What changes in an entry of the journal."""
    images = row["images"]
    if not images:
        return {}
    moved = [_image(*image) if image[0] == "flights" else image for image in images]
    return {"images": moved, "images_checksum": _checksum(moved)} if moved != images else {}


def _image(table: str, before: Row | None, after: Row | None) -> list[Any]:
    """A row before and after a change; both say what their standard deviations are where one says so."""
    images = [image and _moved(image | _entered(image)) for image in (before, after)]
    if any(image and "readout_sd" in image for image in images):
        images = [{"readout_sd": None} | image if image and "extra" in image else image for image in images]
    return [table, *images]


def _entered(image: Row) -> Row:
    return {"entered": _moved(image["entered"])} if image.get("entered") else {}


def _moved(row: Row) -> Row:
    """A row with the standard deviations among its extra columns in their own place; itself where there are none."""
    extra = row.get("extra") or {}
    found = {name: sd for name in MOVED_COLUMNS if name in extra and (sd := _sd(row, name, extra[name])) is not None}
    if not found:
        return row
    left = {name: text for name, text in extra.items() if name not in found}
    return row | {"extra": left, "readout_sd": {MOVED_COLUMNS[name][0]: sd for name, sd in found.items()}}


def _sd(row: Row, name: str, text: str) -> float | None:
    """A standard deviation in SI, None for a text that is none or that is beside no readout."""
    readout, unit = MOVED_COLUMNS[name]
    try:
        sd = float(text) * unit
    except (TypeError, ValueError):
        return None
    return sd if math.isfinite(sd) and sd > 0 and row.get(readout, 0.0) is not None else None


def _write(connection: sa.Connection, table: sa.Table, row: Row, changes: Row, beside: Row) -> None:
    """Change a row and give it the checksum of what it says then; one that is damaged stays so."""
    if not changes or row["checksum"] != _checksum_of_row(row | beside):
        return
    if row.get("images") is not None and row["images_checksum"] != _checksum(row["images"]):
        return
    at = [column == row[column.name] for column in table.primary_key]
    checksum = _checksum_of_row(row | beside | changes)
    connection.execute(table.update().where(*at).values(**changes, checksum=checksum))


def _checksum_of_row(row: Row) -> int:
    return _checksum({name: row[name] for name in row if row[name] is not None and name not in ("checksum", "images")})


def _checksum(document: Any) -> int:
    return crc32(json.dumps(document, sort_keys=True).encode())
