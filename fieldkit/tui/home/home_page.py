"""Home: the next rocket, the weather of the day, the open forecast, the last flight, the latest flights.

It is the first page: what only a key opens is imported by that key. At the top it would delay the first rows by 0.9 s
of processor time for the screen of a flight, 0.5 s for the plan, and 0.3 s for a form; after the launch day has been
read it is imported in 20 to 70 ms.

The two cards of the Home page: the open forecast, and the last flight with its forecast.

The three actions of a launch day, large enough to hit with a finger.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import date, datetime
from functools import cached_property, partial
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, ClassVar

from textual import events, on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widget import AwaitMount, Widget
from textual.widgets import Static

from fieldkit.flight import BY_NAME, Flight
from fieldkit.presentation import home_text
from fieldkit.quantities import number
from fieldkit.safe_text import printable
from fieldkit.services.fleet_findings import saved_findings
from fieldkit.services.listed_flights import ListedFlight, listed_at_once
from fieldkit.tui.asking import or_why
from fieldkit.tui.help import Help
from fieldkit.tui.home.first_steps import FIRST_STEPS, Step, launch_day, step_cells
from fieldkit.tui.home.home_rows import listed, logs_of, trend
from fieldkit.tui.next.intervals import IntervalBar, bar
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import IMPORTING
from fieldkit.tui.setup.rocket_strip import RocketStrip, rocket_facts
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.table import Head, Table

if TYPE_CHECKING:
    from fieldkit.services.launch_day import Overview
    from fieldkit.tui.comparing import Beside
    from fieldkit.tui.flights.flight_screen import FlightScreen
    from fieldkit.tui.flights.log_plot import Drawn
    from fieldkit.tui.pad.pad_screen import PadTimer


CHOICES = (("f", "Fly", "choose a motor"), ("a", "Add", "add a flight"), ("p", "Plan", "rocket and weather"))
"""Key, name, and description."""
LONG_CHOICE_WIDTH = 34
"""Width above which a choice shows its description. [cell]"""


class Choice(Static):
    """A key in a frame with its name and, if there is room, its description; a click presses it."""

    DEFAULT_CSS = """
    Choice { width: 1fr; height: 3; border: round $border; text-align: center; }
    """

    def __init__(self, key: str, name: str, about: str) -> None:
        super().__init__()
        self._key, self._words = key, (name, about)

    def render(self) -> Content:
        """The key and its words."""
        name, about = self._words
        more = f"  {about}" if self.size.width > LONG_CHOICE_WIDTH else ""
        return Content.assemble((f" {self._key} ", "b reverse"), (f" {name}", "b"), more)

    async def on_click(self) -> None:
        """Do what the key does."""
        await self.run_action(f"app.press({self._key!r})")


APOGEE = BY_NAME["apogee"]


class HomeCard(Vertical):
    """A heading, a large number with text beside it, an interval, a last line. They are mounted when there is something
    to show, so that the first rows of the page do not wait for them."""

    DEFAULT_CSS = """
    HomeCard { width: 1fr; height: 1fr; border: round $border-blurred; padding: 0 1; margin: 0 1;
        border-title-color: $foreground; border-subtitle-color: $foreground; }
    HomeCard > Static { height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; }
    HomeCard > .heading { text-style: bold; }
    HomeCard > .bar { color: $accent; }
    HomeCard Horizontal { height: 3; }
    HomeCard Horizontal > .words { width: 1fr; height: 3; padding: 0 0 0 2; }
    HomeCard.-plain Horizontal, HomeCard.-plain .bar { display: none; }
    HomeCard.-plain > .last { height: auto; text-wrap: wrap; }
    """
    interval: IntervalBar | None = None

    def __init__(self, **rest: Any) -> None:
        super().__init__(**rest)
        self._big = Big()
        self._heading, self._words, self._bar, self._last = (
            Static("", classes=name) for name in ("heading", "words", "bar", "last")
        )

    def _fill(self) -> None:
        """Mount the contents, from top to bottom."""
        if not self.children:
            self.mount(self._heading, Horizontal(self._big, self._words), self._bar, self._last)

    def say(self, heading: str, last: str = "") -> None:
        """Show only text: no number is known."""
        self._fill()
        self.add_class("-plain")
        self.interval = None
        self._heading.update(lines(heading))
        self._last.update(lines(last))

    def figure(self, heading: str, value: str, words: Iterable[str], interval: IntervalBar | None, last: str) -> None:
        """Show a number, the text beside it, and its interval."""
        self._fill()
        self.remove_class("-plain")
        self._heading.update(lines(heading))
        self._big.show(value)
        self._words.update(lines("\n".join(words)))
        self._last.update(lines(last))
        self.interval = interval
        self.on_resize()

    def on_resize(self) -> None:
        """Draw the interval as wide as the card."""
        width = self.size.width - 2
        row = self.interval
        drawn = bar(row, *row.ends, width) if row is not None and width > 10 else ""
        self._bar.update(Content(drawn), layout=False)


def lines(text: str) -> Content:
    """A text of several lines as content, safe for a terminal."""
    return Content("\n".join(printable(line) for line in text.splitlines()))


class NextCard(HomeCard):
    """The next flight."""

    def on_mount(self) -> None:
        """Set the title."""
        self.border_title = "Next flight"

    def show(self, view: "Overview | None", system: str) -> None:
        """Show the open forecast, else the rocket to plan."""
        self.border_subtitle = ""
        if view is None:
            self.say("No rocket yet. Choose a first step below and press Enter.")
            return
        weather = home_text.weather_line(view.weather, system)
        forecast = view.forecast
        if forecast is None:
            heading = "\n".join(home_text.next_lines(view, system))
            self.say(heading, f"No open forecast. f to choose a motor, then Enter to save its forecast.\n{weather}")
            return
        low, middle, high = forecast.interval
        title, words = home_text.forecast_title(forecast), home_text.forecast_lines(forecast, system)
        big = number(APOGEE, middle, system)
        self.border_subtitle = "Flown? a to add it"
        self.figure(title, big, words, IntervalBar("", low, middle, high), weather)


class LastCard(HomeCard):
    """The last flight."""

    def on_mount(self) -> None:
        """Set the title."""
        self.border_title = "Last flight"

    def show(self, view: "Overview | None", system: str, today: date) -> None:
        """Show the last flight with its forecast, and the flights of the day in one line."""
        last = view.last if view is not None else None
        self.display = view is not None
        self.border_subtitle = ""
        if view is None or last is None or last.flight.apogee is None:
            self.say("Nothing has flown yet.")
            return
        forecast, apogee = last.forecast, last.flight.apogee
        interval = IntervalBar("", *forecast.interval, flown=apogee) if forecast is not None else None
        words: Sequence[str] = list(home_text.flown_lines(last, system))
        title, day = home_text.flown_title(last), home_text.day_line(view.on(today), system)
        self.border_subtitle = trend(view.flights, last.flight.rocket)
        self.figure(title, number(APOGEE, apogee, system), words, interval, day)


FIRST_READ = 0.03
"""The longest wait for the latest flights before the first paint, so that it shows them. [s] With rows in the second
paint, they take 1.43 times the processor time of an empty app; in the first one, 1.34 times."""
PAINT_TIME, MAX_PAINT = 0.05, 1.0
"""Time to paint the first rows before the engine is imported, and the longest wait for that. [s]"""


class HomeScreen(PageScreen):
    """Three choices, two cards, and the latest flights; with an empty ledger, the first steps."""

    NAME = "home"
    ON_ENTER = ("Open", "Open this flight, or begin with this step")
    TITLE = "Home"
    ROW_REQUESTS = ("ask", "overview")
    ABOUT = Help(
        "Your launch day in three keys: f to choose a motor and save its forecast, a to add the flight with rocket, "
        "motor and weather of that forecast, p to change rocket, mass and weather.",
        (
            ("cards", "The open forecast, or the rocket to plan; and the last flight beside its forecast."),
            ("list", "The latest flights, today's first; Enter to open one."),
            ("weather", "Entered once (e), it is used in every plan and flight of the day."),
            (
                "miss",
                "Flown minus the forecast saved before the flight, ! outside its interval; with ~ against what the "
                "other flights lead to expect.",
            ),
            ("profile", "Height against time, from the log of the flight. Empty without a log."),
            (
                "forecast ◆ ◎",
                "Forecast, or what the other flights lead to expect, flown ◆, target ◎ on one scale: ├─●─┤ is the 90% "
                "interval with the median.",
            ),
            ("stale", "Mass, motor, weather or model has changed since the forecast was saved."),
        ),
        ("fieldkit flights", "fieldkit predict --motor F24-4W --wind 8mph", "fieldkit add", "fieldkit demo"),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("p", "plan", "Plan", show=False, tooltip="Enter rocket, mass and conditions"),
        Binding("e", "day_weather", "Weather", tooltip="Enter today's weather, for every plan and flight of the day"),
        Binding("K", "pad", "Check", tooltip="The checklist at the pad, and the contest's timer"),
    ]
    HORIZONTAL_BREAKPOINTS = [*PageScreen.HORIZONTAL_BREAKPOINTS, (150, "-broad")]  # noqa: RUF012  # as Textual has it
    DEFAULT_CSS = """
    HomeScreen #choices { height: 3; padding: 0 1; }
    HomeScreen #cards { height: 8; }
    HomeScreen.-narrow #cards { height: 14; layout: vertical; }
    HomeScreen.-tall #cards { height: 10; }
    HomeScreen.-narrow.-tall #cards { height: 16; }
    HomeScreen #cards.-empty { height: 5; }
    HomeScreen.-tall RocketStrip.-shown { display: block; }
    HomeScreen #split { height: 1fr; }
    HomeScreen Table { height: 1fr; margin: 0 1; }
    HomeScreen #left { width: 3fr; }
    HomeScreen.-broad Pane { width: 2fr; }
    HomeScreen #share { height: auto; max-height: 3; margin: 0 2; display: none; }
    HomeScreen #share.-shown { display: block; }
    HomeScreen.-first Table { height: 6; }
    HomeScreen #day { height: 1fr; padding: 0 2; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._view: Overview | None = None
        self._profiles: dict[str, tuple[Flight, str]] = {}
        self._beside: "Beside" = {}
        self._have_read = False
        self._first: list[ListedFlight] | None = None
        self._painted = Event()
        self._timer: PadTimer | None = None

    def body(self) -> Iterable[Widget]:
        """The choices, the cards, the latest flights."""
        yield Horizontal(*(Choice(*one) for one in CHOICES), id="choices")
        with Horizontal(id="cards"):
            yield NextCard(id="next")
            yield LastCard(id="last")
        with Horizontal(id="split"), Vertical(id="left"):
            yield Table(empty="reading the ledger ...")

    def on_mount(self) -> None:
        """Focus the table, and list the latest flights in it if they are read in a moment."""
        self.set_focus(self.query_one(Table))
        if not self._have_read:
            reading = Thread(target=self._read_first, daemon=True)
            reading.start()
            reading.join(FIRST_READ)
            self._list(self._first or ())

    def _read_first(self) -> None:
        self._first = listed_at_once(self.resources.where)

    def reload(self) -> None:
        """Read the launch day; when the app opens, the flights appear before their forecasts."""
        if self._have_read:
            self.ask(self._read, self._have)
        elif self._first is not None:
            self._read_on()
        else:
            self.ask(partial(listed_at_once, self.resources.where), self._have_first)

    def redraw(self) -> None:
        """Show the same data in other units."""
        self._show()

    def _have_first(self, latest: list[ListedFlight]) -> None:
        self._first = latest
        self._show()
        self._read_on()

    def _read_on(self) -> None:
        self.set_timer(PAINT_TIME, self._painted.set)
        self.ask(self._read_when_painted, self._have, "overview")

    def _read_when_painted(self) -> "Overview | None":
        """Read the launch day after the first rows are painted, which its imports would delay."""
        self._painted.wait(MAX_PAINT)
        return self._read()

    def _read(self) -> "Overview | None":
        with IMPORTING:
            from fieldkit.services.launch_day import overview  # takes 0.38 s to import

        return overview(self.resources.ledger, self.resources.motors)

    def _have(self, view: "Overview | None") -> None:
        self._view, self._have_read = view, True
        self._show()
        flights = view.flights if view is not None else ()
        wanted = [one for one in flights if one.flight.has_log and self._profile(one) is None]
        self.ask(partial(logs_of, self.resources, wanted), partial(self._have_profiles, wanted), "profiles")
        if flights:
            self.ask(partial(self._compare, flights), self._have_beside, "beside", alone="app")
            self.ask(lambda: saved_findings(self.resources.ledger), self._show_shared, "shared")

    def _compare(self, flights: Sequence[ListedFlight]) -> "Beside":
        with IMPORTING:
            from fieldkit.tui.comparing import beside_others  # before the first paint it would take 0.7 s

        return beside_others(self.resources, [one.flight for one in flights])

    def _have_beside(self, beside: "Beside") -> None:
        """Show the misses of flights without a saved forecast, and why flights missed."""
        self._beside = beside
        if self._view is not None:
            expected = {key: one.interval for key, one in beside.items()}
            flights = [
                replace(one, expected=expected.get((one.flight.rocket, one.flight.flight_id)))
                for one in self._view.flights
            ]
            self._view = replace(self._view, flights=tuple(flights))
            self._show()

    def _show_shared(self, lines: Sequence[str]) -> None:
        """Show what several rockets share, as found on the Loop page."""
        shared = self.query_one("#share", Static)
        shared.set_class(bool(lines), "-shown")
        shared.update(Content("\n".join(printable(f"! {line}") for line in lines[:3])))

    def _profile(self, one: ListedFlight) -> str | None:
        """The profile of a flight; None until it has been read, or if it was read for another flight with the same
        id."""
        flight, profile = self._profiles.get(one.id, (None, None))
        return profile if flight == one.flight else None

    def _have_profiles(self, read: Sequence[ListedFlight], found: dict[str, str]) -> None:
        self._profiles |= {one.id: (one.flight, found[one.id]) for one in read}
        self.query_one(Table).refresh()
        self.field_app.settled(self.NAME)

    @on(Table.Sized)
    def _show(self) -> None:
        """Show the launch day in the columns that fit."""
        if not self._have_read:
            self._list(self._first or ())
            return
        if not self.query("#share"):  # mounted here, since they delay the first rows
            self.query_one("#body").mount(Static(id="share"), before="#split")
            self.query_one("#left").mount(RocketStrip())
        system, table = self.resources.settings.units, self.query_one(Table)
        steps = self._view is None or not (self._view.flights or self._view.forecast)
        self.query_one("#cards").set_class(self._view is None, "-empty")
        self.query_one(NextCard).show(self._view, system)
        self.query_one(LastCard).show(self._view, system, datetime.now().date())
        table.on_enter = "Choose" if steps else self.ON_ENTER[0]
        self._show_day(steps)
        if steps:
            table.show([Head("First steps", 26), Head("", 0)], FIRST_STEPS, step_cells)
        elif self._view is not None:
            table.empty = "No flights yet. a to add the first one"
            self._list(self._view.flights)
        self._moved()
        self.follow_keys()

    def _show_day(self, shown: bool) -> None:
        """Show what a launch day is like below the first steps; mounted only there, since it delays the first rows."""
        self.set_class(shown, "-first")
        if shown and not self.query("#day"):
            self.query_one("#body").mount(Static(launch_day(), id="day"))
        for day in self.query("#day"):
            day.display = shown

    def _list(self, flights: Sequence[ListedFlight]) -> None:
        """Show the rows of the table."""
        table = self.query_one(Table)
        rows, width = {one.id: one for one in flights}, table.size.width
        heads, cells = listed(flights, self.resources.settings, width)
        table.show(heads, list(rows), lambda id: cells(rows[id], self._profile(rows[id]) or ""))

    def on_resize(self, _event: events.Resize) -> None:
        """Show the rocket if the new height has room for it."""
        self.call_after_refresh(self._moved)  # when the height has taken effect

    @on(Table.Moved)
    def _moved(self) -> None:
        """Show the flight under the cursor on a broad screen, and its rocket on a tall one."""
        if not self._have_read:
            return
        key = self.query_one(Table).current
        self._show_pane(key)
        listed = self._view.flights if self._view is not None and self.has_class("-tall") else ()
        flight = next((one.flight for one in listed if one.id == key), None)
        strip = self.query_one(RocketStrip)
        if flight is None:
            strip.show(None)
        else:
            facts = partial(rocket_facts, self.resources, flight)
            self.ask(facts, strip.show, "rocket")

    def _show_pane(self, key: object) -> None:
        """Show a flight beside the list, if there is room."""
        flights = self._view.flights if self._view is not None else ()
        one = next((one for one in flights if one.id == key), None)
        if not self.has_class("-broad") or not flights:
            for hidden in self.query("Pane"):
                hidden.display = False
            return
        from fieldkit.tui.home.pane import Pane  # before the first paint it would take 0.7 s

        pane = next(iter(self.query(Pane)), None)
        if pane is None:
            pane = Pane()
            self.run_worker(self._show_when(self.query_one("#split").mount(pane)), group="pane")
        if not pane.is_mounted:
            return
        pane.display = True
        pane.show(one, flights, self._beside, self.resources.settings.units)
        if one is not None and one.flight.has_log:
            self.ask(partial(self._read_climb, one.id), self._show_climb, "climb")

    async def _show_when(self, mounted: AwaitMount) -> None:
        """Show the flight under the cursor once the pane has its widgets."""
        await mounted
        self._moved()

    def _read_climb(self, id: str) -> "Drawn | None":
        from fieldkit.tui.flights.log_plot import Drawn, drawn

        found = or_why(lambda: drawn(self.resources.ledger, id, self.resources.settings.units))()
        return found if isinstance(found, Drawn) else None

    def _show_climb(self, log: "Drawn | None") -> None:
        from fieldkit.tui.home.pane import Pane

        for pane in self.query(Pane):
            pane.show_climb(log)

    @on(Table.Chosen)
    async def _chosen(self, message: Table.Chosen) -> None:
        if isinstance(message.key, Step):
            from fieldkit.tui.home.first_run import take  # before the first paint it would take 0.4 s

            await take(self, message.key)
        elif self._flight not in self.app.screen_stack:
            self._flight.turn_to(message.key)
            self.app.push_screen(self._flight)

    @cached_property
    def _flight(self) -> "FlightScreen":
        """The screen of a flight that is opened here; the Flights page has its own."""
        from fieldkit.tui.flights.flight_screen import FlightScreen  # before the first paint it would take 0.7 s

        screen = FlightScreen()
        self.app.install_screen(screen, "flight from home")
        return screen

    async def action_plan(self) -> None:
        """Change the plan: rocket, mass, weather."""
        await self.settled("change", "ask", "overview")
        from fieldkit.tui.next.plan_form import ask_plan, keep_plan  # before the first paint it would take 0.3 s

        await ask_plan(self, self._view.plan if self._view is not None else Flight(), partial(keep_plan, self))

    async def action_day_weather(self) -> None:
        """Type the weather of the day."""
        await self.settled("change", "ask", "overview")
        from fieldkit.tui.home.weather_form import ask_weather  # before the first paint it would take 0.3 s

        ask_weather(self, self._view.weather if self._view is not None else Flight())

    def action_pad(self) -> None:
        """Show the checklist at the pad."""
        from fieldkit.tui.pad.pad_screen import PadTimer, show_pad  # before the first paint it would take 0.3 s

        self._timer = self._timer or PadTimer()
        show_pad(self, self._timer)

    def copied(self) -> str:
        """The row under the cursor."""
        return self.query_one(Table).current_text()
