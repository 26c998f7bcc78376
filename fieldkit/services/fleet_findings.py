"""The sentences of the last search over all rockets, saved in the ledger, so that Home shows them at once."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger

FLEET_DRAFT = "fleet findings"
"""Name under which the ledger saves the sentences."""


def save_findings(ledger: "Ledger", lines: Sequence[str]) -> None:
    """Replace the saved sentences. Raises LedgerError."""
    ledger.keep_draft(FLEET_DRAFT, {"lines": list(lines)})


def saved_findings(ledger: "Ledger") -> tuple[str, ...]:
    """The saved sentences; empty if no search was made or it found nothing. Raises LedgerError."""
    lines = (ledger.draft(FLEET_DRAFT) or {}).get("lines", [])
    return tuple(map(str, lines)) if isinstance(lines, list) else ()
