"""The forecast of one motor: the apogee in large digits, its safety checks, its density, and all figures below."""

from functools import partial

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.content import Content
from textual.widgets import Static

from fieldkit.forecast.prediction import Prediction
from fieldkit.planning.motor_guide import MotorChoice, label
from fieldkit.planning.quick_guide import QuickChoice
from fieldkit.safe_text import printable
from fieldkit.settings import Settings
from fieldkit.tui.next import motor_rows, next_words
from fieldkit.tui.next.next_plan import Plan
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import hanging
from fieldkit.tui.widgets.plots import Marked, Plot, draw_density


class ForecastCard(VerticalScroll):
    """The card next to the motors; `text` is its content, for copying."""

    DEFAULT_CSS = """
    ForecastCard Static { height: auto; }
    ForecastCard #big { height: 3; width: 1fr; }
    ForecastCard #hill { height: 6; }
    """
    text = ""
    unfolded = False
    """Whether every safety check is shown in full."""

    def compose(self) -> ComposeResult:
        """From the largest to the smallest."""
        yield Static("", id="title")
        yield Big(id="big")
        yield Static("", id="range")
        yield Static("", id="safety")
        yield Plot(id="hill")
        yield Static("", id="more")

    def show(self, plan: Plan, one: MotorChoice, settings: Settings, *, exact: bool) -> None:
        """Show the forecast of a plan on a motor; marked as provisional unless it is `exact`, as it would be saved."""
        system = settings.units
        title, text = next_words.title(plan, one.name), next_words.interval(one.interval, system)
        middle = motor_rows.middle(one, system, exact=exact)
        more, checks = next_words.figures(plan, one, system), next_words.checks(one, system)
        self.query_one("#title", Static).update(Content(printable(title)).stylize("bold"))
        self.query_one(Big).show(middle)
        self.query_one("#range", Static).update(Content(text).stylize("bold"))
        brief = hanging([*next_words.safety_in_brief(one.lines), next_words.UNFOLD])
        self.query_one("#safety", Static).update(cards.lines("", checks, 1) if self.unfolded else brief)
        self.query_one("#more", Static).update(cards.lines("", more, 9))
        self._show_hill(one.prediction, settings)
        self.text = cards.as_text(f"{title}: {middle} {text}", [*more, *checks])

    def show_quick(self, plan: Plan, one: QuickChoice, settings: Settings) -> None:
        """Show the quick answer for a motor, until the fit replaces it."""
        system = settings.units
        title, text = next_words.title(plan, label(one.motor)), next_words.interval(one.interval, system)
        middle, more = motor_rows.middle(one, system, exact=False), next_words.quick_figures(plan, one, system)
        self.query_one("#title", Static).update(Content(printable(title)).stylize("bold"))
        self.query_one(Big).show(middle)
        self.query_one("#range", Static).update(Content(text).stylize("bold"))
        self.query_one("#safety", Static).update(f"{motor_rows.PROVISIONAL} {next_words.QUICK}")
        self.query_one("#more", Static).update(cards.lines("", more, 9))
        self.query_one(Plot).show(None)
        self.text = cards.as_text(f"{title}: {middle} {text}", [("", next_words.QUICK), *more])

    def clear(self) -> None:
        """Clear the card: no motor, or no forecast yet."""
        for name in ("title", "range", "safety", "more"):
            self.query_one(f"#{name}", Static).update("")
        self.query_one(Big).show("")
        self.query_one(Plot).show(None)
        self.text = ""

    def _show_hill(self, prediction: Prediction, settings: Settings) -> None:
        """Show the distribution of the apogee, with its interval and the target."""
        marks = [Marked("◎", settings.target)] if settings.target else []
        spell = partial(motor_rows.whole, system=settings.units)
        self.query_one(Plot).show(draw_density(prediction.apogee, spell, *marks))
