"""Flights: the ledger as a table, newest first; filter as you type, sort by any column, open one with Enter.

The flight under the cursor of the Flights page: its figures and why it missed and, if there is room, its Cd among those
of the same configuration, and its climb.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property, partial
from typing import Any, ClassVar

from rich.cells import cell_len
from textual import events, on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.timer import Timer
from textual.widget import Widget
from textual.widgets import Input, Static

from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.presentation import logged
from fieldkit.presentation.one_off_text import why
from fieldkit.quantities import spelled, unit_of
from fieldkit.services.inferred import FlightInference, Inferred
from fieldkit.tui.asking import or_why
from fieldkit.tui.comparing import Beside, beside_others
from fieldkit.tui.flights.edit_form import ask_changes
from fieldkit.tui.flights.flight_rows import FlightRow, Shown, columns, headings, read_rows, same_build, scale_of
from fieldkit.tui.flights.flight_screen import FlightScreen
from fieldkit.tui.flights.flights_help import FLIGHTS_HELP
from fieldkit.tui.flights.log_plot import Drawn, draw_trace, drawn
from fieldkit.tui.flights.removal import REMOVE, remove
from fieldkit.tui.flights.tag_screen import TagScreen
from fieldkit.tui.help import NO_FLIGHTS
from fieldkit.tui.next.intervals import HeightScale
from fieldkit.tui.page import LEAVE_LINE, PageScreen
from fieldkit.tui.report import ask_report
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import Hanging, hanging, stacked
from fieldkit.tui.widgets.line import Line
from fieldkit.tui.widgets.plots import Plot, draw_in, label_flights, round_ticks
from fieldkit.tui.widgets.table import Table

MAX_DRAWN_FLIGHTS = 120
"""Number of latest flights of a configuration to draw, more than the card has columns."""


class FlightCard(VerticalScroll):
    """The card next to the table."""

    BORDER_TITLE, BORDER_SUBTITLE = "Flight", "Enter to open it, t to tag it"

    DEFAULT_CSS = """
    FlightCard Static { height: auto; }
    """

    def compose(self) -> Iterable[Widget]:
        """All in one text."""
        yield Static(id="card")

    def show(self, row: FlightRow | None, beside: FlightBesideOthers | None, system: str) -> None:
        """Show a flight, and why it missed if it was compared with others; None for no flight."""
        self.query_one(Static).update(stacked(_figures(row, beside, system)) if row is not None else "")


class FlightPlots(Horizontal):
    """The Cd of the flights of a build, and the climb of the current one; each is shown if there is one. Plots are
    added when there is something to draw, so that the first paint does not need their library."""

    DEFAULT_CSS = """
    FlightPlots { height: 45%; max-height: 32; display: none; }
    FlightPlots Plot { width: 1fr; height: 1fr; border-top: solid $border-blurred; border-title-color: $foreground; }
    """
    _shown: str | None = None

    def show(self, row: FlightRow | None, build: Sequence[FlightRow]) -> None:
        """Show a flight among those of its build, in the order flown; None for no flight."""
        known = [one for one in build if one.drag is not None][-MAX_DRAWN_FLIGHTS:]
        if row is not None and len(known) > 1:
            name = " ".join(part for part in (row.flight.rocket, row.flight.config) if part)
            self._plot("course", f"Cd of each flight of {name}", partial(_draw_course, row, known))
        else:
            self._plot("course", "", None)
        before, self._shown = self._shown, row.id if row is not None else None
        if self._shown != before:
            self.show_climb(None)  # until its log is read

    def show_climb(self, log: Drawn | None) -> None:
        """Show the altitude of its log; None if it has none, or while it is being read."""
        trace = log.traces.get("altitude") if log is not None else None
        if log is None or trace is None or len(trace.time) < 2:
            self._plot("climb", "", None)
        else:
            self._plot("climb", trace.title, partial(draw_trace, trace, log.events, log.span))

    def _plot(self, name: str, title: str, draw: Any) -> None:
        draw_in(self, draw, title, name)
        self.display = any(one.display for one in self.query(Plot))


def _figures(row: FlightRow, beside: FlightBesideOthers | None, system: str) -> Iterable[Hanging]:
    yield cards.lines(cards.heading(row.flight, row.id), ())
    if beside is not None:
        yield hanging([why(beside, system)])
    inferred = (("Cd", row.drag), ("Thrust factor", row.thrust))
    yield cards.lines("Inferred", [(name, f"{value:.2f}") for name, value in inferred if value is not None], 20)
    yield cards.lines("Readouts", cards.readouts(row.flight, system), 20)
    if row.flight.tags:
        yield cards.lines("Tags", cards.tags(row.flight))
    yield cards.lines("Setup and conditions", cards.circumstances(row.flight, system), 20)
    if row.flight.extra:
        yield cards.lines("Other data", logged.beside(row.flight.extra, system), 20)


def _draw_course(row: FlightRow, known: Sequence[FlightRow], plt: Any, ink: Any) -> None:
    """Draw Cd of each flight in order, with a vertical line at the current one and their ids below."""
    drags = [one.drag or 0.0 for one in known]
    plt.scatter(list(range(len(known))), drags, marker="●", color=ink.line)
    here = next((place for place, one in enumerate(known) if one.id == row.id), None)
    if here is not None:
        plt.vline(here, color=ink.mark)
        plt.scatter([here], [drags[here]], marker="●", color=ink.mark)
    label_flights(plt, ink, [one.id for one in known], here)
    at = round_ticks(min(drags), max(drags), max(3, ink.height // 4))
    plt.yticks(at, [f"{drag:g}" for drag in at])


FLIGHTS_PER_BATCH = 40
"""Number of flights whose drag and thrust are computed together, in about a second, so that others do not wait. [1]"""
MAX_COMPARED = 40
"""Number of top flights whose rockets' flights are compared with each other. [1]"""
MAX_INFERRED = 400
"""Number of top flights whose drag and thrust are computed automatically. [1]"""
REST = 0.15
"""Time that the cursor has to rest on a flight before its log is read. [s]"""
NOT_FOUND = "no flight matches all of these words; / changes them"


