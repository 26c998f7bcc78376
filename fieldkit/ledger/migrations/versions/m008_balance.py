"""Columns for the centers of gravity and of pressure of a design, from the tip of its nose [m]."""

import sqlalchemy as sa
from alembic import op

revision = "m008_balance"
down_revision = "m007_dates"


def upgrade() -> None:
    for name in ("cg", "cp"):
        op.add_column("configurations", sa.Column(name, sa.Double))
