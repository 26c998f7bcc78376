"""What several rockets share that the model lacks: searched on the Loop page, kept in the ledger, shown on Home."""

from collections.abc import Sequence

from fieldkit.ledger import Ledger
from fieldkit.progress import ReportProgress
from fieldkit.tui.resources import Resources

FLEET_DRAFT = "fleet findings"
"""Name under which the ledger keeps the sentences of the last search."""


def search_fleet(resources: Resources, on_progress: ReportProgress) -> Sequence[str]:
    """Search all rockets, and keep the findings as sentences, the most probable first. Raises NoFlights, Dropped."""
    from fieldkit.presentation.fleet_text import in_words  # with the search it takes 0.3 s to import
    from fieldkit.quantities import percent
    from fieldkit.services.fleet_loop import close_fleet_loop

    found = close_fleet_loop(resources.ledger, resources.motors, on_progress)
    lines = [f"{in_words(one)}, chance {percent(one.finding.probability)}" for one in found.results]
    resources.ledger.keep_draft(FLEET_DRAFT, {"lines": lines})
    return lines


def kept_findings(ledger: Ledger) -> tuple[str, ...]:
    """The sentences of the last search; empty if there was none or it found nothing."""
    kept = (ledger.draft(FLEET_DRAFT) or {}).get("lines", [])
    return tuple(str(line) for line in kept) if isinstance(kept, list) else ()
