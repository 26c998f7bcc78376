"""The form of a plan: rocket, mass and conditions."""

import asyncio
from collections.abc import Callable
from functools import partial

from textual import on
from textual.widgets import Input
from textual.worker import Worker

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.flight import Flight
from fieldkit.quantities import spelled
from fieldkit.services.launch_day import FURTHER, OF_THE_ROCKET, save_plan
from fieldkit.services.manual_entry import typed_unit
from fieldkit.services.plans import completed_plan
from fieldkit.tui.add.fields import Field, Form
from fieldkit.tui.next.next_plan import PLAN, QUESTIONS, further_text, plan_texts, plan_units, planned, read_planned
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import Resources
from fieldkit.tui.setup.setup_lists import same

BODY = ("dry_mass", "diameter")
"""The figures of a plan that belong to its rocket."""


class PlanForm(Form):
    """The form of a plan: mass and diameter are those of the rocket and configuration named in it, unless they were
    typed; `known` finds them, `shown` is the plan as the form shows it."""

    known: Callable[[Flight], Flight]
    shown: Flight
    system: str
    _following: Worker[None] | None = None

    @on(Input.Changed, "#in-rocket,#in-config")
    def _renamed(self) -> None:
        self._following = self.run_worker(self._follow, group="follow", exclusive=True)

    async def _follow(self) -> None:
        if not (fields := self.open_fields()):
            return
        build = {name: fields[name].answer for name in ("rocket", "config")}
        named = self.shown.with_changes(**build, **dict.fromkeys(BODY))
        self.shown = await asyncio.to_thread(self.known, named) if build["rocket"] else named
        texts = plan_texts(self.shown, self.system)
        for name in BODY if self.open_fields() else ():
            if not fields[name].typed:
                fields[name].fill(texts[name])

    def beside(self, field: Field, value: object, unit: str) -> str:
        """The unit of an answer; of a further column, which is a text, the one that it was typed in."""
        typed = typed_unit(field.answer) if field.question.name in FURTHER else ""
        return spelled(typed) if typed else super().beside(field, value, unit)

    async def action_take(self) -> None:
        """Submit the answers when they have followed the rocket."""
        if self._following is not None:
            await self._following.wait()
        await super().action_take()


async def ask_plan(page: PageScreen, plan: Flight, keep: Callable[[Flight], None]) -> None:
    """Ask for changes of a plan, which shows the mass and diameter that its forecasts use, and save them."""
    system = page.resources.settings.units
    shown = await asyncio.to_thread(partial(_with_body, page.resources, plan))

    def answered(values: dict[str, object]) -> None:
        as_shown = {name for name in PLAN if not_retyped(form.shown, name, values[name], system)}
        values = {**values, **{name: plan.number(name) for name in as_shown}}  # the form shows rounded numbers
        if (values["rocket"], values["config"]) != (plan.rocket, plan.config):  # its figures follow its last flight
            same = {name for name in OF_THE_ROCKET if values[name] == further_text(plan, name)}
            values = {**values, **dict.fromkeys(as_shown.intersection(BODY) | same)}
        try:
            keep(planned(values))
        except BadValue as error:
            page.complain(str(error))

    texts, units = plan_texts(shown, system), plan_units(system)
    form = PlanForm("The plan", QUESTIONS, texts, units, read_planned, page.resources.names)
    form.known, form.shown, form.system = partial(_with_body, page.resources), shown, system
    page.ask_form(form, answered)


def _with_body(resources: Resources, plan: Flight) -> Flight:
    """A plan with the mass and diameter of its rocket, as last flown or designed, if it has none."""
    try:
        full = completed_plan(resources.ledger, resources.motors, plan, resources.settings)
    except FieldkitError:
        return plan  # the page reports what cannot be read
    return plan.with_changes(**{name: full.number(name) for name in BODY if plan.number(name) is None})


def not_retyped(plan: Flight, name: str, value: object, system: str) -> bool:
    """Whether a number of a plan is the one that its form showed."""
    return same(name, value, plan_texts(plan, system)[name], system)


def keep_plan(page: PageScreen, plan: Flight) -> None:
    """Save a plan, and its weather as today's."""

    def work() -> bool:
        return save_plan(page.resources.ledger, plan_texts(plan))

    page.change(work, lambda _: page.field_app.changed())
