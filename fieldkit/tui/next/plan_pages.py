"""The pages that the Decide screen writes, each one file: range safety sheet, range card, card of finals."""

from collections.abc import Callable
from pathlib import Path

from fieldkit import files
from fieldkit.planning.contest import rule_of
from fieldkit.planning.contest_day import Day
from fieldkit.planning.finals import FinalsPlan, finals_plan
from fieldkit.planning.planned_flight import planned_flight
from fieldkit.presentation.report.finals_card import SUFFIXES, check_card
from fieldkit.presentation.report.plan_pages import finals_card_of, range_card_of, safety_sheet_of
from fieldkit.tui.next.decisions import Decision
from fieldkit.tui.page import PageScreen
from fieldkit.tui.report import Written, ask_file

PAGES = {
    "sheet": ("range safety sheet", "One page for the range safety officer to sign"),
    "card": ("range card", "One page for flight check-in: forecast, map of the landing, safety lines"),
    "finals": ("finals card", "One page with mass and parachute for each target of the finals"),
}
"""The pages by name: what each is called, and what it is."""


def finals_of(decision: Decision, year: int, day: Day) -> FinalsPlan:
    """A decision for the finals of a season, in the window of the day if one was announced.

    Raises ImpossibleFlight for a plan without a mass or with too little thrust.
    """
    rule = rule_of(year).announced(None, day.window)
    return finals_plan(decision.plan, rule, decision.contest_checks(rule, day))


def ask_page(screen: PageScreen, kind: str, current: Callable[[], tuple[Decision, int, Day]]) -> None:
    """Ask for the file of a page of the current decision, season and day, and write it."""
    what, about = PAGES[kind]

    def write(path: Path, force: bool) -> Path:
        files.write(path, _page(kind, path.suffix.lower(), *current()), force=force)
        return path

    ends = f"{about}. A name that ends in {', '.join(SUFFIXES)}."
    ask_file(screen, Written(what, f"Write the {what}", f"{what}.pdf", ends, check_card, write))


def _page(kind: str, suffix: str, decision: Decision, year: int, day: Day) -> bytes:
    if kind == "finals":
        return finals_card_of(finals_of(decision, year, day), suffix, decision.system)
    one = planned_flight(decision.plan, decision.site, decision.limits)
    write = safety_sheet_of if kind == "sheet" else range_card_of
    return write(one, decision.plan.rocket.known, decision.site, suffix, decision.system)
