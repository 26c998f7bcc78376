"""The shortlist of motors of a rocket."""

from fieldkit.ledger import Ledger

SHORTLIST = "shortlist"
"""Name under which the ledger saves the shortlists of motors, by rocket."""


def shortlist(ledger: Ledger, rocket: str) -> frozenset[str]:
    """The motors on a rocket's shortlist, by `label`."""
    return frozenset((ledger.draft(SHORTLIST) or {}).get(rocket, ()))


def keep_shortlist(ledger: Ledger, rocket: str, labels: frozenset[str]) -> None:
    """Save these motors as the shortlist of a rocket, as a change that can be undone."""
    ledger.change_draft(SHORTLIST, lambda saved: saved | {rocket: sorted(labels)}, "shortlist", f"of {rocket}")
