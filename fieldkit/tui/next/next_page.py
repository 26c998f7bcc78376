"""Next flight: every motor that fits with its apogee, and the forecast of the one under the cursor.

The forecast of one motor: the apogee in large digits, its safety checks, its density, and all figures below.

The help of the Fly page: what its columns, figures and signs mean.
"""

import asyncio
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.content import Content
from textual.timer import Timer
from textual.widget import Widget
from textual.widgets import Input, Static

from fieldkit.flight import Flight
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Found, Motor
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.motor_guide import MotorChoice, guide, label
from fieldkit.planning.quick_guide import QUICK_ERROR, QuickChoice, quick_guide
from fieldkit.quantities import shown_unit
from fieldkit.safe_text import printable
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.range_box import box_left, motors_in_box
from fieldkit.settings import Settings
from fieldkit.tui.asking import WAIT, or_why
from fieldkit.tui.help import NO_FLIGHTS, Help
from fieldkit.tui.next import motor_facts, motor_rows, next_words
from fieldkit.tui.next.decisions import Decision
from fieldkit.tui.next.motor_list import MotorList
from fieldkit.tui.next.motor_rows import listed
from fieldkit.tui.next.next_plan import MASS_UNKNOWN, QUESTIONS, NextPlan, PlanWithoutMass, next_build, read_plan
from fieldkit.tui.next.next_words import saved_in_words
from fieldkit.tui.next.plan_form import ask_plan, keep_plan
from fieldkit.tui.next.plan_screen import PlanScreen
from fieldkit.tui.page import LEAVE_LINE, PageScreen
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import hanging
from fieldkit.tui.widgets.line import Line
from fieldkit.tui.widgets.plots import Marked, Plot, draw_density
from fieldkit.tui.widgets.table import Table

NEXT_HELP = Help(
    "Every motor on sale that fits the rocket, with its forecast apogee. Enter saves the forecast of the one under the "
    "cursor; when you add the flight, the two are compared. Forecasts are advice: the range safety officer decides.",
    (
        ("fits", "No wider than the widest motor that the rocket has flown, and strong enough to lift it."),
        (
            "/ * B",
            "A name, a maker or a size such as 24mm, in the whole catalog; all of it; only the motors in your range "
            "box (Ctrl+P, Your card). Each with its count.",
        ),
        (
            "order",
            "With a target (g), the nearest first; without one, those flown, then those nearest to the last apogee.",
        ),
        ("apogee", "The apogee that your altimeter will show: the median of the forecast."),
        ("◆ ! ✗", "Before a motor: flown before, weak for this weight, not possible."),
        (
            "≈ apogee",
            "Not final: a provisional answer, off by up to 10% either way (more if flights disagree), then a fit with "
            "few simulations, off by up to 3% (in wind 7%). The selected one is forecast in full.",
        ),
        ("off", "Forecast minus target, if you set one (g); the nearest motor comes first."),
        ("eject", "Seconds from apogee to ejection, for the delay that the motor has; negative is before it."),
        (
            "by delay",
            "The same for each delay on sale, and for that of the plan: 5:-0.6 is 0.6 s before apogee with 5 s.",
        ),
        ("├─●─┤", "With c: the 90% interval, all motors on one scale; ◎ is the target."),
        ("mm, N s", "Diameter and total impulse of the motor; c shows more columns."),
        (
            "delay",
            "That of the plan (p), or of the open forecast, if the motor is sold or drilled with it, else the one "
            "on sale nearest to apogee.",
        ),
        (
            "✗ a motor",
            "Does not fit: too wide, too weak, slow off the rail, without a suitable delay, too high for the ceiling, "
            "or no longer made; its card says why.",
        ),
        ("90%", "Nine flights in ten should fall between these two."),
        (
            "hill",
            "The density of the forecast apogee: the higher, the likelier. The vertical lines are 5%, median and 95%.",
        ),
        (
            "true",
            "The true height above the pad. A barometric altimeter reads low on a hot day and high on a cold one.",
        ),
        ("ejection", "When the charge fires for each delay on sale, in seconds after apogee; negative is before it."),
        ("✓ ! ⊘ ?", "Safety checks: ok, caution, unsafe, unknown; each with its value and limit further down."),
        (
            "checks",
            "Rail exit speed, thrust to weight, ground wind, launch angle, ceiling, field size, ejection speed, motor "
            "temperature, distances to people and bystanders, mass, certification, legal class, whether the rocket is "
            "complex, misfire, and the sky.",
        ),
        ("off rail", "Speed at the end of the rail. If it is too low, the fins do not keep the rocket straight."),
        ("rail", "The same for every motor, with c."),
        ("top speed", "Top speed, at about burnout."),
        ("T:W", "Thrust over weight, in the first half second and on average: above 5 is good, below 3 is unsafe."),
        (
            "next Cd, thrust",
            "Drag of the rocket and thrust factor (alpha) of the motor in the forecast, with standard deviations.",
        ),
        (
            "air",
            "Air density at the pad, from the plan's weather; assumed values are named. "
            "If it is 18 °F (10 °C) warmer, the altimeter shows 2 to 3% less.",
        ),
        ("based on", "The flights and the model version behind the forecast."),
        (
            "narrows",
            "How much more flights like this would narrow the 90% interval; the rest is flight-to-flight variation.",
        ),
        *((question.title, question.help) for question in QUESTIONS),
    ),
    ("fieldkit predict --motor F24-4W --config A --wind 8mph", "fieldkit motors --fit ROCKET --target 800ft"),
)


