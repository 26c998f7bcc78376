"""The whole loop on the twelve reference flights: from readouts to the next apogee and back."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.forecast.prediction import Prediction
from fieldkit.ledger import Ledger
from fieldkit.ledger.backups import backups
from fieldkit.ledger.whereabouts import file_of, location
from fieldkit.motors import Catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.progress import ReportProgress, part
from fieldkit.quantities import counted
from fieldkit.services.close_loop import adopt, look
from fieldkit.services.findings import Findings
from fieldkit.services.forecasts import predict_plans, which_rocket
from fieldkit.services.imports import bring_in
from fieldkit.services.inferred import FlightInference, Inferred


@dataclass(frozen=True, slots=True)
class Demo:
    """The results of each step: one entry per flight, or one per motor and configuration."""

    rocket: str
    flights: Sequence[Flight]
    inferred: Sequence[Inferred]
    predictions: Sequence[Prediction]
    loop: Findings


def demo(ledger: Ledger, motors: Catalogue, on_progress: ReportProgress) -> Demo:
    """Import, infer, predict, close the loop. Raises LedgerError for a ledger that already has flights."""
    if count := len(ledger.flights()):
        raise LedgerError(
            f"{ledger.name}: found {counted(count, 'flight')}, expected an empty or new ledger for the demo"
        )
    on_progress("importing", 0.0)
    bring_in(ledger, [REFERENCE_FLIGHTS], lambda name: None)
    flights = ledger.flights()
    on_progress("inferring", 0.1)
    inferred = FlightInference(ledger, motors).infer(flights).inferred
    rocket = which_rocket(ledger, None)
    on_progress("predicting", 0.15)
    predictions = predict_plans(ledger, motors, plans(flights))
    found = look(ledger, motors, rocket, part(on_progress, 0.2, 0.8))
    adopt(ledger, rocket, found.diagnosis)
    return Demo(rocket, flights, inferred, predictions, found)


def plans(flights: Sequence[Flight]) -> list[Flight]:
    """A plan for each combination of the flights' motors and configurations."""
    motors, configs = (sorted({getattr(flight, name) for flight in flights}) for name in ("motor", "config"))
    return [Flight(rocket=flights[0].rocket, config=config, motor=motor) for motor in motors for config in configs]


def new_ledger_file(named: str | None) -> Path | None:
    """A file for a ledger that does not exist yet; the demo creates it completely or not at all. Raises LedgerError."""
    file = file_of(location(named)) if named else None
    return file if file is not None and not file.exists() and file.parent.is_dir() and not backups(file) else None
