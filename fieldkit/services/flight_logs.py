"""The logs stored with a rocket's flights, read again for the forces in the climb."""

from fieldkit.analysis import Recorded
from fieldkit.errors import LedgerError, UnusableLedger
from fieldkit.ledger import Ledger
from fieldkit.progress import ReportProgress, no_op
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.services.replay import recording_of

MAX_LOGS = 6
"""Number of the latest logs to read, which take up to half a second each."""
OLDER_LOGS_NOTE = f"older than the {MAX_LOGS} latest logs; only those are read"


def recorded_logs(
    ledger: Ledger, diagnosis: Diagnosis, on_progress: ReportProgress = no_op
) -> dict[str, Recorded | str]:
    """The climb in the log of each flight in a diagnosis, by flight id, or the reason there is none. Only the latest
    logs are read; the others have `OLDER_LOGS_NOTE`."""
    seen = diagnosis.data.seen[:, 0]
    flights = [flight for flight, used_in_fit in zip(diagnosis.model.flights, seen, strict=True) if used_in_fit]
    logged = [flight for flight in flights if flight.has_log]
    latest = logged[-MAX_LOGS:]
    if not logged:
        return {}

    found: dict[str, Recorded | str] = {flight.flight_id: OLDER_LOGS_NOTE for flight in logged[:-MAX_LOGS]}
    for number, (flight, id) in enumerate(zip(latest, ledger.ids(latest), strict=True)):
        on_progress(f"the log of {id}", number / len(latest))
        try:
            recording = recording_of(ledger, id)
        except UnusableLedger:
            raise
        except LedgerError as error:
            found[flight.flight_id] = str(error)
            continue
        if recording is not None:
            found[flight.flight_id] = recording.recorded
    return found
