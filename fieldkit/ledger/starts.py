"""Starting configurations: the last one saved for each rocket and configuration."""

from dataclasses import asdict, fields

from sqlalchemy import Connection, and_, select

from fieldkit.flight.start import Start
from fieldkit.ledger.checksums import sound_rows
from fieldkit.ledger.journal import ChangeRecorder
from fieldkit.ledger.rows import check_key
from fieldkit.ledger.tables import configurations

FIELDS = tuple(field.name for field in fields(Start))


def keep(recorder: ChangeRecorder, start: Start) -> bool:
    """Save a starting configuration, replacing the old one; False if it is a duplicate. Raises BadValue for names that
    not every kind of ledger can store."""
    check_key("rocket and config", start.rocket + start.config)
    stored = starts(recorder.connection, start.rocket)
    if start in stored:
        return False
    named = and_(configurations.c.rocket == start.rocket, configurations.c.config == start.config)
    recorder.delete(configurations, named)
    recorder.insert(configurations, [asdict(start)])
    return True


def rockets(connection: Connection) -> list[str]:
    """The rockets with a starting configuration, by name."""
    return list(connection.scalars(select(configurations.c.rocket).distinct().order_by(configurations.c.rocket)))


def starts(connection: Connection, rocket: str) -> list[Start]:
    """The starting configurations of a rocket, by name."""
    query = select(configurations).where(configurations.c.rocket == rocket).order_by(configurations.c.config)
    return [Start(**{name: row[name] for name in FIELDS}) for row in sound_rows(connection, query)]
