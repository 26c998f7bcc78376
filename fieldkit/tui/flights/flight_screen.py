"""One flight: its readouts, the drag and thrust inferred from them, its log, and its forecast.

The drag and thrust inferred from one flight, as densities.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit import files
from fieldkit.errors import LedgerError
from fieldkit.flight import CONDITIONS, READOUTS, SETUP, Flight
from fieldkit.flight.event_names import event_title
from fieldkit.flight.short_name import flight_label
from fieldkit.presentation import logged
from fieldkit.presentation.kml import check_track, track_file
from fieldkit.quantities import in_system, measure, number, with_sd
from fieldkit.safe_text import printable
from fieldkit.services.coast_drag import CoastDrag, coast_drag
from fieldkit.services.flight_facts import ForecastFacts, drag_facts, forecast_facts
from fieldkit.services.plausible_flights import exclusion, used_except
from fieldkit.services.replay import track_of
from fieldkit.tui.asking import or_why
from fieldkit.tui.flights.edit_form import ask_changes
from fieldkit.tui.flights.log_plot import TRACES, Drawn, draw_drag, draw_trace, drawn
from fieldkit.tui.flights.log_view import LogLook, LogView, look_at_flight
from fieldkit.tui.flights.removal import REMOVE, close, leave, remove
from fieldkit.tui.flights.tag_screen import TagScreen
from fieldkit.tui.help import Help
from fieldkit.tui.next.intervals import IntervalBar, bar
from fieldkit.tui.page import PageScreen
from fieldkit.tui.report import Written, ask_file, ask_report
from fieldkit.tui.resources import Resources
from fieldkit.tui.setup.rocket_strip import RocketStrip, rocket_facts
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import hanging, stacked
from fieldkit.tui.widgets.plots import Plot, draw_density


@dataclass(frozen=True, slots=True)
class Hills:
    """The plots of drag and thrust: positions, headings and densities, with warnings."""

    drawn: tuple[tuple[str, str, Callable[[Any, Any], Any]], ...]
    warnings: tuple[str, ...]


def hills(flight: Flight, resources: Resources) -> Hills:
    """The posterior of a flight for its plot. Raises FieldkitError if there is none."""
    drag = drag_facts(flight, resources.ledger, resources.motors, resources.settings.units)
    drawn = tuple(
        (place, f"{title}  {with_sd(values.mean(), values.std())}", draw_density(values, lambda value: f"{value:g}"))
        for place, title, values in (("drag", drag.drag_name, drag.drag), ("thrust", "thrust", drag.thrust))
    )
    return Hills(drawn, drag.warnings)


MIN_LINES_FOR_ROCKET = 34
"""Minimum height of a wide terminal that shows the rocket below a flight without a log. [cell]"""
EMPTY_WIDGETS = ("heading", "forecast", "drag-title", "thrust-title", "doubts", "log-title")
"""Widgets that are empty until the flight is read."""
PLACES = {"figures": "reading ..."} | dict.fromkeys(EMPTY_WIDGETS, "")
"""Texts of widgets until the flight is read."""


class FlightScreen(PageScreen):
    """A flight opened from the table; `turn_to` sets the flight and can be called again."""

    NAME = "flights"
    TITLE = "Flight"
    ABOUT = Help(
        "Everything known about one flight: readouts and masses; its forecast, an interval that should hold nine "
        "flights in ten, and the result; drag and thrust as densities, likelier where the curve is higher.",
        (
            ("Cd", "Drag of the rocket in this flight. A wide curve means these readouts constrain it poorly."),
            ("thrust", "Thrust factor (alpha) of this motor relative to the certified thrust; 1 is as certified."),
            ("├──●──┤", "The forecast: 5%, median and 95%. ◆ is the flown apogee."),
            ("± 1 m", "One standard deviation: the true value is this close two times in three."),
            (
                "Log",
                "Altitude, speed and acceleration from lift-off (T+0) to landing, events marked; l to add a cursor.",
            ),
            ("Other data", "Other data from the flight's file, as written there."),
            *((column.title, column.help) for column in (*READOUTS, *SETUP, *CONDITIONS)),
        ),
        (
            "fieldkit show FLIGHT",
            "fieldkit infer FLIGHT",
            "fieldkit edit FLIGHT apogee=281m",
            "fieldkit remove FLIGHT",
            "fieldkit report FLIGHT --out card.html",
            "fieldkit track FLIGHT --out track.gpx",
        ),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "back", "Back", priority=True, tooltip="Back to the list"),
        Binding("t", "tag", "Tag", tooltip="Tag or untag this flight"),
        Binding("e", "edit", "Edit flight", tooltip="Correct the entries of this flight"),
        Binding("l", "look", "Look", tooltip="Its log, with a cursor for height, speed and acceleration", show=False),
        Binding("w", "report", "Report", tooltip="Write a report on this flight for the log book", show=False),
        Binding("G", "track", "GPS track", tooltip="Write its GPS track for maps, as KML or GPX", show=False),
        REMOVE,
        Binding("down,up,pagedown,pageup,home,end", "scroll_page", "Scroll", show=False),
    ]
    DEFAULT_CSS = """
    FlightScreen #heading { height: 1; padding: 0 1; text-style: bold; color: $primary; }
    FlightScreen #all { height: 1fr; padding: 0 1; }
    FlightScreen #columns, FlightScreen #hills, FlightScreen #log { height: auto; }
    FlightScreen #figures { width: 40; height: auto; padding: 0 1 0 0; }
    FlightScreen #pictures { width: 1fr; height: auto; }
    FlightScreen #all Static { height: auto; margin-bottom: 1; }
    FlightScreen #all #doubts.-none { display: none; }
    FlightScreen #all Plot { height: 7; margin-bottom: 1; }
    FlightScreen.-tall #all Plot { height: 11; }
    FlightScreen.-wide.-unlogged #all { height: auto; max-height: 70%; }
    FlightScreen.-wide RocketStrip { height: 1fr; max-height: 40; }
    FlightScreen.-wide.-unlogged RocketStrip.-shown { display: block; }
    FlightScreen #all #log Plot { height: 9; border-top: solid $border-blurred; margin: 0;
        border-title-color: $foreground; }
    FlightScreen.-tall #all #log Plot { height: 22vh; min-height: 11; }
    FlightScreen.-tall.-wide.-unlogged #all #hills Plot { height: 28vh; }
    FlightScreen #hills Vertical { height: auto; width: 1fr; margin-right: 2; }
    FlightScreen #all #hills Static { margin-bottom: 0; }
    FlightScreen.-narrow #columns, FlightScreen.-narrow #hills, FlightScreen.-normal #hills { layout: vertical; }
    FlightScreen.-narrow #figures, FlightScreen.-narrow #pictures { width: 1fr; }
    FlightScreen.-wide #figures { width: 52; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._flight_id = ""
        self._flight: Flight | None = None
        self._text: list[str] = []

    def turn_to(self, id: str) -> None:
        """Show another flight: the old contents are cleared, and the new ones appear as they are read."""
        self._flight_id, self._flight, self._text = id, None, []
        for question in ("ask", "hills", "forecast", "log", "coast", "rocket", "look"):
            self.workers.cancel_group(self, question)
        self.reload_on_resume()
        for place in self.query(Static):
            if place.id in PLACES:
                place.update(PLACES[place.id])
        for plot in self.query("#all Plot").results(Plot):
            plot.show(None)
        self.query(RocketStrip).remove_class("-shown")
        for scrolled in self.query("#all").results(VerticalScroll):
            scrolled.scroll_home(animate=False, immediate=True)

    def body(self) -> Iterable[Widget]:
        """One scrolling page: figures on the left, plots on the right."""
        yield Static(id="heading")
        with VerticalScroll(id="all"), Horizontal(id="columns"):
            yield Static(PLACES["figures"], id="figures")
            with Vertical(id="pictures"):
                yield Static(id="forecast")
                with Horizontal(id="hills"):
                    for name in ("drag", "thrust"):
                        with Vertical():
                            yield Static(id=f"{name}-title")
                            yield Plot(id=name)
                yield Static(id="doubts", classes="-none")
                with Vertical(id="log"):
                    yield Static(id="log-title")
                    for name in (*TRACES, "drag"):
                        yield Plot(id=f"log-{name}")
        yield RocketStrip()

    def action_report(self) -> None:
        """Write the report of this flight."""
        ask_report(self, self._flight_id)

    def action_track(self) -> None:
        """Write the GPS track of this flight."""
        id, ledger = self._flight_id, self.resources.ledger

        def write(path: Path, force: bool) -> Path:
            content = track_file(flight_label(id), track_of(ledger, id), path.suffix.lower())
            files.write(path, content, force=force)
            return path

        about = "A name that ends in .kml or .gpx; the same as `fieldkit track`."
        ask_file(self, Written("track", f"GPS track of {id}", f"{id}.gpx", about, check_track, write))

    def action_remove(self) -> None:
        """Remove this flight, and show the remaining ones."""
        remove(self, self._flight_id, partial(close, self))

    def on_mount(self) -> None:
        """Focus the page, so that keys scroll it."""
        self.set_focus(self.query_one("#all", VerticalScroll))

    def reload(self) -> None:
        """Read the flight; inferred values follow when they are computed."""
        self.ask(or_why(self._read), self._have)

    def _read(self) -> tuple[str, Flight, str, str]:
        """The flight with its id, which changes if another rocket has a flight with the same number, why it is
        excluded from every fit, and which of its readouts are."""
        ledger, motors, shown = self.resources.ledger, self.resources.motors, self._flight
        try:
            flight = ledger.flight(self._flight_id if shown is None else f"{shown.rocket}/{shown.flight_id}")
        except LedgerError:
            flight = ledger.flight(self._flight_id)
            if shown is None or flight.readouts() != shown.readouts():
                raise  # it is another rocket's; else the rocket was renamed
        return ledger.ids([flight])[0], flight, exclusion(flight, motors), used_except(flight, motors)

    def _have(self, read: tuple[str, Flight, str, str] | str) -> None:
        if isinstance(read, str):
            leave(self, self._flight_id)
            return
        self._flight_id, flight, excluded, unused = read
        self._flight, system = flight, self.resources.settings.units
        used = in_system(_use(excluded, unused), system)
        self.query_one("#heading", Static).update(Content(printable(cards.heading(flight, self._flight_id))))
        blocks = [
            cards.lines("Readouts", cards.readouts(flight, system), 20),
            cards.lines("Setup and conditions", cards.circumstances(flight, system), 20),
            cards.lines("Tags", cards.tags(flight)) if flight.tags else hanging([used]),
        ]
        if flight.extra:
            blocks.append(cards.lines("Other data", logged.beside(flight.extra, system), 20))
        self._text = [cards.heading(flight, self._flight_id), *map(str, blocks)]
        self.query_one("#figures", Static).update(stacked(blocks))
        self.ask(or_why(partial(hills, flight, self.resources)), self._show_hills, "hills")
        self.ask(
            or_why(
                lambda: forecast_facts(
                    flight, self.resources.ledger, self.resources.motors, self.resources.comparisons, system
                )
            ),
            self._have_forecast,
            "forecast",
        )
        self.ask(or_why(partial(drawn, self.resources.ledger, self._flight_id, system)), self._have_log, "log")

    def _have_log(self, log: Drawn | str) -> None:
        title = self.query_one("#log-title", Static)
        self._have_coast(None)
        self.set_class(isinstance(log, str), "-unlogged")
        for name in TRACES:
            trace = log.traces.get(name) if isinstance(log, Drawn) else None
            plot = self.query_one(f"#log-{name}", Plot)
            plot.display = trace is not None
            if trace is not None and isinstance(log, Drawn) and len(trace.time) > 1:
                plot.border_title = Content(trace.title)
                plot.show(partial(draw_trace, trace, log.events, log.span))
        if isinstance(log, str):
            title.update(Content(printable(log)))
            if self._flight is not None and self.size.height >= MIN_LINES_FOR_ROCKET:
                facts = partial(rocket_facts, self.resources, self._flight)
                self.ask(facts, self.query_one(RocketStrip).show, "rocket")
            return
        events = sorted(log.events.items(), key=lambda one: one[1])
        marks = printable(", ".join(f"{event_title(name)} T{time:+.2f} s" for name, time in events))
        title.update(Content.assemble(("Log", "b $primary"), f"  {printable(log.device)}  l for a cursor\n{marks}"))
        self._text.append(f"Log  {marks}")
        self.ask(or_why(partial(coast_drag, self.resources.ledger, self._flight_id)), self._have_coast, "coast")

    def _have_coast(self, found: CoastDrag | str | None) -> None:
        """Show drag against time in the coast, if the log shows it."""
        plot = self.query_one("#log-drag", Plot)
        plot.display = isinstance(found, CoastDrag)
        if isinstance(found, CoastDrag):
            plot.border_title = Content("coast drag over its mean; dim: 90%")
            plot.show(partial(draw_drag, found))

    def _show_hills(self, hills: "Hills | str") -> None:
        for plot in self.query("#hills Plot"):
            plot.display = not isinstance(hills, str)
        if isinstance(hills, str):
            self.query_one("#drag-title", Static).update(Content(printable(hills)))
            return
        for name, title, draw in hills.drawn:
            self.query_one(f"#{name}-title", Static).update(Content(title).stylize("bold"))
            self.query_one(f"#{name}", Plot).show(draw)
            self._text.append(title)
        doubts = self.query_one("#doubts", Static)
        doubts.set_class(not hills.warnings, "-none")
        doubts.update(hanging(f"! {in_system(line, self.resources.settings.units)}" for line in hills.warnings))

    def _have_forecast(self, facts: ForecastFacts | str) -> None:
        place = self.query_one("#forecast", Static)
        if isinstance(facts, str) or self._flight is None:
            place.update(Content(f"no forecast: {printable(str(facts))}"))
            return
        system, flown = self.resources.settings.units, self._flight.apogee
        low, high = number(cards.APOGEE, facts.low, system), measure(cards.APOGEE, facts.high, system)
        parts: cards.Styled = [("Forecast and flown", "b $primary"), "\n"]
        parts += [f"{printable(line)}\n" for line in facts.by.splitlines()]
        parts.append((f"{measure(cards.APOGEE, facts.middle, system)}, 90% in {low} to {high}", "b"))
        if flown is not None:
            inside = "inside" if facts.low <= flown <= facts.high else "outside"
            off = measure(cards.APOGEE, abs(flown - facts.middle), system)
            way = "higher" if flown >= facts.middle else "lower"
            parts.append(f"\nflown {measure(cards.APOGEE, flown, system)}: {off} {way}, {inside} the interval")
        row = IntervalBar("", facts.low, facts.middle, facts.high, flown)
        parts.append(("\n" + bar(row, *row.ends, 36), "$accent"))
        place.update(content := Content.assemble(*parts))
        self._text.append(content.plain)

    async def action_tag(self) -> None:
        """Choose tags, once the flight is read."""
        await self.settled("ask")
        if self._flight is not None:
            self.app.push_screen(TagScreen(self._flight_id, self._flight))

    def action_look(self) -> None:
        """Show the log with a cursor."""
        work = partial(look_at_flight, self.resources.ledger, self._flight_id, self.resources.settings.units)
        self.ask(work, self._have_look, "look")

    def _have_look(self, look: LogLook | str) -> None:
        if isinstance(look, str):
            self.complain(look)
        elif self.is_current:
            self.app.push_screen(LogView([look], self.resources.settings.units))

    async def action_edit(self) -> None:
        """Edit the flight, once it is read."""
        await self.settled("ask")
        if self._flight is not None:
            ask_changes(self, self._flight_id, self._flight, self._renamed)

    def _renamed(self, id: str) -> None:
        """Show the same flight by its new id."""
        self._flight_id, self._flight = id, None

    def copied(self) -> str:
        """The flight as a card of text."""
        return "\n\n".join(self._text)


def _use(excluded: str, unused: str) -> str:
    """Whether a flight without tags is used in the model, and if not, why; and which of its readouts are not."""
    if excluded:
        return f"Not used in the model: {excluded}"
    return f"Used in the model, but {unused}" if unused else "Used in the model"
