"""Decide: after the choice of a motor, its delay, the ballast, points of a contest, finals, and the saved forecasts.

The table of finals on the Decide screen: mass and parachute for each target that may be announced.
"""

from collections.abc import Iterable
from dataclasses import replace
from datetime import date
from functools import partial
from typing import Any, ClassVar

from textual.binding import Binding, BindingType
from textual.containers import Container, Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.flight.site import Site
from fieldkit.paths import data_file
from fieldkit.planning.contest import season_of, seasons
from fieldkit.planning.contest_day import Day
from fieldkit.presentation.finals_text import (
    ENDS_NOTE,
    FINALS_NOTES,
    finals_headers,
    finals_heading,
    finals_lines,
    finals_notes,
    finals_rows,
)
from fieldkit.safe_text import printable
from fieldkit.services.contest_day import day_of, keep_day
from fieldkit.services.forecasts import rocket_of
from fieldkit.services.launch_day import planned_mass
from fieldkit.services.sites import site_of
from fieldkit.settings import Settings
from fieldkit.tui.add.fields import Form
from fieldkit.tui.help import Help
from fieldkit.tui.next import contest_form
from fieldkit.tui.next.answer import Answer
from fieldkit.tui.next.decisions import AIMS, Decision, of_targets
from fieldkit.tui.next.next_words import UNFOLD_KEY, folded, unfolded
from fieldkit.tui.next.plan_pages import PAGES, ask_page, finals_of
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import answered, hanging
from fieldkit.tui.widgets.plots import Plot
from fieldkit.tui.widgets.tabs import TabLine


def finals_answer(decision: Decision, year: int, day: Day) -> Answer:
    """The table of a plan's motor for the finals of a season, in the window of the day if one was announced.

    Raises ImpossibleFlight for a plan without a mass or with too little thrust.
    """
    one, system = finals_of(decision, year, day), decision.system
    words = (
        *finals_heading(one, system),
        "",
        *finals_lines(finals_headers(one.flown.fall, system), finals_rows(one, system)),
        "w to write this table as a card",
        "",
        *FINALS_NOTES,
        *finals_notes(one),
    )
    answer = Answer(
        words,
        (ENDS_NOTE, "", *unfolded(one.lines, system)),
        folded=(ENDS_NOTE, "", *folded(one.lines, system)),
    )
    return of_targets(answer, one.table, system)


VIEWS = ("Delay", "Ballast", "Contest", "Landing", "Saved", "Score", "Season", "Finals")
"""Names of the answers."""
LANDING, SEASON, FINALS = (VIEWS.index(name) for name in ("Landing", "Season", "Finals"))
"""The index of the landing, of the steps of a season, and of the table of finals, among the answers. [1]"""
WRITES = ("w", "R", "w in Season and Finals")
"""The keys that write the pages of a plan, in the order of `PAGES`."""
AREA_RATIOS = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0)
"""Fractions of the parachute's area to choose from. [1]"""


