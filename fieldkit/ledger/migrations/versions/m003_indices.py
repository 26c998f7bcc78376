"""Indices that keep a ledger of a club or of decades quick: by id, by tag, by what was forecast, what was edited."""

import sqlalchemy as sa
from alembic import op

revision = "m003_indices"
down_revision = "m002_configurations"


def upgrade() -> None:
    edited = sa.text("entered IS NOT NULL")
    op.create_index("flights_by_id", "flights", ["flight_id"])
    op.create_index("flights_edited", "flights", ["entry"], sqlite_where=edited, postgresql_where=edited)
    op.create_index("tags_by_tag", "tags", ["tag"])
    op.create_index("predictions_by_flight", "predictions", ["rocket", "flight_id"])
