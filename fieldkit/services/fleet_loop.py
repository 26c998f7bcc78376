"""Closing the loop over a whole fleet: what several rockets share that the model lacks, and the error with and without
it on later flights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.errors import NoFlights
from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.forward_in_time import Forecast
from fieldkit.forecast.evaluation.rivals import LABELS
from fieldkit.ledger import Ledger
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.motors import Catalogue
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.scoring.proper_scores import crps
from fieldkit.scoring.score import Score
from fieldkit.selection.fleet_search import FleetFinding, fleet_of, log_shifts, search_fleet
from fieldkit.services.plausible_flights import followed
from fieldkit.services.track_record import replayed

MAX_JUDGED = 30
"""Maximum number of later flights of a finding that are forecast with and without it. [1]"""


@dataclass(frozen=True, slots=True)
class FleetResult:
    """A finding, the flights and rockets that it concerns, and the errors on its `later` flights.

    `before` is the error of the forecasts that the flyer would have been given, `after` that with the difference
    estimated from earlier flights; both are None if no flight of the group followed another.
    """

    finding: FleetFinding
    flights: tuple[Flight, ...]
    rockets: tuple[str, ...]
    later: int
    before: Score | None
    after: Score | None


@dataclass(frozen=True, slots=True)
class FleetRival:
    """A simple rule's mean absolute error and CRPS on the flights that it and fieldkit forecast. [m]"""

    name: str
    flights: int
    mae: float
    crps: float


@dataclass(frozen=True, slots=True)
class FleetLoop:
    """What several rockets of a flyer share that the model lacks, and the rivals on the same later flights."""

    rockets: int
    flights: int
    results: tuple[FleetResult, ...]
    rivals: tuple[FleetRival, ...]


def close_fleet_loop(ledger: Ledger, motors: Catalogue, on_progress: ReportProgress = no_op) -> FleetLoop:
    """Search all rockets of a ledger for a shared difference: a motor type or lot, a day, a site, an altimeter.

    Raises NoFlights without a clean flight with an apogee, DamagedModel for an unreadable hyperprior.
    """
    known = [one for one in followed(ledger.flights(), motors) if one[0].clean and one[0].apogee is not None]
    if not known:
        raise NoFlights("found no normal flight with an apogee and a dry mass, expected at least two rockets' flights")
    by_rocket: dict[str, list[FlownFlight]] = {}
    for flight, motor in known:
        by_rocket.setdefault(flight.rocket, []).append((flight, motor))
    rockets = fleet_of(by_rocket, learned(), part(on_progress, 0.0, 0.3))
    findings = search_fleet(rockets, part(on_progress, 0.3, 0.3))
    rows = replayed(ledger, motors, on_progress=part(on_progress, 0.6, 0.4)) if findings else []
    issued = {(row.rocket, row.flight_id): row for row in rows}
    order = {(flight.rocket, flight.flight_id): number for number, (flight, _) in enumerate(known)}
    results: list[FleetResult] = []
    judged: set[tuple[str, str]] = set()
    for finding in findings:
        shifts = log_shifts(finding.candidate, rockets, order, MAX_JUDGED)
        shifts = {key: shift for key, shift in shifts.items() if key in issued}
        judged |= shifts.keys()
        members = finding.candidate.members
        concerned = tuple(
            flight for one in rockets for flight, own in zip(one.model.flights, members[one.name], strict=True) if own
        )
        results.append(
            FleetResult(
                finding,
                concerned,
                tuple(dict.fromkeys(flight.rocket for flight in concerned)),
                len(shifts),
                _errors(shifts, issued, shifted=False),
                _errors(shifts, issued, shifted=True),
            )
        )
    scored = [issued[key] for key in issued if key in judged]
    return FleetLoop(len(rockets), len(known), tuple(results), tuple(_rivals(scored)))


def _errors(
    shifts: Mapping[tuple[str, str], float], issued: Mapping[tuple[str, str], Forecast], *, shifted: bool
) -> Score | None:
    """The errors of the forecasts of some flights, as issued or shifted."""
    if not shifts:
        return None
    factor = np.exp([shift if shifted else 0.0 for shift in shifts.values()])
    rows = [issued[key] for key in shifts]
    low, middle, high = np.array([row.issued for row in rows]).T * factor
    flown = np.array([row.flown for row in rows])
    error = middle - flown
    return Score(
        float(np.abs(error).mean()),
        float(np.sqrt((error**2).mean())),
        float(error.mean()),
        float(((low <= flown) & (flown <= high)).mean()),
    )


def _rivals(rows: Sequence[Forecast]) -> list[FleetRival]:
    """The rivals on the flights that they forecast, the best first."""
    found = []
    for name, label in LABELS.items():
        own = [row for row in rows if name in row.rivals]
        if not own:
            continue
        medians = np.array([np.median(row.rivals[name]) for row in own])
        flown = np.array([row.flown for row in own])
        scores = [crps(np.asarray(row.rivals[name], float), row.flown) for row in own]
        found.append(FleetRival(label, len(own), float(np.abs(medians - flown).mean()), float(np.mean(scores))))
    return sorted(found, key=lambda one: (-one.flights, one.mae))
