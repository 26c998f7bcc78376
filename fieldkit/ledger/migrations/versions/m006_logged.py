"""Columns for what only the samples of a log show: drag of the coast [1/m], impulse of the burn over mass [m/s]."""

import sqlalchemy as sa
from alembic import op

revision = "m006_logged"
down_revision = "m005_readouts"


def upgrade() -> None:
    for name in ("coast_drag", "burn_impulse"):
        op.add_column("flights", sa.Column(name, sa.Double))
