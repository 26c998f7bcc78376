"""What is decided for one motor: the delay to buy or drill, the ballast for the target, the points of a contest."""

from collections.abc import Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.flight import Flight
from fieldkit.safe_text import printable
from fieldkit.settings import Settings
from fieldkit.tui.page import Help, PageScreen

if TYPE_CHECKING:
    from fieldkit.ledger.sites import Site
    from fieldkit.loop.predict import Prediction
    from fieldkit.motors import Motor
    from fieldkit.plan.desk import Rocket
    from fieldkit.plan.limits import Limit
    from fieldkit.plan.safety import Line

VIEWS = ("Delay", "Ballast", "Contest")
WITHIN = 10 * 0.3048
"""The band about a target, as the command has it without being told. [m]"""


class PlanScreen(PageScreen):
    """Three answers side by side in one place; left and right, or their names, go from one to the next."""

    NAME = "next_flight"
    TITLE = "Decide"
    ABOUT = Help(
        "What is left to decide once the motor is chosen, from what this rocket's flights taught, in the weather of "
        "the plan. Delay: when each delay on sale, or drilled with its maker's tool, would fire, and how fast the "
        "rocket then is. Ballast: the grams that best meet the target (g on the page Next). Contest: the points to "
        "expect by a season's rule; , and . change the season. Forecasts are advice: the range safety officer decides.",
        (
            ("delay", "Best is the one least likely to fire too fast for the parachute."),
            ("ballast", "The dry mass that makes landing within 10 ft of the target as likely as it can be."),
            ("contest", "Feet off the target and seconds outside the window, as many flights as may be declared."),
        ),
        ("fieldkit delay --motor F24", "fieldkit ballast --target 800ft", "fieldkit contest --season 2027 --motor F24"),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "back", "Back"),
        Binding("left", "turn(-1)", "Answer before", show=False, priority=True),
        Binding("right", "turn(1)", "Answers", key_display="←→", priority=True),
        Binding("comma", "season(-1)", "Season before", key_display=",", show=False),
        Binding("full_stop", "season(1)", "Season", key_display=",.", tooltip="The season after, or before with ,"),
    ]
    DEFAULT_CSS = """
    PlanScreen #kinds { height: 1; padding: 0 1; background: $panel; link-style: none; link-color: $foreground;
        link-background: $panel; }
    PlanScreen VerticalScroll { padding: 0 1; }
    PlanScreen #answer { height: auto; }
    """

    def __init__(
        self, plan: Flight, rocket: "Rocket", site: "Site", limits: "dict[str, Limit]", motor: "Motor"
    ) -> None:
        super().__init__()
        self._plan, self._rocket, self._site, self._limits, self._motor = plan, rocket, site, limits, motor
        self._view, self._season, self._text = 0, 2027, ""

    def body(self) -> Iterable[Widget]:
        """The names of the answers, and the one in hand."""
        yield Static("", id="kinds")
        with VerticalScroll():
            yield Static("", id="answer")

    def on_mount(self) -> None:
        """Keys scroll the answer."""
        self.query_one(VerticalScroll).focus()

    def reload(self) -> None:
        """Work out the answer in hand."""
        names = [f"[@click=screen.view({at})] {'▸' if at == self._view else ' '}{VIEWS[at]} [/]" for at in range(3)]
        self.query_one("#kinds", Static).update("".join(names))
        self._say("working it out ...")
        self.ask(partial(self._answer, self._view, self.desk.settings), self._say, "plan")

    def _say(self, text: str) -> None:
        self._text = text
        self.query_one("#answer", Static).update(Content(text))

    def _answer(self, view: int, settings: Settings) -> str:
        words = (self._delay, self._ballast, self._contest)[view]
        return "\n".join(printable(line) for line in words(settings))

    def _delay(self, _settings: Settings) -> Iterator[str]:
        from fieldkit.motors import Found
        from fieldkit.places import data_folder
        from fieldkit.plan.delay import delays, drill_of
        from fieldkit.plan.words import delays_in_words

        fast = self._limits["eject_speed"].value
        tool = drill_of(self._motor, data_folder() / "drills.toml")
        takes_off = tool.takes_off if tool else ()
        judged = delays(self._rocket, self._plan, Found(self._motor, None), fast, takes_off)
        yield from delays_in_words(judged, fast, tool)
        yield from self._safety(judged.forecast)

    def _ballast(self, settings: Settings) -> Iterator[str]:
        from fieldkit.motors import Found
        from fieldkit.plan.ballast import Goal, ballast
        from fieldkit.plan.words import ballast_in_words

        if settings.target is None:
            yield "No target yet: g on the page Next sets one."
            return
        goal = Goal(settings.target, WITHIN)
        best = ballast(self._rocket, self._plan, Found(self._motor, None), goal)
        yield from ballast_in_words(best, goal)
        yield from self._safety(best.forecast)

    def _contest(self, _settings: Settings) -> Iterator[str]:
        from fieldkit.motors import Found
        from fieldkit.places import data_folder
        from fieldkit.plan.contest import allowed, outlook, season
        from fieldkit.plan.words import outlook_in_words

        rule = season(self._season, data_folder() / "seasons")
        ahead = outlook(rule, self._rocket, self._plan, Found(self._motor, None))
        yield from outlook_in_words(ahead, rule, 1.0)
        said = ahead.forecast
        yield from self._safety(said, allowed(rule, said.plan, said.found))

    def _safety(self, said: "Prediction", more: "Iterable[Line]" = ()) -> Iterator[str]:
        from fieldkit.plan.descent import fall_of
        from fieldkit.plan.safety import safety_lines, told
        from fieldkit.plan.words import conditions_in_words

        yield from conditions_in_words(said.plan, self._rocket.starts)
        yield ""
        yield from told([*safety_lines(said, self._site, fall_of(self._rocket.history), self._limits), *more])

    def action_view(self, view: int) -> None:
        """Another answer."""
        self._view = view % len(VIEWS)
        self.reload()

    def action_turn(self, by: int) -> None:
        """The next answer, or the one before."""
        self.action_view(self._view + by)

    def action_season(self, by: int) -> None:
        """The season after, or before."""
        from fieldkit.places import data_folder
        from fieldkit.plan.contest import seasons

        years = seasons(data_folder() / "seasons")
        self._season = years[(years.index(self._season) + by) % len(years)]
        self.action_view(2)

    def copied(self) -> str:
        """The answer as text."""
        return self._text
