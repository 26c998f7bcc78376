"""The contest day saved in the ledger, by season."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from typing import Any

from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.planning.contest_day import Day
from fieldkit.services.launch_day import mass_drafts
from fieldkit.services.sites import SITES, with_site

DAYS = "contest"
"""Name under which the ledger saves contest days, by season."""


def day_of(ledger: Ledger, year: int) -> Day:
    """The saved contest day of a season; empty if there is none."""
    kept = (ledger.draft(DAYS) or {}).get(str(year), {})
    window = kept.get("window")
    return replace(Day(**kept), window=tuple(window) if window else None, declared=tuple(kept.get("declared", ())))


def keep_day(
    ledger: Ledger, year: int, day: Day | None = None, site: Site | None = None, dry_mass: float | None = None
) -> bool:
    """Save what is given of a contest day of a season, its site, and the dry mass of the plan [kg], as one change;
    False if nothing changed. Raises BadValue if the saved plan cannot be read.
    """
    drafts: dict[str, Mapping[str, Any] | Callable[[dict[str, Any]], Mapping[str, Any]]] = (
        {} if day is None else {DAYS: partial(_with_day, year, day)}
    )
    drafts |= {} if site is None else {SITES: with_site(ledger, site, site.name)}
    drafts |= {} if dry_mass is None else mass_drafts(ledger, dry_mass)
    return ledger.change_drafts(drafts, "day", f"of season {year}")


def _with_day(year: int, day: Day, saved: dict[str, Any]) -> dict[str, Any]:
    return saved | {str(year): asdict(day)}
