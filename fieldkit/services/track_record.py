"""Kept predictions whose flights came in, beside what the rivals would have said at that moment."""

from collections.abc import Sequence

import numpy as np

from fieldkit.flight import COLUMNS, Flight
from fieldkit.forecast.evaluation.forward_in_time import Forecast, beside_rivals, certified, unflown
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue, Found
from fieldkit.services.forecasts import flown
from fieldkit.services.provenance import TEACHES, Parts
from fieldkit.services.saved_forecasts import Kept
from fieldkit.shapes import Array, Float

Simulated = tuple[Flight, Found, Float[Array, "draw"]]


def record(ledger: Ledger, motors: Catalogue, found: Sequence[Kept]) -> list[Forecast]:
    """Predictions of clean flights with an apogee, the flight flown first in front.

    The rivals know what the prediction knew: the flights that it rests on, and the plan as it was then.
    """
    rows: list[Forecast] = []
    scored = [one for one in found if one.flight and one.flight.clean and one.flown is not None]
    for rocket in dict.fromkeys(one.made.rocket for one in scored):
        history = flown(ledger, motors, rocket)
        own = [one for one in scored if one.made.rocket == rocket and one.flight in [flight for flight, _ in history]]
        clean = [(flight, motor) for flight, motor in history if flight.clean and flight.apogee is not None]
        taught = [(*both, draws) for both, draws in zip(clean, certified(clean), strict=True)]
        rows += [_beside(one, taught, motors) for one in own]
    return sorted(rows, key=lambda row: row.when.isoformat() if row.when else "")


def _beside(one: Kept, taught: Sequence[Simulated], motors: Catalogue) -> Forecast:
    assert one.flight is not None
    made: Parts = one.made.payload.get("made_from", {})
    knew = {flight for flight, sign in made.get("flights", {}).items() if sign[0] == TEACHES}
    earlier = [row for row in taught if row[0].flight_id in knew and row[0].flight_id != one.flight.flight_id]
    motor = motors.resolve(str(one.made.payload.get("motor") or one.flight.motor))
    (simulated,) = certified([(as_planned(one.flight, made), motor)])
    likely = np.array(one.made.payload.get("likely_m", one.interval), float)
    return beside_rivals(one.flight, motor, likely, simulated, earlier, one.interval)


def as_planned(flight: Flight, made: Parts) -> Flight:
    """A flight with the mass, size and conditions that its prediction was made for, where that was kept."""
    said = {name: text for part in ("mass", "configuration", "conditions") for name, text in made.get(part, {}).items()}
    values = {
        column.name: column.parse(said[column.header]) if said[column.header] else None
        for column in COLUMNS
        if column.header in said
    }
    return unflown(flight).with_changes(**values)