class ForecastCard(VerticalScroll):
    """The card next to the motors; `text` is its content, for copying."""

    BORDER_TITLE, BORDER_SUBTITLE = "Forecast", "Enter to save it, d to decide"

    DEFAULT_CSS = """
    ForecastCard Static { height: auto; }
    ForecastCard #big { height: 3; width: 1fr; }
    ForecastCard #hill { height: 6; }
    ForecastCard #thrust { height: 1fr; min-height: 8; max-height: 24; margin-top: 1; display: none;
        border-top: solid $border-blurred; border-title-color: $foreground; }
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
        yield Plot(id="thrust")

    def on_mount(self) -> None:
        """Set the title of the thrust curve."""
        self.query_one("#thrust", Plot).border_title = Content(motor_facts.THRUST)

    def show(self, plan: NextPlan, one: MotorChoice, settings: Settings, *, exact: bool) -> None:
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
        self._show_thrust(one.motor)
        self.text = cards.as_text(f"{title}: {middle} {text}", [*more, *checks])

    def show_quick(self, plan: NextPlan, one: QuickChoice, settings: Settings) -> None:
        """Show the quick answer for a motor, until the fit replaces it."""
        system = settings.units
        title, text = next_words.title(plan, label(one.motor)), next_words.interval(one.interval, system)
        middle, more = motor_rows.middle(one, system, exact=False), next_words.quick_figures(plan, one, system)
        self.query_one("#title", Static).update(Content(printable(title)).stylize("bold"))
        self.query_one(Big).show(middle)
        self.query_one("#range", Static).update(Content(text).stylize("bold"))
        self.query_one("#safety", Static).update(f"{motor_rows.PROVISIONAL} {QUICK_ERROR}")
        self.query_one("#more", Static).update(cards.lines("", more, 9))
        self.query_one("#hill", Plot).show(None)
        self._show_thrust(one.motor)
        self.text = cards.as_text(f"{title}: {middle} {text}", [("", QUICK_ERROR), *more])

    def clear(self) -> None:
        """Clear the card: no motor, or no forecast yet."""
        for name in ("title", "range", "safety", "more"):
            self.query_one(f"#{name}", Static).update("")
        self.query_one(Big).show("")
        self.query_one("#hill", Plot).show(None)
        self._show_thrust(None)
        self.text = ""

    def _show_thrust(self, motor: Motor | None) -> None:
        """Show the thrust curve of a motor, which has room on a large screen."""
        plot = self.query_one("#thrust", Plot)
        plot.set_class(motor is not None, "-shown")
        plot.show(partial(motor_facts.draw_thrust, motor) if motor is not None else None)

    def _show_hill(self, prediction: Prediction, settings: Settings) -> None:
        """Show the distribution of the apogee, with its interval and the target."""
        marks = [Marked("◎", settings.target)] if settings.target else []
        spell = partial(motor_rows.whole, system=settings.units)
        unit = shown_unit(cards.APOGEE, settings.units)
        self.query_one("#hill", Plot).show(draw_density(prediction.apogee, spell, *marks, unit=unit))


WIDE_SCREEN = 150
"""Minimum width with room for every figure and the card. [cell]"""
REST = 0.15
"""Time that the cursor has to rest on a motor before its forecast is computed with all draws. [s]"""
DRAWS = 400
"""Number of simulations for each motor in the list, from which densities are drawn. [1]"""


class NextScreen(PageScreen):
    """On the left the motors, on the right the forecast of the one under the cursor."""

    NAME = "next_flight"
    ON_ENTER = ("Save", "Save the forecast of this motor")
    TITLE = "Fly"
    ROW_REQUESTS = ("plan", "find")
    ABOUT = NEXT_HELP
    BINDINGS: ClassVar[list[BindingType]] = [
        LEAVE_LINE,
        Binding("slash", "find", "Find", key_display="/", tooltip="Find motors in the whole catalog"),
        Binding("p", "plan", "Plan", tooltip="Enter rocket, mass and conditions"),
        Binding("b", "build", "Rocket", tooltip="The next rocket and configuration"),
        Binding("g", "app.ask_target", "Target", tooltip="Set the target apogee"),
        Binding("d", "decide", "Decide", tooltip="Delay, ballast, contest, landing and more with this motor"),
        replace(next_words.UNFOLD_KEY, show=False),
        Binding("c", "compare", "Compare", tooltip="All columns for all motors"),
        Binding(
            "B",
            "toggle_box",
            "Box",
            show=False,
            tooltip="Only motors in your range box, or all",
        ),
        Binding("asterisk", "toggle_fit", "All", key_display="*", show=False, tooltip="Every motor, or those that fit"),
    ]
    DEFAULT_CSS = """
    NextScreen #plan { height: auto; padding: 0 1; background: $panel; }
    NextScreen #search { height: 1; }
    NextScreen #search Static { width: auto; padding: 0 1; }
    NextScreen #search Input, NextScreen #search Input:focus { width: 1fr; height: 1; border: none; padding: 0; }
    NextScreen #motors { width: 5fr; }
    NextScreen #card { width: 38; padding: 0 1; border-left: solid $border-blurred; }
    NextScreen.-wide #card { width: 40%; min-width: 60; border: round $border-blurred;
        border-title-color: $foreground; border-subtitle-color: $foreground; }
    NextScreen.-narrow #split { layout: vertical; }
    NextScreen.-narrow #motors { height: 7; width: 1fr; }
    NextScreen.-narrow #card { width: 1fr; height: 1fr; border-left: none; border-top: solid $border-blurred; }
    NextScreen.-narrow.-comparing #motors { height: 1fr; }
    NextScreen.-comparing #card, NextScreen.-blank #card { display: none; }
    NextScreen.-tall #hill { height: 11; }
    NextScreen.-tall.-wide #thrust.-shown { display: block; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._motors = MotorList()
        self._plan: NextPlan | PlanWithoutMass | None = None
        self._rest: Timer | None = None

    def body(self) -> Iterable[Widget]:
        """The plan in a line, a search, the motors, the forecast."""
        yield Static("p to plan a flight: rocket, mass, conditions", id="plan")
        with Horizontal(id="search"):
            yield Static("/")
            yield Line(placeholder="motor: F24, aerotech 24mm, a case ...", compact=True)
            yield Static("", id="count")
        with Horizontal(id="split"):
            yield Table(id="motors", enter=self.ON_ENTER[0])
            yield ForecastCard(id="card", classes="framed")

    @property
    def card(self) -> ForecastCard:
        """The forecast of the motor under the cursor."""
        return self.query_one(ForecastCard)

    def on_mount(self) -> None:
        """Focus the motors."""
        self.set_focus(self.query_one(Table))

    def reload(self) -> None:
        """Read the plan, and forecast every motor again; a flight may have taken motors from the range box."""
        if self._motors.box is not None:
            self.ask(self._read_box, self._have_box, "box")
        self.ask(partial(read_plan, self.resources), self._have_plan, "plan")

    def redraw(self) -> None:
        """Sort and show the forecasts again: other units or another target do not change them."""
        if self._motors.plan is None:
            self.reload()
            return
        self._show_plan(self._motors.plan)
        self._refill()

    def _have_plan(self, plan: NextPlan | PlanWithoutMass | None) -> None:
        self._plan = plan
        self._motors.turn_to(plan if isinstance(plan, NextPlan) else None)
        self.set_class(not isinstance(plan, NextPlan), "-blank")
        if not isinstance(plan, NextPlan):
            line = "No plan yet. p to enter one" if plan is None else plan.why
            self.query_one("#plan", Static).update(Content(line))
            self.query_one(Table).empty = NO_FLIGHTS if plan is None else MASS_UNKNOWN
            self.query_one(Table).show((), (), lambda _: ())
            return
        self.query_one(Table).empty = "no motor fits; * shows them all"
        self._show_plan(plan)
        self._search_now()

    def _show_plan(self, plan: NextPlan) -> None:
        self.query_one("#plan", Static).update(Content(plan.line(self.resources.settings)))

    @on(Input.Changed)
    def _search_again(self) -> None:
        """Start a new search at its first motor."""
        self.query_one(Table).by_hand = False
        self._search_now()

    def _search_now(self) -> None:
        """Look up the motors and compute missing forecasts."""
        text = self.query_one(Input).value
        self.ask(lambda: self._motors.find(self.resources.motors, text), self._found, "find")

    def _found(self, motors: list[Motor]) -> None:
        self._motors.found = motors
        self._refill()
        self._forecast_quickly()

    def _forecast_quickly(self) -> None:
        """Show quick forecasts of all motors without one; the fit's replace them, and report any error."""
        plan, waiting = self._motors.plan, self._motors.unanswered(self.query_one(Table).current)
        if plan is None or not waiting:
            self._forecast()
            return
        work = or_why(partial(quick_guide, plan.rocket, plan.full, waiting))
        self.ask(work, partial(self._have_quick, plan), "quick", alone="group")

    def _have_quick(self, plan: NextPlan, found: list[QuickChoice] | str) -> None:
        if found and not isinstance(found, str):
            self._motors.put_quick(plan, found)
            self._refill()
        self._forecast()

    def _forecast(self) -> None:
        """Fit the next few motors without a fit."""
        plan, waiting = self._motors.plan, self._motors.waiting(self.query_one(Table).current)
        if plan is None or not waiting:
            return

        def work() -> list[MotorChoice]:
            return guide(plan.rocket, plan.full, waiting, plan.limits, plan.site, DRAWS, plan.saved)

        self.ask(work, partial(self._have, plan), "forecast", alone="app")

    def _have(self, plan: NextPlan, found: Sequence[MotorChoice]) -> None:
        self._motors.put(plan, found)
        self._refill()
        self._forecast()

    def _refill(self) -> None:
        """List the motors in order, those without a forecast last."""
        settings, table = self.resources.settings, self.query_one(Table)
        brief = not self.has_class("-comparing") and self.size.width < WIDE_SCREEN
        heads, cells = listed(self._motors, settings, table.size.width, brief=brief)
        table.show(heads, self._motors.ordered(settings.target), cells)
        self.query_one("#count", Static).update(Content(self._motors.counted(settings.units)))
        self.soon(self._show_card)

    @on(Table.Moved)
    def _moved(self) -> None:
        """Show the cursor first, then the card beside it."""
        self.soon(self._show_card)

    def _show_card(self) -> None:
        """Show the available forecast of the motor under the cursor."""
        if self._rest is not None:
            self._rest.stop()
        one, plan, card = self._motors.shown(self.query_one(Table).current), self._motors.plan, self.card
        if one is None or plan is None:
            card.clear()
        elif isinstance(one, QuickChoice):
            card.show_quick(plan, one, self.resources.settings)
        else:
            card.show(plan, one, self.resources.settings, exact=one.motor in self._motors.exact)
            if one.motor not in self._motors.exact:
                self._rest = self.set_timer(REST, partial(self._forecast_exactly, one))
            return
        if not self.is_asking("quick", "forecast"):
            self._forecast_quickly()

    def _forecast_exactly(self, one: MotorChoice) -> None:
        """Compute the full forecast of the motor under the cursor, as it would be saved; the list uses fewer draws."""

        def work() -> list[Prediction]:
            return predict_plans(self.resources.ledger, self.resources.motors, [one.plan], save="nothing")

        self.ask(work, partial(self._have_exact, one), "exact", alone="app")

    def _have_exact(self, one: MotorChoice, made: list[Prediction]) -> None:
        """Show it unless the plan has changed."""
        if self._motors.known.get(one.motor) is one:
            self._motors.put_exact(one.motor, made[0])
            self._refill()

    def action_find(self) -> None:
        """Type a motor's name."""
        self.set_focus(self.query_one(Input))

    def action_toggle_fit(self) -> None:
        """Show only motors that fit, or all."""
        self._motors.fitting = not self._motors.fitting
        self._search_again()

    def action_toggle_box(self) -> None:
        """Show only the motors in the range box, or all."""
        if self._motors.box is None:
            self.ask(self._read_box, self._have_box, "box")
            return
        self._motors.box = None
        self._search_again()

    def _read_box(self) -> Mapping[Motor, int]:
        resources = self.resources
        return motors_in_box(
            box_left(resources.settings.flyer.box, resources.ledger, resources.motors), resources.motors
        )

    def _have_box(self, box: Mapping[Motor, int]) -> None:
        """List the motors in the range box, or all if none is left."""
        self._motors.box = box or None
        if not box:
            self.complain("Your range box is empty. Ctrl+P, then Your card, to enter its motors")
        self._search_again()

    def action_unfold(self) -> None:
        """Show every safety check of the current motor, or fold them."""
        self.card.unfolded = not self.card.unfolded
        self._show_card()

    def action_compare(self) -> None:
        """Show all figures instead of the card, or the card again."""
        self.toggle_class("-comparing")
        self._refill()

    @on(Table.Sized)
    def _resized(self) -> None:
        """Show the list again: a wide screen has room for everything."""
        if self._motors.plan is not None:
            self._refill()

    async def action_build(self) -> None:
        """Turn to the next rocket and configuration that have flown."""
        await self.settled("change", "plan")
        build = next_build(self._plan) if self._plan is not None else None
        if build is not None:
            self._keep_plan(build)

    async def action_decide(self, view: int = 0, write: str = "") -> None:
        """Open the decisions for the motor under the cursor, and ask for the page to `write` if one is named."""
        await self.settled("change", "plan")
        plan, motor = self._motors.plan, self.query_one(Table).current
        if plan is not None and motor is not None:
            one = self._motors.known.get(motor)
            full = plan.full.with_changes(motor=label(motor), delay=one.delay if one else None)
            decision = Decision(Plan(plan.rocket, full, Found(motor, None)), plan.site, plan.limits)
            self.app.push_screen(PlanScreen(decision, view, write))

    async def action_plan(self) -> None:
        """Change the plan."""
        await self.settled("change", "plan")
        await ask_plan(self, self._plan.flight if self._plan is not None else Flight(), self._keep_plan)

    def _keep_plan(self, plan: Flight) -> None:
        keep_plan(self, plan)

    @on(Table.Chosen)
    async def _keep_forecast(self, message: Table.Chosen) -> None:
        """Save the full forecast of the chosen motor, unless the plan it was shown for is being replaced."""
        motor, shown = message.key, self._motors.plan
        await self.settled("change", "plan")
        while self._motors.plan is shown and motor not in self._motors.known and self.is_asking("quick", "forecast"):
            await asyncio.sleep(WAIT)
        one = self._motors.known.get(motor)
        if one is None or self._motors.plan is not shown:
            if self._motors.plan is not None:
                self.show_notice("Nothing saved: the plan has changed; Enter again saves the new forecast")
            return

        def work() -> list[Prediction]:
            return predict_plans(self.resources.ledger, self.resources.motors, [one.plan], save="plan")

        self.change(work, partial(self._kept, motor))

    def _kept(self, motor: Motor, made: list[Prediction]) -> None:
        """Show a notice and the saved figures."""
        self.show_notice(saved_in_words(made[0], self.resources.settings.units))
        self.changed_for_others()
        self._motors.put_exact(motor, made[0])
        self._refill()

    def copied(self) -> str:
        """The forecast as text, or the row under the cursor if all are compared."""
        if self.has_class("-comparing"):
            return self.query_one(Table).current_text()
        self._show_card()
        return self.card.text
