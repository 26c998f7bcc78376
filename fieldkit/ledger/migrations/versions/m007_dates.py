"""An index of dates: the first page of a list of 100,000 flights is there without a look at each of them."""

from alembic import op

revision = "m007_dates"
down_revision = "m006_logged"


def upgrade() -> None:
    op.create_index("flights_by_date", "flights", ["date_time", "entry"])
