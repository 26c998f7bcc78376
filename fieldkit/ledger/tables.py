"""The tables of a ledger, as SQLAlchemy Core sees them; the migrations create them.

Rockets, motors and sites have no tables: their lists are read from the flights, so they cannot be left over or
contradict a flight. A configuration has a row for what is known of it apart from its flights. Numbers are SI, one
column for each of `fieldkit.flight.COLUMNS`; times are ISO 8601 text, because a flight's clock may not know its time
zone.
"""

from sqlalchemy import (
    JSON,
    BigInteger,
    Column,
    Double,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
    text,
)

from fieldkit.flight import COLUMNS, LOGGED

metadata = MetaData()
document = JSON(none_as_null=True)
moment = Text().with_variant(Text(collation="C"), "postgresql")
"""ISO 8601 text that sorts chronologically on every server."""
MAX_ROWS_BY_NAME = 500
"""Number of rows up to which they are selected by key; above it, all are read. [1]"""


def _checksum() -> Column[int]:
    """See `fieldkit.ledger.checksums`."""
    return Column("checksum", BigInteger)


IS_EDITED = text("entered IS NOT NULL")

logs = Table(
    "logs",
    metadata,
    Column("digest", Text, primary_key=True),  # SHA-256 of the original bytes, in hex
    Column("size", Integer, nullable=False),  # of the original [byte]
    Column("content", LargeBinary, nullable=False),  # compressed with zlib
)

flights = Table(
    "flights",
    metadata,
    Column("entry", Integer, primary_key=True, autoincrement=False),
    Column("rocket", Text, nullable=False),
    Column("flight_id", Text, nullable=False),
    Column("config", Text, nullable=False),
    Column("motor", Text, nullable=False),
    Column("date_time", moment),
    Column("site", Text, nullable=False),
    Column("notes", Text, nullable=False),
    Column("log", Text, nullable=False),  # as written in the flight table
    Column("log_digest", Text, ForeignKey("logs.digest")),
    Column("source", Text, nullable=False),  # the file it came from
    *(Column(column.name, Double) for column in COLUMNS + LOGGED),
    Column("extra", document, nullable=False),
    Column("readout_sd", document),  # standard deviations of readouts by name, SI; empty if none is recorded
    Column("readout_source", document),  # sources of readouts by name
    Column("entered", document),  # the flight as imported, if it was edited since
    _checksum(),  # includes its tags
    UniqueConstraint("rocket", "flight_id"),
    Index("flights_by_id", "flight_id"),
    Index("flights_by_date", "date_time", "entry"),
    Index("flights_edited", "entry", sqlite_where=IS_EDITED),  # PostgreSQL too: naming it here would import its dialect
)

tags = Table(
    "tags",
    metadata,
    Column("entry", Integer, ForeignKey("flights.entry"), primary_key=True, autoincrement=False),
    Column("position", Integer, primary_key=True, autoincrement=False),
    Column("tag", Text, nullable=False),
    Index("tags_by_tag", "tag"),
)

versions = Table(
    "versions",
    metadata,
    Column("rocket", Text, primary_key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("at", moment, nullable=False),
    Column("payload", document, nullable=False),
    _checksum(),
)

active_versions = Table(
    "active_versions",
    metadata,
    Column("rocket", Text, primary_key=True),
    Column("number", Integer, nullable=False),
    _checksum(),
    ForeignKeyConstraint(["rocket", "number"], ["versions.rocket", "versions.number"]),
)

predictions = Table(
    "predictions",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("at", moment, nullable=False),
    Column("rocket", Text, nullable=False),
    Column("flight_id", Text, nullable=False),  # of the planned flight, empty if it has no name yet
    Column("digest", Text, nullable=False),  # covers all inputs of the prediction
    Column("payload", document, nullable=False),
    _checksum(),
    Index("predictions_by_flight", "rocket", "flight_id"),
)

configurations = Table(
    "configurations",
    metadata,
    Column("rocket", Text, primary_key=True),
    Column("config", Text, primary_key=True),
    Column("dry_mass", Double),
    Column("diameter", Double),
    Column("length", Double),
    Column("cd", Double),
    Column("source", Text, nullable=False),  # the file it came from
    Column("cg", Double),
    Column("cp", Double),
    Column("weighed_mass", Double),
    Column("measured_diameter", Double),
    Column("dry_cg", Double),
    Column("mount_end", Double),
    _checksum(),
)

journal = Table(
    "journal",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("at", moment, nullable=False),
    Column("command", Text, nullable=False),
    Column("what", Text, nullable=False),
    Column("target", Integer, ForeignKey("journal.number")),  # the change that an undo or redo applies to
    Column("images", document),  # rows before and after, without checksums; empty if `target` has them
    Column("images_checksum", BigInteger),
    _checksum(),
)

drafts = Table(
    "drafts",
    metadata,
    Column("name", Text, primary_key=True),
    Column("content", document, nullable=False),
    _checksum(),
)
