"""Configurations of rockets: what was weighed, measured or designed once."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any

from sqlalchemy import Connection, and_, select

from fieldkit.flight.storable import check_key
from fieldkit.ledger.checksums import sound_rows
from fieldkit.ledger.journal import ChangeRecorder
from fieldkit.ledger.tables import configurations
from fieldkit.rocket import Configuration

FIELDS = tuple(field.name for field in fields(Configuration))
NAMES, BODY = ("rocket", "config"), ("weighed_mass", "measured_diameter")
"""Fields that name a configuration, and those that a flyer states."""


def design_of(one: Configuration) -> dict[str, Any]:
    """The fields of a configuration that come from its design."""
    return {name: value for name, value in asdict(one).items() if name not in (*NAMES, *BODY)}


def body_of(one: Configuration) -> dict[str, Any]:
    """The stated fields of a configuration that are known."""
    return {name: value for name in BODY if (value := getattr(one, name)) is not None}


def keep(recorder: ChangeRecorder, rocket: str, config: str, known: Mapping[str, Any]) -> bool:
    """Save some fields of a configuration and keep its others; False if they are saved already. Raises BadValue for
    names that not every kind of ledger can store."""
    check_key("rocket and config", rocket + config)
    stored = [one for one in configurations_of(recorder.connection, rocket) if one.config == config]
    new = replace(stored[0] if stored else Configuration(rocket, config), **known)
    if stored == [new]:
        return False
    recorder.delete(configurations, and_(configurations.c.rocket == rocket, configurations.c.config == config))
    recorder.insert(configurations, [asdict(new)])
    return True


def configurations_of(connection: Connection, rocket: str) -> list[Configuration]:
    """The configurations of a rocket, by name."""
    return by_rocket(connection, rocket)[rocket]


def by_rocket(connection: Connection, rocket: str | None = None) -> dict[str, list[Configuration]]:
    """The configurations of one rocket or of all, by the names of both."""
    query = select(configurations).order_by(configurations.c.rocket, configurations.c.config)
    found = defaultdict[str, list[Configuration]](list)
    for row in sound_rows(connection, query if rocket is None else query.where(configurations.c.rocket == rocket)):
        found[row["rocket"]].append(Configuration(**{name: row[name] for name in FIELDS}))
    return found
