"""The form of values that a file lacks: rocket, motor, site, date and mass, for every flight in it."""

import asyncio
from collections.abc import Callable, Mapping
from contextlib import suppress

from textual import on
from textual.widgets import Input
from textual.worker import Worker

from fieldkit.errors import FieldkitError
from fieldkit.flight import BY_NAME
from fieldkit.importing.manual_entry import Question, date_order, read_answer
from fieldkit.quantities import unit_of
from fieldkit.services.manual_entry import with_unit
from fieldkit.tui.add.add_form import Draft
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen

TEXTS = {"rocket": "Rocket", "config": "Configuration", "motor": "Motor", "site": "Site", "date_time": "Date"}
NUMBERS = ("dry_mass", "diameter")
"""Columns that are asked for: texts with their titles, and numbers."""
QUESTIONS = (
    *(Question(name, title, "For every flight in the file that lacks it.") for name, title in TEXTS.items()),
    *(Question(name, BY_NAME[name].title, BY_NAME[name].help) for name in NUMBERS),
)


BUILD = ("config", *NUMBERS)
"""Questions that another rocket answers differently."""


class SetupForm(Form):
    """The form: configuration, mass and diameter follow the rocket unless they were typed; `offers` finds them from the
    answers so far. A motor filled in for another rocket is removed."""

    offers: Callable[[Mapping[str, str]], dict[str, str]]
    _following: Worker[None] | None = None

    @on(Input.Changed, "#in-rocket,#in-config")
    def _changed(self) -> None:
        self._following = self.run_worker(self._follow, group="follow", exclusive=True)

    async def _follow(self) -> None:
        """Fill in the setup of the rocket that is named now."""
        if not (fields := self.open_fields()):
            return
        rocket = fields["rocket"].answer
        named = {name: fields[name].answer for name in ("rocket", "config") if name == "rocket" or fields[name].typed}
        found = self._texts
        if any(fields[name].typed for name in named):
            offered: dict[str, str] = {}
            with suppress(FieldkitError):  # without a ledger, nothing is offered
                offered = await asyncio.to_thread(self.offers, named) if rocket else {}
            same = rocket == self._texts["rocket"]
            found = {name: offered.get(name, "") for name in BUILD} | {"motor": self._texts["motor"] if same else ""}
        for name in (*BUILD, "motor") if self.open_fields() else ():
            if not fields[name].typed:
                fields[name].fill(found.get(name, ""))

    async def action_take(self) -> None:
        """Submit the answers when they have followed the rocket."""
        if self._following is not None:
            await self._following.wait()
        await super().action_take()


def ask_given(page: PageScreen, given: Mapping[str, str], answer: Callable[[dict[str, str]], None]) -> None:
    """Ask for values that a file lacks; values `given` for other columns are unchanged. `answer` gets all of them as
    text."""
    system = page.resources.settings.units
    units = {name: unit_of(BY_NAME[name], system) for name in NUMBERS} | {"date_time": date_order(system)}
    texts = {question.name: given.get(question.name, "") for question in QUESTIONS}

    def answered(values: dict[str, object]) -> None:
        named = {name: str(text) for name, text in values.items() if text}
        answer({name: text for name, text in given.items() if name not in texts} | named)

    form = SetupForm("Not in the file", QUESTIONS, texts, units, _checked, page.resources.names)
    form.offers = Draft(page.resources).offers
    page.ask_form(form, answered)


def _checked(name: str, text: str, unit: str) -> str:
    """An answer as it was typed, with its unit. Raises BadValue for one that cannot be read."""
    read_answer(name, text, unit)
    return with_unit(text, unit)
