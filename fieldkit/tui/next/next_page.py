"""Next flight: every motor that fits with its apogee, and the forecast of the one under the cursor."""

import asyncio
from collections.abc import Iterable, Sequence
from functools import partial
from typing import ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.content import Content
from textual.timer import Timer
from textual.widget import Widget
from textual.widgets import Input, Static

from fieldkit.flight import Flight
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Motor
from fieldkit.planning.motor_guide import MotorChoice, guide, label
from fieldkit.planning.quick_guide import QuickChoice, quick_guide
from fieldkit.services.forecasts import predict_plans
from fieldkit.tui.asking import WAIT, or_why
from fieldkit.tui.help import NO_FLIGHTS
from fieldkit.tui.next.decisions import Decision
from fieldkit.tui.next.forecast_card import ForecastCard
from fieldkit.tui.next.motor_list import MotorList
from fieldkit.tui.next.motor_rows import listed
from fieldkit.tui.next.next_help import NEXT_HELP
from fieldkit.tui.next.next_plan import MASS_UNKNOWN, Plan, PlanWithoutMass, next_build, read_plan
from fieldkit.tui.next.next_words import saved_in_words
from fieldkit.tui.next.plan_form import ask_plan, keep_plan
from fieldkit.tui.next.plan_screen import PlanScreen
from fieldkit.tui.page import LEAVE_LINE, PageScreen
from fieldkit.tui.widgets.line import Line
from fieldkit.tui.widgets.table import Table

WIDE_SCREEN = 150
"""Minimum width with room for every figure and the card. [cell]"""
REST = 0.15
"""Time that the cursor has to rest on a motor before its forecast is computed with all draws. [s]"""
DRAWS = 400
"""Number of simulations for each motor in the list, from which densities are drawn. [1]"""


