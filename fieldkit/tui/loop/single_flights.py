"""Every flight of a rocket beside the others, those that differ first: miss, likely cause, and a tag to accept."""

from collections.abc import Iterable, Sequence

from textual import on
from textual.containers import Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.presentation.home_text import marked_miss
from fieldkit.presentation.one_off_text import WORTH_SAYING, likely_cause, why
from fieldkit.quantities import percent
from fieldkit.safe_text import printable
from fieldkit.tui.widgets.table import Head, Table

NONE_ODD = "No flight stands out from the others of its rocket."
USUAL, TAGGED = "as the others", "tagged"
"""The words for a flight without a likely cause, and for one that fits leave out."""


class SingleFlights(Vertical):
    """A row for each flight, those that may be one-offs first; below, the one under the cursor in words."""

    DEFAULT_CSS = """
    SingleFlights Table { height: 1fr; min-height: 3; }
    SingleFlights #why { height: auto; margin-top: 1; }
    """

    def compose(self) -> Iterable[Widget]:
        """The table, and its current flight in words."""
        yield Table(id="odd", empty="No flights to compare.", enter="")
        yield Static("", id="why")

    def show(self, found: Sequence[FlightBesideOthers], system: str) -> None:
        """Show flights beside the others of their rocket."""
        self.system = system
        odd = odd_flights(found)
        first = {one.flight.flight_id: one for one in odd}
        rows = first | {one.flight.flight_id: one for one in found if one.flight.flight_id not in first}

        def cells(id: str) -> tuple[str, ...]:
            one = rows[id]
            miss = marked_miss(one.miss if one.miss == one.miss else None, system, inside=True, computed=False)
            usual = (USUAL, "") if one.flight.clean else (TAGGED, " ".join(one.flight.tags))
            return (
                id,
                miss,
                "!" * (id in first) + percent(one.probability),
                *(likely_cause(one) if id in first else usual),
            )

        heads = [Head("id", 5, tail=True), Head("miss", 7, True), Head("odd", 6, True), Head("likely", 0)]
        self.query_one(Table).show([*heads, Head("tag", 14)], list(rows), cells)
        self._moved()

    @on(Table.Moved, "#odd")
    def _moved(self) -> None:
        """Explain the flight under the cursor."""
        one = self.current
        self.query_one(Table).on_enter = "Tag it" if self.tag else ""
        self.screen.refresh_bindings()
        none = "" if one is None or odd_flights(self.found) else f"{NONE_ODD}\n"
        hint = f"\nEnter to tag it {self.tag}: fits then leave it out" if self.tag else ""
        text = "" if one is None else printable(why(one, self.system))
        text += "\nMisses are those with the effects that S found." if text and self.searched else ""
        self.query_one("#why", Static).update(Content.assemble((none, "b"), text, (hint, "b")))

    found: Sequence[FlightBesideOthers] = ()
    system: str = "SI"
    searched = False
    """Whether the flights are shown as the effects of a search explain them."""

    @property
    def current(self) -> FlightBesideOthers | None:
        """The flight under the cursor."""
        key = self.query_one(Table).current
        return next((one for one in self.found if one.flight.flight_id == key), None)

    @property
    def tag(self) -> str:
        """The tag of the likely cause of the flight under the cursor; empty unless it may be a one-off."""
        one = self.current
        return likely_cause(one)[1] if one is not None and odd_flights([one]) else ""


def odd_flights(found: Sequence[FlightBesideOthers]) -> list[FlightBesideOthers]:
    """The clean flights that may be one-offs, the most certain first."""
    odd = [one for one in found if one.flight.clean and one.causes and one.probability >= WORTH_SAYING]
    return sorted(odd, key=lambda one: -one.probability)
