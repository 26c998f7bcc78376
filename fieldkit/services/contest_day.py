"""The contest day saved in the ledger, by season."""

from dataclasses import asdict, replace

from fieldkit.ledger import Ledger
from fieldkit.planning.contest_day import Day

DAYS = "contest"
"""Name under which the ledger saves contest days, by season."""


def day_of(ledger: Ledger, year: int) -> Day:
    """The saved contest day of a season; empty if there is none."""
    kept = (ledger.draft(DAYS) or {}).get(str(year), {})
    window = kept.get("window")
    return replace(Day(**kept), window=tuple(window) if window else None, declared=tuple(kept.get("declared", ())))


def keep_day(ledger: Ledger, year: int, day: Day) -> None:
    """Save the contest day of a season."""
    ledger.change_draft(DAYS, lambda saved: saved | {str(year): asdict(day)}, "day", f"of season {year}")
