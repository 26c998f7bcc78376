"""The form of a plan: rocket, mass and conditions."""

import asyncio
from collections.abc import Callable
from functools import partial

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.flight import BY_NAME, Flight
from fieldkit.quantities import unit_of
from fieldkit.services.launch_day import save_plan
from fieldkit.services.plans import completed_plan
from fieldkit.tui.add.fields import Form
from fieldkit.tui.next.next_plan import PLAN, QUESTIONS, plan_texts, planned
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import Resources
from fieldkit.tui.setup.setup_lists import same

BODY = ("dry_mass", "diameter")
"""The figures of a plan that belong to its rocket."""


async def ask_plan(page: PageScreen, plan: Flight, keep: Callable[[Flight], None]) -> None:
    """Ask for changes of a plan, which shows the mass and diameter that its forecasts use, and save them."""
    system = page.resources.settings.units
    shown = await asyncio.to_thread(partial(_with_body, page.resources, plan))
    units = {name: unit_of(BY_NAME[name], system) for name in PLAN}

    def answered(values: dict[str, object] | None) -> None:
        if values is None:
            return
        as_shown = {name for name in PLAN if not_retyped(shown, name, values[name], system)}
        values = {**values, **{name: plan.number(name) for name in as_shown}}  # the form shows rounded numbers
        if (values["rocket"], values["config"]) != (plan.rocket, plan.config):  # unchanged figures are of the old one
            values = {**values, **dict.fromkeys(as_shown.intersection(BODY))}
        try:
            keep(planned(values))
        except BadValue as error:
            page.complain(str(error))

    page.app.push_screen(
        Form("The plan", QUESTIONS, plan_texts(shown, system), units, names=page.resources.names), answered
    )


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