class PlanScreen(PageScreen):
    """Eight answers in one place; left and right, or their names, switch between them."""

    NAME = "next_flight"
    TITLE = "Decide"
    ABOUT = Help(
        "What to decide once the motor is chosen, from the flights of this rocket and the weather of the plan. "
        "Forecasts are advice: the range safety officer decides.",
        (
            (
                "delay",
                "When each delay, as sold or drilled with its maker's tool, would fire, and the speed at that time. "
                "The best is the one least likely to deploy too fast for the parachute.",
            ),
            (
                "ballast",
                "The dry mass with the best chance of an apogee within 10 ft of the target (g); j for the "
                "smallest mean miss or the fewest points of the season.",
            ),
            (
                "contest",
                "Points for feet off the target and seconds outside the window, over as many flights as may be "
                "declared. Press , or . for another season, [ or ] for a smaller or larger parachute.",
            ),
            ("landing", "Where it lands relative to the field, and the best rail angle."),
            (
                "the day",
                "e to enter the announced target and window, the cut (for the chance of qualifying), the declared "
                "flights, the length of the rocket, and the field size and ceiling of the site for the safety checks.",
            ),
            (
                "season",
                "The American Rocketry Challenge (TARC) from kit to finals: limits, mass and parachute together "
                "with their uncertainty, the practice flight that narrows the finals most, qualification. e to enter "
                "the declared flights and the cut.",
            ),
            *(
                (what, f"{about}: {key} to write it.")
                for key, (what, about) in zip(WRITES, PAGES.values(), strict=True)
            ),
            (
                "finals",
                "Mass and parachute for each target that finals may announce.",
            ),
            (
                "saved",
                "Your saved forecasts. Stale: mass, motor, weather, design or model has changed since it was made.",
            ),
            (
                "score",
                "How far off forecasts of this rocket are, each from the earlier flights only, beside simpler methods. "
                "Nine flights in ten should be inside the 90% interval.",
            ),
        ),
        (
            "fieldkit delay --motor F24",
            "fieldkit ballast --target 800ft [--miss] [--season 2027]",
            "fieldkit contest --season 2027 --motor F24 --parachute 85% --target 785ft --window 37-40 --cut 60",
            "fieldkit contest --season 2027 --declared 4,5,6",
            "fieldkit sites FIELD --size 400m --ceiling 3000ft",
            "fieldkit season --season 2027 --motor F24 --declared 4,5 --cut 60",
            "fieldkit finals --motor F24 --season 2027 --card finals.pdf",
            "fieldkit landing --motor F24 --wind 4m/s --safety-sheet sheet.pdf --card range.pdf",
            "fieldkit predictions",
            "fieldkit score",
        ),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "back", "Back", priority=True, tooltip="Back to the motors"),
        Binding("left", "turn(-1)", "Previous view", show=False, priority=True),
        Binding("right", "turn(1)", "Views", key_display="←→", priority=True, tooltip="The next answer; ← previous"),
        Binding("g", "app.ask_target", "Target", tooltip="Set the target apogee"),
        Binding("e", "day", "Day", tooltip="Announced target and window, cut, declared flights, field and ceiling"),
        UNFOLD_KEY,
        Binding("j", "aim", "Aim", tooltip="Goal of the ballast: chance, mean miss or points"),
        Binding("comma", "season(-1)", "Previous season", key_display=",", show=False),
        Binding("full_stop", "season(1)", "Season", key_display=",.", tooltip="Next season; , previous"),
        Binding("left_square_bracket", "area(-1)", "Smaller parachute", key_display="[", show=False),
        Binding(
            "right_square_bracket",
            "area(1)",
            "Chute",
            key_display="[]",
            tooltip="Larger parachute; [ smaller",
        ),
        Binding("w", "report", "Report", show=False, tooltip="Write the range safety sheet; in finals, their card"),
        Binding("R", "write('card')", "Range card", show=False, tooltip="Write the range card, for flight check-in"),
    ]
    DEFAULT_CSS = """
    PlanScreen VerticalScroll { padding: 0 1; }
    PlanScreen #words { height: auto; layout: vertical; }
    PlanScreen #main, PlanScreen #answer, PlanScreen #under, PlanScreen #beside { height: auto; width: 1fr; }
    PlanScreen #below { height: auto; }
    PlanScreen #figure { height: 4; display: none; }
    PlanScreen #figure.-shown { display: block; }
    PlanScreen #about { width: 1fr; height: 3; padding: 0 0 0 2; }
    PlanScreen #under, PlanScreen #beside, PlanScreen.-wide #below { display: none; }
    PlanScreen #below, PlanScreen #under { margin-top: 1; }
    PlanScreen #picture { height: auto; margin-top: 1; display: none; }
    PlanScreen #picture Static { height: auto; }
    PlanScreen #title { text-style: bold; color: $primary; }
    PlanScreen #plots { height: auto; layout: vertical; }
    PlanScreen Plot { height: 10; width: 1fr; display: none; }
    PlanScreen Plot.-below { border-top: solid $border-blurred; border-title-color: $foreground; margin-top: 1; }
    PlanScreen Plot.-shown, PlanScreen.-tall Plot.-below, PlanScreen.-wide Plot.-below { display: block; }
    PlanScreen.-tall Plot { height: 44vh; min-height: 16; }
    PlanScreen.-wide #words { layout: horizontal; }
    PlanScreen.-normal #plots { layout: horizontal; }
    PlanScreen #words.-drawn #picture { display: block; }
    PlanScreen.-wide #words.-drawn #under, PlanScreen.-wide #words.-more #beside { display: block; }
    PlanScreen.-wide #words.-drawn #beside { display: none; }
    PlanScreen.-wide #main { width: 3fr; min-width: 78; }
    PlanScreen.-wide #beside { width: 2fr; margin: 0 0 0 2; }
    PlanScreen.-wide #words.-drawn #main { width: 1fr; min-width: 75; }
    PlanScreen.-wide #picture { width: 1fr; margin: 0 0 0 2; }
    PlanScreen.-wide #words.-one Plot { height: 70vh; }
    PlanScreen.-wide #words.-two Plot { height: 41vh; }
    """

    def __init__(self, decision: Decision, view: int = 0, write: str = "") -> None:
        """`write` is the name of a page to ask for at once."""
        super().__init__()
        self._decision, self._write = decision, write
        self._view, self._aim, self._area_ratio = view, 0, AREA_RATIOS.index(1.0)
        self._season = season_of(date.today(), data_file("seasons"))
        self._shown_answer = Answer(())
        self._unfolded = False

    def body(self) -> Iterable[Widget]:
        """The names of the answers, and the current one with its picture."""
        yield TabLine(VIEWS, "screen.view")
        with VerticalScroll():
            with Container(id="words"):
                with Vertical(id="main"):
                    with Horizontal(id="figure"):
                        yield Big()
                        yield Static("", id="about")
                    yield Static("", id="answer")
                    yield Static("", id="under")
                with Container(id="picture"):
                    yield Static("", id="title")
                    yield Static("", id="intervals")
                    with Container(id="plots"):
                        yield Plot(id="first")
                        yield Plot(id="second")
                yield Static("", id="beside")
            yield Static("", id="below")

    def on_mount(self) -> None:
        """Focus the answer, so that keys scroll it, and ask for the page to write."""
        self.query_one(VerticalScroll).focus()
        if self._write:
            self.action_write(self._write)

    def reload(self) -> None:
        """Compute the current answer."""
        self.query_one(TabLine).front(self._view)
        self._say(Answer(("computing ...",)))
        self.ask(partial(self._answer, self._view, self.resources.settings), self._say, "plan", alone="app")

    def _say(self, answer: Answer) -> None:
        self._shown_answer = answer
        self.query_one("#figure").set_class(bool(answer.large), "-shown")
        self.query_one(Big).show(answer.large)
        self.query_one("#about", Static).update(Content("\n".join(map(printable, answer.about))).stylize("bold"))
        self.query_one("#answer", Static).update(answered(answer.words))
        beside = answer.beside if self._unfolded else answer.folded or answer.beside
        for place in ("#under", "#beside", "#below"):  # one of them is shown, by the width and the picture
            self.query_one(place, Static).update(hanging(beside))
        words = self.query_one("#words")
        words.set_class(bool(beside), "-more")
        words.set_class(bool(answer.title), "-drawn")
        words.set_class(answer.second is None, "-one")
        words.set_class(answer.second is not None, "-two")
        self._draw(answer)

    def _draw(self, answer: Answer) -> None:
        """Draw the picture of the answer, if there is one."""
        self.query_one("#title", Static).update(Content(answer.title))
        intervals = self.query_one("#intervals", Static)
        intervals.display = answer.intervals is not None
        intervals.update(answer.intervals or "")
        for name, draw in (("#first", answer.draw), ("#second", answer.second)):
            plot = self.query_one(name, Plot)
            plot.set_class(draw is not None and not answer.below, "-shown")
            plot.set_class(draw is not None and bool(answer.below), "-below")
            plot.border_title = Content(printable(answer.below))
            plot.show(draw)

    def _answer(self, view: int, settings: Settings) -> Answer:
        ledger = self.resources.ledger
        decision, _, day = self._current(settings)
        if view == 0:
            return decision.noted(decision.delay())
        if view == 1:
            return decision.noted(decision.ballast(settings.target, AIMS[self._aim], self._season, day))
        if view == 2:
            return decision.noted(decision.contest(ledger, self._season, AREA_RATIOS[self._area_ratio], day))
        if view == LANDING:
            return decision.noted(decision.landing())
        if view == SEASON:
            return decision.noted(decision.season(ledger, self._season, day))
        if view == FINALS:
            return decision.noted(finals_answer(decision, self._season, day))
        if view == 4:
            return decision.saved_forecasts(ledger, self.resources.motors)
        return decision.fared(ledger, self.resources.motors)

    def _current(self, settings: Settings) -> tuple[Decision, int, Day]:
        """The decision with the rocket, site and mass as they are now, the season, and its day."""
        ledger, plan = self.resources.ledger, self._decision.plan
        rocket = rocket_of(ledger, self.resources.motors, plan.flight.rocket)  # another program may have added flights
        if (mass := planned_mass(ledger)) is not None:  # it may have been weighed here
            plan = plan.with_changes(dry_mass=mass)
        plan, site = replace(plan, rocket=rocket), site_of(ledger, plan.flight.site)
        decision = replace(self._decision, plan=plan, site=site, system=settings.units)
        return decision, self._season, day_of(ledger, self._season)

    def action_report(self) -> None:
        """Write the page that belongs to this answer."""
        self.action_write("finals" if self._view in (SEASON, FINALS) else "sheet")

    def action_write(self, kind: str) -> None:
        """Write a page of this decision: its range safety sheet, its range card, or its card of finals."""
        ask_page(self, kind, partial(self._current, self.resources.settings))

    def action_view(self, view: int) -> None:
        """Show another answer."""
        self._view = view % len(VIEWS)
        self.reload()

    def action_turn(self, by: int) -> None:
        """Show the next or previous answer."""
        self.action_view(self._view + by)

    def action_aim(self) -> None:
        """Change the goal of the ballast, or show the ballast if another answer is shown."""
        self._aim = (self._aim + (self._view == 1)) % len(AIMS)
        self.action_view(1)

    def action_unfold(self) -> None:
        """Show every safety check, or only those that fail."""
        self._unfolded = not self._unfolded
        self._say(self._shown_answer)

    def action_season(self, by: int) -> None:
        """Choose the next or previous season, and show the points by its rule unless the answer depends on a season."""
        years = seasons(data_file("seasons"))
        self._season = years[(years.index(self._season) + by) % len(years)]
        points = self._view in (SEASON, FINALS) or (self._view == 1 and AIMS[self._aim] == "points")
        self.action_view(self._view if points else 2)

    def action_area(self, by: int) -> None:
        """Choose a larger or smaller parachute."""
        self._area_ratio = min(max(self._area_ratio + by, 0), len(AREA_RATIOS) - 1)
        self.action_view(2)

    async def action_day(self) -> None:
        """Enter the announcements and declarations of the day, and the size of the field."""
        ledger, season, name = self.resources.ledger, self._season, self._decision.plan.flight.site
        self.ask(lambda: (day_of(ledger, season), site_of(ledger, name)), partial(self._ask_day, season), "day")
        await self.settled("day")

    def _ask_day(self, season: int, known: tuple[Day, Site]) -> None:
        (day, site), system = known, self.resources.settings.units
        title = f"The day of season {season}" + (f", at {site.name}" if site.name else "")
        texts, units = contest_form.texts(day, site, system), contest_form.units(system)
        read = partial(contest_form.read, self._decision.plan.found.motor, system)
        form = Form(title, contest_form.questions(site), texts, units, read)
        self.ask_form(form, partial(self._have_day, season, known))

    def _have_day(self, season: int, known: tuple[Day, Site], values: dict[str, Any]) -> None:
        day, site = contest_form.answered(values, *known, self.resources.settings.units)
        self._view = 2 if day != known[0] and self._view == 0 else self._view
        weighed = values[contest_form.WEIGHED_QUESTION.name]
        changed = day if day != known[0] else None, site if site != known[1] else None
        work = partial(keep_day, self.resources.ledger, season, *changed, weighed)
        self.change(work, lambda new: self.show_change("Saved the day. u to undo" if new else "Nothing has changed"))

    def copied(self) -> str:
        """The answer as text."""
        return "\n".join(map(printable, self._shown_answer.text.splitlines()))