class NextScreen(PageScreen):
    """On the left the motors, on the right the forecast of the one under the cursor."""

    NAME = "next_flight"
    TITLE = "Next flight"
    ROW_REQUESTS = ("plan", "find")
    ABOUT = NEXT_HELP
    BINDINGS: ClassVar[list[BindingType]] = [
        LEAVE_LINE,
        Binding("slash", "search", "Motor", key_display="/", tooltip="Search motors"),
        Binding("p", "plan", "Plan", tooltip="Rocket, mass and conditions"),
        Binding("b", "build", "Rocket", tooltip="The next rocket and configuration"),
        Binding("g", "app.ask_target", "Target", tooltip="Target apogee"),
        Binding("d", "decide", "Decide", tooltip="Delay, ballast, contest points with this motor; saved forecasts"),
        Binding(
            "exclamation_mark",
            "unfold",
            "Safety",
            key_display="!",
            tooltip="Every safety check with its figures, or how many",
            show=False,
        ),
        Binding("c", "compare", "Compare", tooltip="All columns for all motors"),
        Binding("asterisk", "toggle_fit", "All", key_display="*", show=False, tooltip="Motors that fit, or every one"),
    ]
    DEFAULT_CSS = """
    NextScreen #plan { height: auto; padding: 0 1; background: $panel; }
    NextScreen #search { height: 1; }
    NextScreen #search Static { width: auto; padding: 0 1; }
    NextScreen #search Input, NextScreen #search Input:focus { width: 1fr; height: 1; border: none; padding: 0; }
    NextScreen #motors { width: 5fr; }
    NextScreen #card { width: 38; padding: 0 1; border-left: solid $border-blurred; scrollbar-size-vertical: 1; }
    NextScreen.-wide #card { width: 40%; min-width: 60; }
    NextScreen.-narrow #split { layout: vertical; }
    NextScreen.-narrow #motors { height: 7; width: 1fr; }
    NextScreen.-narrow #card { width: 1fr; height: 1fr; border-left: none; border-top: solid $border-blurred; }
    NextScreen.-narrow.-comparing #motors { height: 1fr; }
    NextScreen.-comparing #card, NextScreen.-blank #card { display: none; }
    NextScreen.-tall #hill { height: 11; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._motors = MotorList()
        self._plan: Plan | PlanWithoutMass | None = None
        self._rest: Timer | None = None

    def body(self) -> Iterable[Widget]:
        """The plan in a line, a search, the motors, the forecast."""
        yield Static("p to plan a flight: rocket, mass, conditions", id="plan")
        with Horizontal(id="search"):
            yield Static("/")
            yield Line(placeholder="motor: F24, aerotech 24mm, a case ...", compact=True)
            yield Static("", id="count")
        with Horizontal(id="split"):
            yield Table(id="motors", enter="Save")
            yield ForecastCard(id="card")

    @property
    def card(self) -> ForecastCard:
        """The forecast of the motor under the cursor."""
        return self.query_one(ForecastCard)

    def on_mount(self) -> None:
        """Focus the motors."""
        self.set_focus(self.query_one(Table))

    def reload(self) -> None:
        """Read the plan, and forecast every motor again."""
        self.ask(partial(read_plan, self.resources), self._have_plan, "plan")

    def redraw(self) -> None:
        """Sort and show the forecasts again: other units or another target do not change them."""
        if self._motors.plan is None:
            self.reload()
            return
        self._show_plan(self._motors.plan)
        self._refill()

    def _have_plan(self, plan: Plan | PlanWithoutMass | None) -> None:
        self._plan = plan
        self._motors.turn_to(plan if isinstance(plan, Plan) else None)
        self.set_class(not isinstance(plan, Plan), "-blank")
        if not isinstance(plan, Plan):
            line = "No plan yet. p to enter one" if plan is None else plan.why
            self.query_one("#plan", Static).update(Content(line))
            self.query_one(Table).empty = NO_FLIGHTS if plan is None else MASS_UNKNOWN
            self.query_one(Table).show((), (), lambda _: ())
            return
        self.query_one(Table).empty = "no motor fits; * shows them all"
        self._show_plan(plan)
        self._search_now()

    def _show_plan(self, plan: Plan) -> None:
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
        """Show the network's forecasts of all motors without one; the fit's replace them, and report any error."""
        plan, waiting = self._motors.plan, self._motors.unanswered(self.query_one(Table).current)
        if plan is None or not waiting:
            self._forecast()
            return
        work = or_why(partial(quick_guide, plan.rocket, plan.full, waiting))
        self.ask(work, partial(self._have_quick, plan), "quick", alone=True)

    def _have_quick(self, plan: Plan, found: list[QuickChoice] | str) -> None:
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
            return guide(plan.rocket, plan.full, waiting, plan.limits, plan.site, DRAWS)

        self.ask(work, partial(self._have, plan), "forecast", alone=True)

    def _have(self, plan: Plan, found: Sequence[MotorChoice]) -> None:
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
            return predict_plans(self.resources.ledger, self.resources.motors, [one.plan], keep=False)

        self.ask(work, partial(self._have_exact, one), "exact", alone=True)

    def _have_exact(self, one: MotorChoice, made: list[Prediction]) -> None:
        """Show it unless the plan has changed."""
        if self._motors.known.get(one.motor) is one:
            self._motors.put_exact(one.motor, made[0])
            self._refill()

    def action_search(self) -> None:
        """Type a motor's name."""
        self.set_focus(self.query_one(Input))

    def action_toggle_fit(self) -> None:
        """Show only motors that fit, or all."""
        self._motors.fitting = not self._motors.fitting
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

    async def action_decide(self, view: int = 0) -> None:
        """Open the decisions for the motor under the cursor."""
        await self.settled("change", "plan")
        plan, motor = self._motors.plan, self.query_one(Table).current
        if plan is not None and motor is not None:
            one = self._motors.known.get(motor)
            full = plan.full.with_changes(motor=label(motor), delay=one.delay if one else None)
            self.app.push_screen(PlanScreen(Decision(full, plan.rocket, plan.site, plan.limits, motor), view))

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
            return predict_plans(self.resources.ledger, self.resources.motors, [one.plan], decided=True)

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
