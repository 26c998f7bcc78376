"""Documents shared by several rockets, sites or seasons: simultaneous changes are all kept."""

from collections.abc import Callable
from pathlib import Path
from threading import Thread

import pytest

from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.planning.contest_day import Day
from fieldkit.services.contest_day import DAYS, keep_day
from fieldkit.services.shortlist import SHORTLIST, keep_shortlist, shortlist
from fieldkit.services.sites import SITES, keep_site, with_site

pytestmark = pytest.mark.fast

WRITERS, EACH = 3, 12


def rename(ledger: Ledger, name: str) -> None:
    """Save a site and rename it, as the form of the app does."""
    keep_site(ledger, f"new {name}", size=300.0)
    ledger.edit_all([], name, {SITES: with_site(ledger, Site(name, size=300.0), f"new {name}")})


SAVED: dict[str, tuple[str, Callable[[Ledger, str], object]]] = {
    "a site": (SITES, lambda ledger, name: keep_site(ledger, name, size=300.0)),
    "a whole site": (SITES, lambda ledger, name: keep_day(ledger, 2027, site=Site(name, size=300.0))),
    "a renamed site": (SITES, rename),
    "a shortlist": (SHORTLIST, lambda ledger, name: keep_shortlist(ledger, name, frozenset({"F24-4W"}))),
    "a contest day": (DAYS, lambda ledger, name: keep_day(ledger, int(name), Day())),
}


@pytest.mark.sampled
@pytest.mark.parametrize("what", SAVED)
def test_changes_by_simultaneous_writers_are_all_kept(what: str, tmp_path: Path) -> None:
    name, save = SAVED[what]
    file = tmp_path / "ledger.db"
    Ledger.open(file).close()

    def write(first: int) -> None:
        with Ledger.open(file) as ledger:
            for number in range(first, first + EACH):
                save(ledger, str(number))

    writers = [Thread(target=write, args=(2000 + EACH * place,)) for place in range(WRITERS)]
    for one in writers:
        one.start()
    for one in writers:
        one.join()
    with Ledger.open(file) as ledger:
        assert sorted(ledger.draft(name) or {}) == [str(2000 + number) for number in range(WRITERS * EACH)]


def test_a_shortlist_is_undone_like_any_other_change(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        keep_shortlist(ledger, "Astra", frozenset({"F24W"}))
        keep_shortlist(ledger, "Astra", frozenset({"F24W", "F39T"}))
        assert ledger.undo().what == "of Astra"
        assert shortlist(ledger, "Astra") == {"F24W"}
        ledger.redo()
        assert shortlist(ledger, "Astra") == {"F24W", "F39T"}
