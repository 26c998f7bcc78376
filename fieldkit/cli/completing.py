"""Shell completion from the user's own ledger and the known motors.

Completion changes nothing and reports no errors: without a ledger, or with a damaged one, it offers nothing.
"""

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fieldkit.errors import FieldkitError
from fieldkit.paths import motor_folder

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger

MAX_MOTORS = 60
"""Maximum number of motors offered. [1]"""


def rocket_names(context: typer.Context, incomplete: str) -> list[str]:
    """Rockets of the ledger."""
    return _flown(context, "rocket", incomplete)


def config_names(context: typer.Context, incomplete: str) -> list[str]:
    """Configurations of the ledger."""
    return _flown(context, "config", incomplete)


def flight_ids(context: typer.Context, incomplete: str) -> list[str]:
    """Ids of the ledger's flights, as commands accept them."""
    ledger = _ledger(context)
    if ledger is None:
        return []
    with ledger:
        return [id for id in ledger.ids(ledger.flights()) if id.startswith(incomplete)]


def motor_names(context: typer.Context, incomplete: str) -> list[str]:
    """Motors flown before, then those of the catalog, one name for each delay on sale."""
    from fieldkit.motors.names import with_delay
    from fieldkit.motors.own import known_motors

    motors, _ = known_motors(motor_folder())
    sold = (
        with_delay(motor.designation, delay) for motor in motors.motors for delay in motor.delays if isfinite(delay)
    )
    matching = sorted({name for name in sold if name.startswith(incomplete)})
    return list(dict.fromkeys([*_flown(context, "motor", incomplete), *matching]))[:MAX_MOTORS]


def _flown(context: typer.Context, field: str, incomplete: str) -> list[str]:
    ledger = _ledger(context)
    if ledger is None:
        return []
    with ledger:
        return [name for name in ledger.names(field) if name.startswith(incomplete)]


def _ledger(context: typer.Context) -> "Ledger | None":
    """The ledger named in the incomplete command line, None if it does not exist: completion creates none."""
    from fieldkit.ledger import Ledger
    from fieldkit.ledger.whereabouts import location

    where = context.find_root().params.get("ledger")
    try:
        url = location(where)
        if url.get_backend_name() == "sqlite" and not Path(str(url.database)).is_file():
            return None
        return Ledger.open(where)
    except FieldkitError:
        return None
