"""Starting configurations: what is known of a rocket before it has flown."""

import sqlalchemy as sa
from alembic import op

revision = "m002_configurations"
down_revision = "m001_flights"


def upgrade() -> None:
    op.create_table(
        "configurations",
        sa.Column("rocket", sa.Text, primary_key=True, nullable=False),
        sa.Column("config", sa.Text, primary_key=True, nullable=False),
        *(sa.Column(name, sa.Double) for name in ("dry_mass", "diameter", "length", "cd")),
        sa.Column("source", sa.Text, nullable=False),
    )
