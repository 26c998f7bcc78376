"""The logs stored with a rocket's flights, read again for the forces in the climb."""

from collections.abc import Sequence

from fieldkit.analysis.force_profile import drag_profile
from fieldkit.errors import LedgerError, UnusableLedger
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.progress import ReportProgress, no_op
from fieldkit.selection.logged_forces import FlightLog
from fieldkit.services.replay import FlightRecordings


def recorded_logs(
    ledger: Ledger, flights: Sequence[Flight], on_progress: ReportProgress = no_op
) -> dict[str, FlightLog | str]:
    """What the log of each flight that has one shows, by flight id, or the reason it cannot be read."""
    logged = [flight for flight in flights if flight.has_log]
    found: dict[str, FlightLog | str] = {}
    recordings = FlightRecordings(ledger)
    for number, (flight, id) in enumerate(zip(logged, ledger.ids(logged), strict=True)):
        on_progress(f"the log of {id}", number / len(logged))
        try:
            recording = recordings.of(id)
        except UnusableLedger:
            raise
        except LedgerError as error:
            found[flight.flight_id] = str(error)
            continue
        if recording is not None and recording.reading is not None and recording.kind != "simulation":
            drag = drag_profile(recording.reading.clocks, recording.recorded)
            found[flight.flight_id] = FlightLog(recording.recorded, drag)
    return found
