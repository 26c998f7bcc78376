"""The search of the Loop page for what several rockets share that the model lacks."""

from collections.abc import Sequence

from fieldkit.presentation.fleet_text import in_words
from fieldkit.progress import ReportProgress
from fieldkit.quantities import percent
from fieldkit.services.fleet_findings import save_findings
from fieldkit.services.fleet_loop import close_fleet_loop
from fieldkit.tui.resources import Resources


def search_fleet(resources: Resources, on_progress: ReportProgress) -> Sequence[str]:
    """Search all rockets, and save the findings as sentences, the most probable first. Raises NoFlights, Dropped."""
    found = close_fleet_loop(resources.ledger, resources.motors, on_progress)
    lines = [f"{in_words(one)}, chance {percent(one.finding.probability)}" for one in found.results]
    save_findings(resources.ledger, lines)
    return lines