class FlightsScreen(PageScreen):
    """The table, a filter, and, if there is room, the flight under the cursor."""

    NAME = "flights"
    ON_ENTER = ("Open", "Open this flight")
    TITLE = "Flights"
    ABOUT = FLIGHTS_HELP
    BINDINGS: ClassVar[list[BindingType]] = [
        LEAVE_LINE,
        Binding("slash", "find", "Find", key_display="/", tooltip="Find flights by any words"),
        Binding("s", "sort", "Sort", tooltip="Sort by the next column"),
        Binding("z", "turn", "Z-A", tooltip="Reverse the order", show=False),
        Binding("t", "tag", "Tag", tooltip="Tag or untag this flight"),
        Binding("e", "edit", "Edit flight", tooltip="Correct the entries of this flight", show=False),
        Binding("a", "app.page('add')", "Add", tooltip="Enter a flight by hand"),
        Binding("w", "report", "Report", tooltip="Write the report of this flight's day", show=False),
        REMOVE,
    ]
    DEFAULT_CSS = """
    FlightsScreen #filter { height: 1; }
    FlightsScreen #filter Static { width: auto; padding: 0 1; }
    FlightsScreen #filter Input { width: 1fr; height: 1; }
    FlightsScreen #beside { width: 30%; min-width: 40; display: none; padding: 0 0 0 1; border: round $border-blurred;
        border-title-color: $foreground; border-subtitle-color: $foreground; }
    FlightsScreen.-wide #beside { display: block; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._rows: dict[str, FlightRow] = {}
        self._asked: set[str] = set()
        self._compared: dict[tuple[str, str], FlightBesideOthers] = {}
        self._compared_rockets: set[str] = set()
        self._inference: FlightInference | None = None
        self._order, self._down = "date", True
        self._scale = HeightScale(0.0, 1.0)
        self._rest: Timer | None = None

    def body(self) -> Iterable[Widget]:
        """The filter, the table, and the flight next to it."""
        with Horizontal(id="filter"):
            yield Static("/", classes="slash")
            yield Line(placeholder="filter: rocket, motor, tag, month ...", compact=True)
            yield Static("", id="count")
        with Horizontal():
            with Vertical():
                yield Table(empty="reading the ledger ...", id="table", enter=self.ON_ENTER[0])
                yield FlightPlots()
            yield FlightCard(id="beside", classes="framed")

    def on_mount(self) -> None:
        """Focus the table."""
        self.set_focus(self.query_one(Table))

    def reload(self) -> None:
        """Read the flights; drag and thrust of each follow."""
        self.ask(lambda: read_rows(self.resources.ledger, self.resources.motors), self._have)

    def redraw(self) -> None:
        """Show the same rows in other units."""
        self._refill()

    def _have(self, rows: list[FlightRow]) -> None:
        self._inference = None  # messages of other rockets may have changed
        self._compared.clear()
        self._compared_rockets.clear()
        known = {row.id: row for row in self._rows.values() if row.thrust is not None}
        for row in rows:
            if (before := known.get(row.id)) and before.flight == row.flight:
                row.drag, row.thrust = before.drag, before.thrust
        self._rows = {row.id: row for row in rows}
        self._asked = {row.id for row in rows if row.thrust is not None}
        self._refill()
        self._infer()
        self.field_app.settled(self.NAME)

    def _infer(self) -> bool:
        """Compute missing drag and thrust for some flights at a time, the top ones of the table first; False if none is
        missing."""
        top = (self._rows[id] for id in self.query_one(Table).keys[:MAX_INFERRED])
        waiting = [row for row in top if row.id not in self._asked][:FLIGHTS_PER_BATCH]
        if waiting:
            self._asked |= {row.id for row in waiting}
            self.ask(partial(self._inferred, waiting), self._have_drag, "drag", in_turn=True)
        return bool(waiting)

    def _inferred(self, rows: Sequence[FlightRow]) -> list[tuple[FlightRow, Inferred]]:
        if self._inference is None:
            self._inference = FlightInference(self.resources.ledger, self.resources.motors)
        owners = {id(row.flight): row for row in rows}
        found = self._inference.infer([row.flight for row in rows]).inferred
        return [(owners[id(one.flight)], one) for one in found]

    def _have_drag(self, found: list[tuple[FlightRow, Inferred]]) -> None:
        for row, one in found:
            row.drag, row.thrust = one.cd, one.alpha
        self.query_one(Table).refresh()
        self._beside()
        if not self._infer():
            self.field_app.settled(self.NAME)

    def _shown(self) -> list[Shown]:
        """The columns, as wide as the table has room for."""
        beside = self.has_class("-wide")
        flights = [row.flight for row in self._rows.values()]
        rocket = max((cell_len(flight.rocket) for flight in flights), default=0)
        tags = max((cell_len(" ".join(flight.tags)) for flight in flights), default=0)
        width, system = self.query_one(Table).size.width, self.resources.settings.units
        return columns(width, self._scale, system, beside=beside, rocket=rocket, tags=tags)

    def _sorted_by(self, shown: Sequence[Shown]) -> int:
        """The place of the column that determines the order; that of the date if the column does not fit."""
        keys = [one.key for one in shown]
        return keys.index(self._order if self._order in keys else "date")

    def _sort_by(self, column: Shown) -> None:
        self._order, self._down = column.key, column.falls
        self._refill()

    @on(Input.Changed)
    def _filtered(self) -> None:
        self.query_one(Table).by_hand = False  # start at the first flight
        self._refill()
        self._infer()

    def _refill(self) -> None:
        """Show the rows that match all words of the filter, in order."""
        words = self.query_one(Input).value.lower().split()
        self._scale = scale_of(self._rows.values(), self.resources.settings.target)
        rows = [row for row in self._rows.values() if all(word in row.hay for word in words)]
        system = self.resources.settings.units
        shown = self._shown()
        place = self._sorted_by(shown)
        self.query_one(Table).empty = NOT_FOUND if words else NO_FLIGHTS
        self.query_one(Table).show(
            headings(shown, place, falls=self._down),
            [row.id for row in sorted(rows, key=shown[place].order, reverse=self._down)],
            lambda id: [column.text(self._rows[id], system) for column in shown],
        )
        unit = spelled(unit_of(cards.APOGEE, system))
        self.query_one("#count", Static).update(Content(f"{len(rows)} of {len(self._rows)} · apogee in {unit}"))
        self._beside()

    def _row(self) -> FlightRow | None:
        """The flight under the cursor; None if there is none, or if the page is being closed and its table is gone."""
        tables = self.query(Table)
        return self._rows.get(tables.first().current) if tables else None

    async def _row_read(self) -> FlightRow | None:
        """The flight under the cursor, once the flights are read: a key may be typed ahead."""
        await self.settled("ask")
        return self._row()

    @on(Table.Moved)
    def _moved(self) -> None:
        """Show the cursor first, then the card."""
        self.soon(self._beside)

    def _beside(self) -> None:
        """Show the card of the flight under the cursor, if there is room, and its log after the cursor rests."""
        if self._rest is not None:
            self._rest.stop()
        row, wide = self._row(), self.has_class("-wide")
        drawn = row if wide and self.has_class("-tall") else None
        self.query_one(FlightPlots).show(drawn, same_build(self._rows.values(), drawn) if drawn is not None else [])
        if wide:
            self._show_card()
        if row is not None:
            self._rest = self.set_timer(REST, partial(self._read_more, row, log=drawn is not None))

    def _show_card(self) -> None:
        row = self._row()
        beside = None if row is None else self._compared.get((row.flight.rocket, row.flight.flight_id))
        self.query_one(FlightCard).show(row, beside, self.resources.settings.units)

    def _read_more(self, row: FlightRow, *, log: bool) -> None:
        """Read the log of a flight, and compare the flights of its rocket."""
        resources = self.resources
        if log:
            work = or_why(partial(drawn, resources.ledger, row.id, resources.settings.units))
            self.ask(work, partial(self._have_log, row.id), "log")
        top = (self._rows[id].flight for id in self.query_one(Table).keys[:MAX_COMPARED])
        new = {flight.rocket: flight for flight in (row.flight, *top) if flight.rocket not in self._compared_rockets}
        if new:
            self._compared_rockets |= new.keys()
            self.ask(partial(beside_others, resources, new.values()), self._have_compared, "beside", alone="app")

    def _have_compared(self, found: Beside) -> None:
        """Show the misses of flights without a saved forecast, and why the flight under the cursor missed."""
        self._compared |= found
        for row in self._rows.values():
            if (one := found.get((row.flight.rocket, row.flight.flight_id))) is not None:
                row.expected = one.interval
        self._scale = scale_of(self._rows.values(), self.resources.settings.target)
        self._refill()

    def _have_log(self, id: str, log: Drawn | str) -> None:
        row = self._row()
        if row is not None and row.id == id:
            self.query_one(FlightPlots).show_climb(log if isinstance(log, Drawn) else None)

    @on(Table.HeadClicked)
    def _head(self, message: Table.HeadClicked) -> None:
        shown = self._shown()
        if message.column == self._sorted_by(shown):
            self.action_turn()
        else:
            self._sort_by(shown[message.column])

    @on(Table.Chosen)
    def _open(self, message: Table.Chosen) -> None:
        self.open_flight(message.key)

    def open_flight(self, id: str) -> None:
        """Open a flight once, even if Enter is pressed twice."""
        if self._flight not in self.app.screen_stack:
            self._flight.turn_to(id)
            self.app.push_screen(self._flight)

    def show_only(self, words: str) -> None:
        """Show only the flights that match all of these words."""
        self.query_one(Input).value = words
        self.set_focus(self.query_one(Table))

    @cached_property
    def _flight(self) -> FlightScreen:
        """The screen of a flight, reused for all flights, because building it is slow."""
        screen = FlightScreen()
        self.app.install_screen(screen, "flight")
        return screen

    def above(self) -> Iterable[PageScreen]:
        """The screen of one flight."""
        return (self._flight,)

    def on_resize(self, _event: events.Resize) -> None:
        """Choose the columns and the card by the width."""
        if self._rows:
            self.call_later(self._refill)  # after the new width has taken effect

    def action_find(self) -> None:
        """Focus the filter."""
        self.set_focus(self.query_one(Input))

    def action_sort(self) -> None:
        """Sort by the next column."""
        shown = self._shown()
        self._sort_by(shown[(self._sorted_by(shown) + 1) % len(shown)])
        self._infer()

    def action_turn(self) -> None:
        """Reverse the order."""
        self._down = not self._down
        self._refill()
        self._infer()

    async def action_tag(self) -> None:
        """Choose tags for the flight under the cursor."""
        if (row := await self._row_read()) is not None:
            self.app.push_screen(TagScreen(row.id, row.flight))

    async def action_edit(self) -> None:
        """Edit the flight under the cursor."""
        if (row := await self._row_read()) is not None:
            ask_changes(self, row.id, row.flight, lambda _: None)

    async def action_remove(self) -> None:
        """Remove the flight under the cursor."""
        if (row := await self._row_read()) is not None:
            remove(self, row.id)

    async def action_report(self) -> None:
        """Write the report of the day of the flight under the cursor, or of the flight if no day is known."""
        if (row := await self._row_read()) is not None:
            day = row.flight.date_time
            ask_report(self, f"{day:%Y-%m-%d}" if day else row.id)

    def copied(self) -> str:
        """The row under the cursor."""
        return self.query_one(Table).current_text()
