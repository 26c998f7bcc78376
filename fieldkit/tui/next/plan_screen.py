"""Decide: once the motor is chosen, its delay, the ballast, the points of a contest, and the forecasts kept."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from textual.binding import Binding, BindingType
from textual.containers import Container, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.safe_text import printable
from fieldkit.settings import Settings
from fieldkit.tui.add.fields import Form
from fieldkit.tui.help import Help
from fieldkit.tui.next import contest_form
from fieldkit.tui.next.answer import Answer
from fieldkit.tui.next.decisions import AIMS, Decision
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets.hanging import hanging
from fieldkit.tui.widgets.tabs import TabLine

if TYPE_CHECKING:
    from fieldkit.flight.site import Site
    from fieldkit.planning.contest_day import Day

VIEWS = ("Delay", "Ballast", "Contest", "Landing", "Saved", "Score")
SHARES = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0)
"""Of the parachute's area that may be chosen. [1]"""


class PlanScreen(PageScreen):
    """Six answers side by side in one place; left and right, or their names, go from one to the next."""

    NAME = "next_flight"
    TITLE = "Decide"
    ABOUT = Help(
        "What is left to decide once the motor is chosen, from the flights of this rocket, in the weather of "
        "the plan. Delay: when each delay on sale, or drilled with its maker's tool, would fire, and how fast the "
        "rocket then is. Ballast: the grams that best meet the target (g on the page Next). Contest: the points to "
        "expect by a season's rule. Landing: where it comes down against the field, and the best rail. Saved: the "
        "forecasts that were saved. Score: how good they are. Forecasts are "
        "advice: the range safety officer decides.",
        (
            ("delay", "Best is the one least likely to fire too fast for the parachute."),
            (
                "ballast",
                "The dry mass that makes landing within 10 ft of the target as likely as it can be; j changes that to "
                "the least mean miss, or the fewest points of the season.",
            ),
            (
                "contest",
                "Feet off the target and seconds outside the window, as many flights as may be declared. , and . "
                "change the season, [ and ] the area of the parachute.",
            ),
            (
                "the day",
                "p: target and window as announced, the cut and so the chance to qualify, the flights declared, the "
                "length of the rocket; and of the site the field's size and the ceiling, which safety lines ask for.",
            ),
            ("saved", "Stale: mass, motor, weather, design or model have changed since the forecast was made."),
            (
                "score",
                "Each flight forecast from those before it, beside simpler ways; where flights lay in their forecasts.",
            ),
        ),
        (
            "fieldkit delay --motor F24",
            "fieldkit ballast --target 800ft [--miss] [--season 2027]",
            "fieldkit contest --season 2027 --motor F24 --parachute 85% --target 785ft --window 37-40 --cut 60",
            "fieldkit contest --season 2027 --declared 4,5,6",
            "fieldkit sites FIELD --size 400m --ceiling 3000ft",
            "fieldkit predictions",
            "fieldkit score",
        ),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "back", "Back", priority=True),
        Binding("left", "turn(-1)", "Answer before", show=False, priority=True),
        Binding("right", "turn(1)", "Answers", key_display="←→", priority=True),
        Binding("p", "day", "Plan", tooltip="What is announced, the cut, flights declared, field and ceiling"),
        Binding("j", "aim", "Aim", tooltip="What ballast is for: the band, the mean miss, the points"),
        Binding("comma", "season(-1)", "Season before", key_display=",", show=False),
        Binding("full_stop", "season(1)", "Season", key_display=",.", tooltip="The season after, or before with ,"),
        Binding("left_square_bracket", "area(-1)", "Smaller parachute", key_display="[", show=False),
        Binding("right_square_bracket", "area(1)", "Chute", key_display="[]", tooltip="A larger parachute"),
    ]
    DEFAULT_CSS = """
    PlanScreen VerticalScroll { padding: 0 1; }
    PlanScreen #words { height: auto; layout: vertical; }
    PlanScreen #answer, PlanScreen #beside { height: auto; width: 1fr; }
    PlanScreen #beside { margin-top: 1; }
    PlanScreen #picture { height: auto; margin-top: 1; display: none; }
    PlanScreen #picture.-shown { display: block; }
    PlanScreen #picture Static { height: auto; }
    PlanScreen #title { text-style: bold; color: $primary; }
    PlanScreen #plots { height: auto; layout: vertical; }
    PlanScreen Plot { height: 10; width: 1fr; }
    PlanScreen.-tall Plot { height: 16; }
    PlanScreen.-wide #words, PlanScreen.-normal #plots, PlanScreen.-wide #plots { layout: horizontal; }
    PlanScreen.-wide.-tall Plot { height: 22; }
    PlanScreen.-wide #beside { margin: 0 0 0 2; }
    """

    def __init__(self, decision: Decision) -> None:
        super().__init__()
        self._decision = decision
        self._view, self._aim, self._season, self._share = 0, 0, 2027, SHARES.index(1.0)
        self._said = Answer(())

    def body(self) -> Iterable[Widget]:
        """The names of the answers, and the current one with its picture."""
        from fieldkit.tui.widgets.plots import Plot

        yield TabLine(VIEWS, "screen.view")
        with VerticalScroll():
            with Container(id="words"):
                yield Static("", id="answer")
                yield Static("", id="beside")
            with Container(id="picture"):
                yield Static("", id="title")
                yield Static("", id="intervals")
                with Container(id="plots"):
                    yield Plot(id="first")
                    yield Plot(id="second")

    def on_mount(self) -> None:
        """Keys scroll the answer."""
        self.query_one(VerticalScroll).focus()

    def reload(self) -> None:
        """Compute the current answer."""
        self.query_one(TabLine).front(self._view)
        self._say(Answer(("working it out ...",)))
        self.ask(partial(self._answer, self._view, self.resources.settings), self._say, "plan", alone=True)

    def _say(self, answer: Answer) -> None:
        self._said = answer
        for place, lines in (("#answer", answer.words), ("#beside", answer.beside)):
            self.query_one(place, Static).update(hanging(lines))
        self.query_one("#beside").display = bool(answer.beside)
        self._draw(answer)

    def _draw(self, answer: Answer) -> None:
        """What explains the answer, where there is something to draw."""
        from fieldkit.tui.widgets.plots import Plot

        self.query_one("#picture").set_class(bool(answer.title), "-shown")
        self.query_one("#title", Static).update(Content(answer.title))
        intervals = self.query_one("#intervals", Static)
        intervals.display = answer.intervals is not None
        intervals.update(answer.intervals or "")
        for name, draw in (("#first", answer.draw), ("#second", answer.second)):
            plot = self.query_one(name, Plot)
            plot.display = draw is not None
            plot.show(draw)

    def _answer(self, view: int, settings: Settings) -> Answer:
        from fieldkit.services.contest_day import day_of
        from fieldkit.services.sites import site_of

        ledger, plan = self.resources.ledger, self._decision.plan
        day = day_of(ledger, self._season)
        decision = replace(self._decision, site=site_of(ledger, plan.site), system=settings.units)
        if view == 0:
            return decision.delay()
        if view == 1:
            return decision.ballast(settings.target, AIMS[self._aim], self._season, day)
        if view == 2:
            return decision.contest(ledger, self._season, SHARES[self._share], day)
        if view == 3:
            return decision.landing()
        if view == 4:
            return decision.saved_forecasts(ledger, self.resources.motors)
        return decision.fared(ledger, self.resources.motors)

    def action_view(self, view: int) -> None:
        """Another answer."""
        self._view = view % len(VIEWS)
        self.reload()

    def action_turn(self, by: int) -> None:
        """The next answer, or the one before."""
        self.action_view(self._view + by)

    def action_aim(self) -> None:
        """Ballast for something else."""
        self._aim = (self._aim + (self._view == 1)) % len(AIMS)
        self.action_view(1)

    def action_season(self, by: int) -> None:
        """The season after, or before."""
        from fieldkit.paths import data_folder
        from fieldkit.planning.contest import seasons

        years = seasons(data_folder() / "seasons")
        self._season = years[(years.index(self._season) + by) % len(years)]
        self.action_view(self._view if self._view == 1 and AIMS[self._aim] == "points" else 2)

    def action_area(self, by: int) -> None:
        """A larger parachute, or a smaller one."""
        self._share = min(max(self._share + by, 0), len(SHARES) - 1)
        self.action_view(2)

    def action_day(self) -> None:
        """Type what was announced and declared, and how large the field is."""
        from fieldkit.services.contest_day import day_of
        from fieldkit.services.sites import site_of

        ledger, season, name = self.resources.ledger, self._season, self._decision.plan.site
        self.ask(lambda: (day_of(ledger, season), site_of(ledger, name)), partial(self._ask_day, season), "day")

    def _ask_day(self, season: int, known: "tuple[Day, Site]") -> None:
        from fieldkit.planning.contest_day import read_part

        (day, site), system = known, self.resources.settings.units
        title = f"The day of season {season}" + (f", at {site.name}" if site.name else "")
        texts, units = contest_form.texts(day, site, system), contest_form.units(system)
        form = Form(title, contest_form.questions(site), texts, units, read_part)
        self.app.push_screen(form, partial(self._have_day, season, known))

    def _have_day(self, season: int, known: "tuple[Day, Site]", values: dict[str, object] | None) -> None:
        if values is None:
            return
        day, site = contest_form.answered(values, known[1])
        self._view = 2 if day != known[0] and self._view == 0 else self._view

        def work() -> None:
            from fieldkit.services.contest_day import keep_day
            from fieldkit.services.sites import put_site

            keep_day(self.resources.ledger, season, day)
            if site != known[1]:
                put_site(self.resources.ledger, site)

        self.change(work, lambda _: self.field_app.changed())

    def copied(self) -> str:
        """The answer as text."""
        return "\n".join(map(printable, self._said.text.splitlines()))
