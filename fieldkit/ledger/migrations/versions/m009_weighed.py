"""Columns for the dry mass [kg] and the diameter [m] of a configuration as its flyer stated them."""

import sqlalchemy as sa
from alembic import op

revision = "m009_weighed"
down_revision = "m008_balance"


def upgrade() -> None:
    for name in ("weighed_mass", "measured_diameter"):
        op.add_column("configurations", sa.Column(name, sa.Double))
