"""The first ledger: flights, tags, logs, model versions, predictions, drafts and the journal.

Written out in full and never edited after release: `tables.py` may move on, this step may not.
"""

import sqlalchemy as sa
from alembic import op

revision = "m001_flights"
down_revision = None

NUMBERS = (
    "dry_mass",
    "diameter",
    "delay",
    "site_elevation",
    "temperature",
    "pressure",
    "humidity",
    "wind",
    "rail_length",
    "rail_angle",
    "apogee",
    "top_speed",
    "burn_time",
    "peak_accel",
    "avg_accel",
    "coast_to_apogee",
    "apogee_to_eject",
    "eject_altitude",
    "descent_speed",
    "duration",
)


def _text(name: str, *, key: bool = False) -> sa.Column[str]:
    return sa.Column(name, sa.Text, primary_key=key, nullable=False)


def _integer(name: str, *, key: bool = False) -> sa.Column[int]:
    return sa.Column(name, sa.Integer, primary_key=key, nullable=False, autoincrement=False)


def _moment(name: str, *, nullable: bool = False) -> sa.Column[str]:
    return sa.Column(name, sa.Text().with_variant(sa.Text(collation="C"), "postgresql"), nullable=nullable)


def upgrade() -> None:
    op.create_table(
        "logs",
        _text("digest", key=True),
        _integer("size"),
        sa.Column("content", sa.LargeBinary, nullable=False),
    )
    op.create_table(
        "flights",
        _integer("entry", key=True),
        *(_text(name) for name in ("rocket", "flight_id", "config", "motor")),
        _moment("date_time", nullable=True),
        *(_text(name) for name in ("site", "notes", "log")),
        sa.Column("log_digest", sa.Text, sa.ForeignKey("logs.digest")),
        _text("source"),
        *(sa.Column(name, sa.Double) for name in NUMBERS),
        sa.Column("extra", sa.JSON, nullable=False),
        sa.Column("entered", sa.JSON),
        sa.UniqueConstraint("rocket", "flight_id"),
    )
    op.create_table(
        "tags",
        sa.Column("entry", sa.Integer, sa.ForeignKey("flights.entry"), primary_key=True, autoincrement=False),
        _integer("position", key=True),
        _text("tag"),
    )
    op.create_table(
        "versions",
        _text("rocket", key=True),
        _integer("number", key=True),
        _moment("at"),
        sa.Column("payload", sa.JSON, nullable=False),
    )
    op.create_table(
        "active_versions",
        _text("rocket", key=True),
        _integer("number"),
        sa.ForeignKeyConstraint(["rocket", "number"], ["versions.rocket", "versions.number"]),
    )
    op.create_table(
        "predictions",
        _integer("number", key=True),
        _moment("at"),
        *(_text(name) for name in ("rocket", "flight_id", "digest")),
        sa.Column("payload", sa.JSON, nullable=False),
    )
    op.create_table(
        "journal",
        _integer("number", key=True),
        _moment("at"),
        _text("command"),
        _text("what"),
        sa.Column("target", sa.Integer, sa.ForeignKey("journal.number")),
        sa.Column("images", sa.JSON),
    )
    op.create_table("drafts", _text("name", key=True), sa.Column("content", sa.JSON, nullable=False))
