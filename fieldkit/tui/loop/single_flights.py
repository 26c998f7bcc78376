"""Flights of a rocket that differ from the others: the miss, the likely cause, and a tag to accept by one key."""

from collections.abc import Iterable, Sequence

from textual import on
from textual.containers import Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.presentation.one_off_text import WORTH_SAYING, likely_cause, why
from fieldkit.quantities import percent
from fieldkit.safe_text import printable
from fieldkit.tui.home.home_rows import signed
from fieldkit.tui.widgets.table import Head, Table

NONE_ODD = "No flight stands out from the others of its rocket."


class SingleFlights(Vertical):
    """A row for each flight that may be a one-off, the most certain first; below, the one under the cursor in words."""

    DEFAULT_CSS = """
    SingleFlights Table { height: 1fr; min-height: 3; }
    SingleFlights #why { height: auto; margin-top: 1; }
    """

    def compose(self) -> Iterable[Widget]:
        """The table, and its current flight in words."""
        yield Table(id="odd", empty=NONE_ODD, enter="Tag it")
        yield Static("", id="why")

    def show(self, found: Sequence[FlightBesideOthers], system: str) -> None:
        """Show flights beside the others of their rocket."""
        odd = odd_flights(found)
        rows = {one.flight.flight_id: one for one in odd}

        def cells(id: str) -> tuple[str, ...]:
            one = rows[id]
            miss = signed(one.miss, system) if one.miss == one.miss else ""
            return (id, miss, percent(one.probability), *likely_cause(one))

        heads = [Head("id", 5, tail=True), Head("miss", 7, True), Head("odd", 6, True), Head("likely", 0)]
        self.query_one(Table).show([*heads, Head("tag", 14)], list(rows), cells)
        self._moved()

    @on(Table.Moved, "#odd")
    def _moved(self) -> None:
        """Explain the flight under the cursor."""
        one = self.current
        text = "" if one is None else why(one)
        tag = "" if one is None else likely_cause(one)[1]
        hint = f"\nEnter to tag it {tag}: fits then leave it out" if tag else ""
        self.query_one("#why", Static).update(Content.assemble(printable(text), (hint, "b")))

    found: Sequence[FlightBesideOthers] = ()

    @property
    def current(self) -> FlightBesideOthers | None:
        """The flight under the cursor."""
        key = self.query_one(Table).current
        return next((one for one in self.found if one.flight.flight_id == key), None)


def odd_flights(found: Sequence[FlightBesideOthers]) -> list[FlightBesideOthers]:
    """The clean flights that may be one-offs, the most certain first."""
    odd = [one for one in found if one.flight.clean and one.causes and one.probability >= WORTH_SAYING]
    return sorted(odd, key=lambda one: -one.probability)
