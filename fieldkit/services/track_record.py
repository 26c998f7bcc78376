"""The quality of forecasts: of flights replayed forward in time, and of saved predictions with a flight."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fieldkit.errors import BadValue
from fieldkit.files import read_own
from fieldkit.flight import COLUMNS, Flight
from fieldkit.forecast.evaluation.forward_in_time import (
    Forecast,
    beside_rivals,
    corrected_by_earlier,
    forward,
    with_stacked,
)
from fieldkit.forecast.evaluation.uncalibrated import Simulated, simulate
from fieldkit.ledger import Ledger
from fieldkit.model.hyperprior import Hyperprior, read_card
from fieldkit.motors import Catalogue
from fieldkit.progress import ReportProgress, no_op
from fieldkit.services.plausible_flights import exclusions, followed, simulable
from fieldkit.services.provenance import USED_IN_FIT, SourceDigests
from fieldkit.services.saved_forecasts import SavedForecast


def replayed(
    ledger: Ledger,
    motors: Catalogue,
    rocket: str | None = None,
    *,
    hyperprior: Hyperprior | None = None,
    on_progress: ReportProgress = no_op,
) -> list[Forecast]:
    """Forecasts of every clean flight of a ledger from all rockets' earlier flights, in the order flown.

    With `rocket`, only its flights are forecast, and only they determine corrections and stacking weights. Raises
    DamagedModel if the hyperprior cannot be read.
    """
    known = ledger.flights()
    ledger.remark(*exclusions(known, motors))
    flights = followed(known, motors)
    return corrected_by_earlier(with_stacked(forward(flights, rocket, hyperprior=hyperprior, on_progress=on_progress)))


def read_hyperprior(path: Path) -> Hyperprior:
    """A hyperprior from a card file. Raises DamagedModel or BadValue if it cannot be read."""
    try:
        return read_card(read_own(path), path.name)
    except (OSError, UnicodeDecodeError) as error:
        raise BadValue(f"{path.name}: cannot be read ({error}), expected a hyperprior card") from error


def record(ledger: Ledger, motors: Catalogue, found: Sequence[SavedForecast]) -> list[Forecast]:
    """Predictions of clean flights with an apogee, in the order flown.

    The rivals use the same data as the prediction: the rocket's flights at that time, other rockets' earlier flights,
    and the plan at that time.
    """
    scored = [one for one in found if one.flight and one.flight.clean and one.flown is not None]
    known = [one for one in simulate(simulable(ledger.flights(), motors)) if one.flight.clean] if scored else []
    known = [one for one in known if one.flight.apogee is not None]
    judged = [one.flight for one in known]
    rows = [_beside(one, known, motors) for one in scored if one.flight in judged]
    return sorted(rows, key=lambda row: row.when.isoformat() if row.when else "")


def _beside(one: SavedForecast, known: Sequence[Simulated], motors: Catalogue) -> Forecast:
    assert one.flight is not None
    made: SourceDigests = one.made.payload.get("made_from", {})
    knew = {flight for flight, sign in made.get("flights", {}).items() if sign[0] == USED_IN_FIT}
    motor = motors.resolve_several(str(one.made.payload.get("motor") or one.flight.motor))
    (planned,) = simulate([(as_planned(one.flight, made), motor)])
    likely = np.array(one.made.payload.get("likely_m", one.interval), float)
    plan = Simulated(one.flight, motor, planned.simulated)
    return beside_rivals(plan, likely, one.interval, _known_then(one.flight, knew, known))


def _known_then(flight: Flight, knew: set[str], known: Sequence[Simulated]) -> list[Simulated]:
    """The flights of its rocket that a prediction used, and other rockets' earlier flights."""
    itself = (flight.rocket, flight.flight_id)
    names = [(one.flight.rocket, one.flight.flight_id) for one in known]
    turn = names.index(itself) if itself in names else len(names)
    own = [rocket == flight.rocket for rocket, _ in names]
    return [
        one
        for row, one in enumerate(known)
        if names[row] != itself and (names[row][1] in knew if own[row] else row < turn)
    ]


def as_planned(flight: Flight, made: SourceDigests) -> Flight:
    """A flight with the mass, size and conditions of its prediction, if they were saved."""
    conditions = {
        name: text for part in ("mass", "configuration", "conditions") for name, text in made.get(part, {}).items()
    }
    values = {
        column.name: column.parse(conditions[column.header]) if conditions[column.header] else None
        for column in COLUMNS
        if column.header in conditions
    }
    return flight.unflown(**values)
