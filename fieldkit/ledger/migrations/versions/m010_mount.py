"""Columns for the center of gravity of a design without a motor, and for the aft end of its motor mount, both from the
tip of the nose. [m]"""

import sqlalchemy as sa
from alembic import op

revision = "m010_mount"
down_revision = "m009_weighed"


def upgrade() -> None:
    for name in ("dry_cg", "mount_end"):
        op.add_column("configurations", sa.Column(name, sa.Double))
