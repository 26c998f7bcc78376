"""What the command palette finds: pages, keys, flights, rockets, motors, settings, help, and shell commands."""

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from shlex import quote
from typing import Any, cast

from rich.cells import cell_len
from textual.command import DiscoveryHit, Hit, Provider
from textual.content import Content
from textual.fuzzy import Matcher

from fieldkit.errors import FieldkitError
from fieldkit.flight.short_name import flight_label
from fieldkit.motors import Motor
from fieldkit.safe_text import printable
from fieldkit.tui.help import Help
from fieldkit.tui.home.first_run import take
from fieldkit.tui.home.first_steps import Step
from fieldkit.tui.host import Host
from fieldkit.tui.next.motor_facts import facts
from fieldkit.tui.next.plan_pages import PAGES
from fieldkit.tui.next.plan_screen import FINALS, LANDING, VIEWS, PlanScreen
from fieldkit.tui.page import PageScreen, pages
from fieldkit.tui.setup.card_form import ask_card
from fieldkit.tui.setup.setup_forms import ask_rail
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.dialogs import HelpScreen

NAME_WIDTH = 34
"""Width of the names, after which descriptions start in one column. [cell]"""
MAX_HITS = 20
"""Maximum number of results of each kind: thousands of flights leave room for motors and help. [1]"""


@dataclass(frozen=True, slots=True)
class Entry:
    """A result: its kind, its name, its description, and its action."""

    kind: str
    text: str
    about: str
    go: Callable[[], Any]


class Finder(Provider):
    """Everything by name, the best match first."""

    @property
    def _host(self) -> Host:
        return cast(Host, self.app)

    async def startup(self) -> None:
        """Load the searchable items."""
        try:
            kept = await asyncio.to_thread(self._read)
        except FieldkitError:
            kept = []  # without a ledger, the other results are still listed
        for page in pages().values():
            await page.imported()
        self._entries = [*self._actions(), *self._settings(), *kept, *self._help()]

    async def discover(self) -> AsyncIterator[DiscoveryHit]:
        """Pages, colors, units and keys, before anything is typed."""
        for entry in sorted(self._actions(), key=lambda entry: entry.text):
            yield DiscoveryHit(_line(Content(entry.text), entry), entry.go, entry.text)

    async def search(self, query: str) -> AsyncIterator[Hit]:
        """The matches, best first."""
        matcher = self.matcher(query)
        found = [(score, entry) for entry in self._entries if (score := matcher.match(entry.text)) > 0]
        listed = Counter[str]()
        for score, entry in sorted(found, key=lambda hit: -hit[0]):
            listed[entry.kind] += 1
            if listed[entry.kind] <= MAX_HITS:
                yield Hit(score, _line(_marked(entry.text, matcher), entry), entry.go, entry.text)

    def _read(self) -> list[Entry]:
        """Flights, rockets and motors."""
        host, resources = self._host, self._host.resources
        flights = resources.ledger.flights()
        ids = resources.ledger.ids(flights)
        newest = reversed(list(zip(ids, flights, strict=True)))
        rockets = dict.fromkeys(flight.rocket for flight in reversed(flights) if flight.rocket)
        return [
            *(
                Entry("rocket", f"Rocket {printable(name)}", "Its flights", partial(host.show_flights, name))
                for name in rockets
            ),
            *(
                Entry(
                    "flight",
                    cards.heading(flight, flight_label(id, "Flight")),
                    "Open this flight",
                    partial(host.open_flight, id),
                )
                for id, flight in newest
            ),
            *(
                Entry(
                    "motor",
                    f"Motor {motor.maker} {motor.designation}",
                    f"{motor.diameter * 1e3:.0f} mm, {motor.total_impulse:.0f} N s",
                    partial(self._about_motor, motor),
                )
                for motor in resources.motors.motors
            ),
        ]

    def _actions(self) -> Iterator[Entry]:
        """Pages, colors, units, and the actions of the page under the palette."""
        for command in self.app.get_system_commands(self.screen):
            yield Entry("action", command.title, command.help, command.callback)

    def _settings(self) -> Iterator[Entry]:
        host = self._host
        yield Entry("setting", "Setting: target", "The target apogee for comparing motors", host.action_ask_target)
        yield Entry("setting", "Setting: rail", "Length and angle of your usual rail", self._ask_rail)
        yield Entry("setting", "Your card", "Certification, age, rules, rods, range box", self._ask_card)
        yield Entry("setting", "Setting: units", "The next units: SI, US, mixed", host.action_next_units)
        for place, view in enumerate(VIEWS):
            about = "For the motor selected on the Fly page"
            yield Entry("decision", f"Decide: {view.lower()}", about, partial(host.decide, place))
        for kind, (what, about) in PAGES.items():
            at = FINALS if kind == "finals" else LANDING
            yield Entry("page", f"Write the {what}", about, partial(host.decide, at, kind))
        yield Entry("setting", "Load the demo rocket", Step.DEMO.value[1], self._load_demo)
        yield Entry("setting", "Setting: theme", "The next colors: field, sun, night, terminal", host.action_next_theme)

    def _help(self) -> Iterator[Entry]:
        """Every field explained on a page or beside the decisions, and every equivalent command."""
        commands: set[str] = set()
        topics = [(page.title, page.screen.ABOUT) for page in pages().values()]
        topics.append(("Fly, then d", PlanScreen.ABOUT))
        for title, about in topics:
            for name, text in about.fields:
                topic = replace(about, about=f"{name}: {text}")
                yield Entry("help", f"Help: {name} ({title})", text, partial(self._show_help, title, topic))
            for command in about.twin:
                if command not in commands:
                    commands.add(command)
                    yield Entry("command", f"Command: {command}", "Copies it", partial(self._copy, command))

    def _show_help(self, title: str, about: Help) -> None:
        self.app.push_screen(HelpScreen(f"Help: {title}", about, ()))

    def _about_motor(self, motor: Motor) -> None:
        name = f"{motor.maker} {motor.designation}"
        about = Help(
            "The catalog data of this motor.",
            facts(motor, self._host.resources.settings.units),
            (f"fieldkit motors {quote(name)} --json",),
        )
        self.app.push_screen(HelpScreen(name, about, (), "Catalog data"))

    async def _load_demo(self) -> None:
        if isinstance(page := self.app.screen, PageScreen):
            await take(page, Step.DEMO)

    def _ask_rail(self) -> None:
        if isinstance(page := self.app.screen, PageScreen):
            ask_rail(page)

    def _ask_card(self) -> None:
        if isinstance(page := self.app.screen, PageScreen):
            ask_card(page)

    def _copy(self, command: str) -> None:
        self.app.copy_to_clipboard(command)
        self._host.show_notice(f"Copied: {command}")


def _marked(text: str, matcher: Matcher) -> Content:
    """A text with its matching letters marked; brackets in it are not markup."""
    content = Content(text)
    for place in matcher.fuzzy_search.match(matcher.query, text)[1]:
        content = content.stylize(matcher.match_style, place, place + 1)
    return content


def _line(name: Content, entry: Entry) -> Content:
    """A name, its matching letters marked, and its description, in one line."""
    gap = " " * max(2, NAME_WIDTH - cell_len(entry.text))
    return Content.assemble(name, gap, (printable(entry.about), "not bold"))
