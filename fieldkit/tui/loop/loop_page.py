"""Loop: errors of a rocket's model, possible missing effects, the model with them, and earlier versions.

The search of the Loop page for what several rockets share that the model lacks.

The help of the Loop page: what its panels mean.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.flight.short_name import flight_label
from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.presentation.fleet_text import in_words
from fieldkit.presentation.loop_headline import headline
from fieldkit.presentation.loop_text import report
from fieldkit.progress import ReportProgress
from fieldkit.quantities import percent
from fieldkit.safe_text import printable
from fieldkit.services.close_loop import adopt, in_use
from fieldkit.services.findings import Findings
from fieldkit.services.fleet_findings import save_findings, saved_findings
from fieldkit.services.fleet_loop import close_fleet_loop
from fieldkit.services.forecasts import used_version
from fieldkit.tui.asking import go_on, or_why
from fieldkit.tui.help import NO_FLIGHTS, Help
from fieldkit.tui.loop.loop_look import PANELS, Standing, beside_the_others, look, standing_of
from fieldkit.tui.loop.loop_panels import Panels
from fieldkit.tui.loop.single_flights import SingleFlights
from fieldkit.tui.page import PageScreen
from fieldkit.tui.report import ask_report
from fieldkit.tui.resources import Resources
from fieldkit.tui.widgets.table import Table
from fieldkit.tui.widgets.tabs import TabLine

LOOP_HELP = Help(
    "Which effect do the forecasts of a rocket lack? Each flight is forecast from the others, and the misses are "
    "compared with those that known effects would cause: wind, weak motors, an altimeter that reads high.",
    (
        ("S, A, D", "S searches and changes nothing; A accepts the result for later forecasts, D declines it."),
        (
            "Verdict",
            "What is missing in one sentence, the mean miss of flights that were forecast from the others, before and "
            "after accepting it, and what to do next. Below: what several rockets share, searched after this one.",
        ),
        (
            "Flights",
            "Every flight beside the others of the rocket, first those that differ, marked ! with the likely cause. "
            "Enter or t tags one with it, which leaves it out of every fit.",
        ),
        (
            "Evidence",
            "A level down: why, what it changes on the next flight, misses flight by flight, the odds, the flight that "
            "would decide, what accepting changes, and the error on held-out flights.",
        ),
        (
            "Residuals",
            "Flown minus forecast of each flight, in units of its expected scatter, against the column chosen "
            "with v. p is the probability of such a pattern by chance, corrected for the number of columns "
            "tested.",
        ),
        (
            "Fingerprint",
            "The residual that an effect (n for the next one) would cause in each readout, beside the one observed.",
        ),
        (
            "Ranking",
            "Effects, the most probable first. Chance: the probability that it is present, alone or with others. "
            "Evidence, for it alone: +3 is twenty to one for it, 0 is neutral, negative is against it. Below are the "
            "details of the one under the cursor; Enter for its fingerprint.",
        ),
        (
            "effect that S looks for, up to",
            "Before a search: each effect that it tries, and a strength that the effect rarely exceeds.",
        ),
        (
            "Versions",
            "Saved models of this rocket, and the one in use. 0 is without a correction. Enter switches to another, u "
            "undoes that.",
        ),
        ("no., made, adds", "Number of the version, its date, and the effects that it adds."),
        ("held-out error", "Its mean error on held-out flights, before and after."),
    ),
    (
        "fieldkit loop [--rocket R] [--dry-run] [--report FILE]",
        "fieldkit loop --fleet",
        "fieldkit model --use N",
        "fieldkit report ROCKET --out r.pdf",
    ),
)


def search_fleet(resources: Resources, on_progress: ReportProgress) -> Sequence[str]:
    """Search all rockets, and save the findings as sentences, the most probable first. Raises NoFlights, Dropped."""
    found = close_fleet_loop(resources.ledger, resources.motors, on_progress)
    lines = [f"{in_words(one)}, chance {percent(one.finding.probability)}" for one in found.results]
    save_findings(resources.ledger, lines)
    return lines


class LoopScreen(PageScreen):
    """A headline with single flights and versions, and a level down the evidence: one panel or all of a level."""

    NAME = "loop"
    ON_ENTER = ("Use it", "Use this version, tag this flight, or show the fingerprint of this effect")
    TITLE = "Loop"
    ABOUT = LOOP_HELP
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("S", "search", "Search", tooltip="Search for missing effects"),
        Binding("A", "accept", "Accept", tooltip="Use the effects that were found"),
        Binding("D", "decline", "Decline", tooltip="Leave the model unchanged"),
        Binding("t", "tag", "Tag", tooltip="Tag the flight that stands out with its likely cause", show=False),
        Binding("v", "covariate", "Against", tooltip="Residuals against the next column"),
        Binding("n", "effect", "Effect", tooltip="Fingerprint of the next effect"),
        Binding("b", "rocket", "Rocket", tooltip="The next rocket", show=False),
        Binding("w", "report", "Report", tooltip="Write the report of this rocket", show=False),
        Binding("left", "turn(-1)", "Previous panel", show=False, priority=True),
        Binding("right", "turn(1)", "Views", key_display="←→", priority=True, tooltip="The next view; ← previous"),
    ]
    VERTICAL_BREAKPOINTS = [(0, "-short"), (34, "-tall")]  # noqa: RUF012  # as Textual has it
    DEFAULT_CSS = """
    LoopScreen #what { height: 1; padding: 0 1; background: $panel; text-wrap: nowrap; text-overflow: ellipsis; }
    LoopScreen #panels { height: 1fr; }
    LoopScreen.-wide #panels { layout: grid; grid-size: 2 2; grid-rows: 2fr 1fr; }
    LoopScreen.-wide #panels.-under { grid-rows: 1fr 1fr; }
    LoopScreen.-wide .panel { display: none; border: round $border-blurred; border-title-color: $foreground; }
    LoopScreen.-wide .-first, LoopScreen.-wide .-under .-deep { display: block; }
    LoopScreen.-wide .-under .-first { display: none; }
    LoopScreen.-wide .panel.-front { border: heavy $border; }
    LoopScreen.-wide #p-Verdict { row-span: 2; }
    LoopScreen.-wide.-tall #each.-shown { display: block; }
    """

    @dataclass
    class TrialProgress(Message):
        """The current step of a search on a rocket, and the fraction done."""

        rocket: str
        text: str
        done: float

    def __init__(self) -> None:
        super().__init__()
        self._standing: Standing | None = None
        self._rocket: str | None = None
        self._panel, self._against, self._effect = 0, 0, 0
        self._accepted_version: int | None = None
        self._tagging = False
        self._search = ""
        """The rocket of the search that is running; empty if none is."""

    def body(self) -> Iterable[Widget]:
        """The rocket, the names of the panels, the panels."""
        yield Static("reading the ledger ...", id="what")
        yield TabLine(PANELS, "screen.panel", id="tabs")
        yield Panels()

    @property
    def panels(self) -> Panels:
        """The panels with the findings, if there are any."""
        return self.query_one(Panels)

    def on_mount(self) -> None:
        """Show the first panel."""
        self._front()

    def reload(self) -> None:
        """Read the models of the rocket; findings from older flights are cleared."""
        self.ask(partial(standing_of, self.resources, self._rocket), self._have)
        self.ask(lambda: saved_findings(self.resources.ledger), self.panels.headline.show_fleet, "fleet")

    def redraw(self) -> None:
        """Show the same data in other units."""
        if self._standing is not None:
            self._show_versions(self._standing)
            self.panels.show_flights(self.panels.beside, self.resources.settings.units)

    def _have(self, standing: Standing | None) -> None:
        if standing is None:
            self._standing = None
            self.query_one("#what", Static).update("No rocket yet")
            self._drop_search(NO_FLIGHTS)
            return
        before = self._standing
        if before is None:
            self.panels.forget()  # that there were no flights
        changed = before is not None and before.flights != standing.flights
        if changed and not self._tagging and (self._search or self.panels.found):
            self._drop_search("The flights have changed. S to search again")
        self._tagging = False
        self._show_versions(standing)
        if self.panels.found is None and (before is None or changed or before.rocket != standing.rocket):
            look = partial(beside_the_others, self.resources, standing.rocket)
            self.ask(or_why(look), self._have_flights, "flights", alone="app")

    def _have_flights(self, found: Sequence[FlightBesideOthers] | str) -> None:
        """Show the flights that stand out; without any that can be compared, none."""
        if self.panels.found is None:
            rows, system = () if isinstance(found, str) else found, self.resources.settings.units
            self.panels.show_flights(rows, system, searched=False)

    def _show_versions(self, standing: Standing) -> None:
        """Show the models of the rocket, and which is in use."""
        self._standing, self._rocket = standing, standing.rocket
        more = " · b next rocket" if len(standing.rockets) > 1 else ""
        model = f"version {standing.used}" if standing.used else "no correction"
        self.query_one("#what", Static).update(Content(printable(f"{standing.rocket} · forecasts with {model}{more}")))
        self.panels.show_versions(standing, self.resources.settings.units)
        if not self._search:
            self.panels.show_before(standing, self.resources.settings.units)
        self.panels.show_verdict(self.resources.settings.units, accepted=self._is_accepted)
        self.panels.show_residuals(self._against, self.resources.settings.units)

    @property
    def _is_accepted(self) -> bool:
        """Whether the model with the findings shown is in use."""
        return (
            self._accepted_version is not None
            and self._standing is not None
            and self._standing.used == self._accepted_version
        )

    async def action_search(self) -> None:
        """Search for missing effects with progress; nothing changes."""
        await self.settled("ask")
        if self._standing is None:
            return
        rocket = self._standing.rocket
        self.action_panel(PANELS.index("Verdict"))
        self.panels.progress("reading flights", 0.0)
        self._search = rocket
        report = partial(self._looking, rocket)
        self.ask(or_why(partial(look, self.resources, rocket, report)), self._looked, "look", alone="app")

    def _looking(self, rocket: str, text: str, done: float) -> None:
        """Report the progress. Raises Dropped if another search was started or the app is closed."""
        go_on()
        self.post_message(self.TrialProgress(rocket, text, done))

    @on(TrialProgress)
    def _progress(self, message: TrialProgress) -> None:
        """Show the progress, unless the search was dropped."""
        if message.rocket == self._search:
            self.panels.progress(message.text, message.done)

    def _drop_search(self, why: str = "") -> None:
        """Clear the findings, and cancel a search that would bring others."""
        self._search = ""
        self.workers.cancel_group(self, "look")
        self.panels.forget(why)

    def _looked(self, found: Findings | str) -> None:
        """Show the findings, or the reason for their absence."""
        self._search = ""
        if isinstance(found, str):
            self.panels.forget(found)
            if self._standing is not None:
                self._show_versions(self._standing)
            if not self.is_current:
                self.complain(found)
            return
        self._effect, self._accepted_version = 0, None
        self.panels.show(found, self.resources.settings.units)
        self.panels.show_residuals(self._against, self.resources.settings.units)
        used = partial(in_use, self.resources.ledger, found.rocket, found.diagnosis)
        self.ask(used, partial(self._have_in_use, found), "used")
        if not self.is_current or (self._panel != PANELS.index("Verdict") and not self.has_class("-wide")):
            self.show_notice(f"The search of {found.rocket} has ended. {headline(found).sentence}")
        if self._standing is not None and len(self._standing.rockets) > 1:
            work = partial(search_fleet, self.resources, lambda *_: go_on())
            self.ask(or_why(work), self._have_fleet, "fleet", alone="app")

    def _have_in_use(self, found: Findings, used: bool) -> None:
        """Show that a search has found again what was accepted before."""
        if used and self._standing is not None and self._standing.used and self.panels.found is found:
            self._accepted_version = self._standing.used
            self.panels.show_verdict(self.resources.settings.units, accepted=True)

    def _have_fleet(self, lines: Sequence[str] | str) -> None:
        """Show what the rockets share."""
        self.panels.headline.show_fleet(() if isinstance(lines, str) else lines)

    def _front(self) -> None:
        """Bring the current panel to the front, and focus it."""
        self.query_one(TabLine).front(self._panel)
        self.set_focus(self.panels.front(self._panel))

    def action_panel(self, panel: int) -> None:
        """Show another panel."""
        self._panel = panel
        self._front()

    def action_turn(self, by: int) -> None:
        """Show the next or previous panel."""
        self.action_panel((self._panel + by) % len(PANELS))

    def action_covariate(self) -> None:
        """Show residuals against the next column."""
        self._against += 1
        self.panels.show_residuals(self._against, self.resources.settings.units)
        self.action_panel(PANELS.index("Residuals"))

    def action_effect(self) -> None:
        """Show the fingerprint of the next effect."""
        self._effect += 1
        self._show_effect()

    @on(Table.Chosen, "#ranking")
    def _effect_chosen(self, message: Table.Chosen) -> None:
        """Show the fingerprint of the effect under the cursor."""
        found = self.panels.found
        if found is None:
            self.show_notice("No fingerprint yet. S to search for missing effects")
            return
        drawn = [str(trial.candidate.place) for trial, _ in found.fingerprints]
        if message.key not in drawn:
            self.complain("no fingerprint: only the most probable effects have one")
            return
        self._effect = drawn.index(message.key)
        self._show_effect()

    def _show_effect(self) -> None:
        self.panels.show_marks(self._effect)
        self.action_panel(PANELS.index("Fingerprint"))

    async def action_rocket(self) -> None:
        """Turn to the next rocket."""
        await self.settled("ask")
        if self._standing is not None and len(self._standing.rockets) > 1:
            rockets = self._standing.rockets
            self._rocket = rockets[(rockets.index(self._standing.rocket) + 1) % len(rockets)]
            self._drop_search()
            self.reload()

    def action_accept(self) -> None:
        """Accept the found effects."""
        found = self.panels.found
        if found is None:
            self.complain("Nothing to accept yet. S to search for missing effects; Verdict shows the progress")
            return
        plain = self._standing is None or self._standing.plain
        if plain and all(not places for _, places in found.diagnosis.averaged):
            self.show_notice("Nothing to accept: no correction is in use")
            return
        if self._is_accepted:
            self.show_notice("Already accepted: forecasts use it")
            return

        def work() -> int:
            adopt(self.resources.ledger, found.rocket, found.diagnosis)
            return used_version(self.resources.ledger, found.rocket)

        self.change(work, self._accepted)

    def _accepted(self, version: int) -> None:
        self._accepted_version = version
        self.show_change("Accepted: forecasts use it from now on. u to undo")

    def action_decline(self) -> None:
        """Leave the model unchanged; one that was accepted stays in use until that is undone."""
        if self.panels.found is None:
            self.show_notice("Nothing to decline yet. S to search for missing effects")
        elif self._is_accepted:
            self.show_notice("Already accepted: forecasts use it. u to undo")
        else:
            self.show_notice("Declined: the model is unchanged")

    @on(Table.Chosen, "#odd")
    def action_tag(self) -> None:
        """Accept the likely cause of the flight under the cursor as its tag."""
        single = self.panels.query_one(SingleFlights)
        one, tag = single.current, single.tag
        if one is None or not tag:
            self.show_notice("No flight with a likely cause to tag")
            return
        ledger, flight = self.resources.ledger, one.flight

        def work() -> str:
            (id,) = ledger.ids([flight])
            ledger.tag(id, tag)
            return id

        self.change(work, partial(self._tagged, tag))

    def _tagged(self, tag: str, id: str) -> None:
        """Show the flight as tagged; the findings stay, although they were made with it."""
        self._tagging = True
        name = id.split("/")[-1]
        found = [
            replace(one, flight=one.flight.with_changes(tags=(tag,))) if one.flight.flight_id == name else one
            for one in self.panels.beside
        ]
        self.panels.show_flights(found, self.resources.settings.units)
        self.show_change(f"Tagged {flight_label(id)} {tag}: fits leave it out. S to search again, u to undo")

    @on(Table.Chosen, "#versions")
    def _use(self, message: Table.Chosen) -> None:
        if self._standing is None:
            return
        rocket, number = self._standing.rocket, message.key
        named = f"version {number}" if number else "no correction"
        if number == self._standing.used:
            self.show_notice(f"{rocket} already uses {named}")
            return
        work = partial(self.resources.ledger.activate, rocket, number or None)
        self.change(work, lambda _: self.show_change(f"{rocket} forecasts with {named}. u to undo"))

    def action_report(self) -> None:
        """Write the report of this rocket with the loop's findings."""
        if self._standing is not None:
            ask_report(self, self._standing.rocket)

    def copied(self) -> str:
        """The report of `fieldkit loop` as text, or the version under the cursor."""
        found = self.panels.found
        if found is None or PANELS[self._panel] == "Versions":
            return self.query_one("#versions", Table).current_text()
        return "\n".join(report(found, self.resources.settings.units, details=True))
