"""The panels of the Loop page: one at a time, or all of a level at once if there is room."""

from collections.abc import Iterable, Sequence
from functools import partial

from textual import on
from textual.containers import Container, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.physics.effect import Effect
from fieldkit.safe_text import printable
from fieldkit.services.findings import Findings
from fieldkit.tui.loop.headline import HeadlinePanel
from fieldkit.tui.loop.loop_before import (
    before_search,
    effects_before,
    explained_before,
    flown_apogees,
    rows_before,
)
from fieldkit.tui.loop.loop_look import FRONT, PANELS, Standing
from fieldkit.tui.loop.loop_words import (
    draw_points,
    effect_at_length,
    fingerprint,
    ranking_rows,
    residual_points,
    verdict,
    version_rows,
)
from fieldkit.tui.loop.single_flights import SingleFlights, odd_flights
from fieldkit.tui.widgets.plots import Plot
from fieldkit.tui.widgets.table import Head, Table

TEXT_BEFORE_RUN = {
    "verdict": "Press S to search for missing effects: each flight is forecast from the others, and the residuals are "
    "compared with those that known effects would cause. It takes a few seconds and changes nothing.",
    "against": "",
    "marks": "After S: the residual that an effect would cause in each readout, beside the one observed.",
}
"""The text in a panel before a search."""
PANEL_FRAME = 6
"""Columns of a panel for its frame, its margins and a scrollbar. [cell]"""


class Panels(Container):
    """The findings for a rocket's model, and its saved versions."""

    DEFAULT_CSS = """
    Panels .panel { display: none; height: 1fr; padding: 0 1; }
    Panels .panel.-front { display: block; }
    Panels .panel Static { height: auto; }
    Panels #p-Residuals Static { text-style: bold; }
    Panels #p-Ranking Table { height: 1fr; min-height: 4; }
    Panels #p-Ranking Static { margin-top: 1; }
    Panels #p-Versions Table { height: 1fr; }
    """

    def __init__(self) -> None:
        super().__init__(id="panels")
        self.found: Findings | None = None
        self._system, self._why, self._effect = "SI", "", 0
        self._tried: dict[str, Effect] = {}
        self._beside: Sequence[FlightBesideOthers] = ()

    @property
    def headline(self) -> HeadlinePanel:
        """The first panel."""
        return self.query_one(HeadlinePanel)

    def compose(self) -> Iterable[Widget]:
        """One frame per panel."""
        yield HeadlinePanel(id="p-Verdict", classes="panel")
        yield SingleFlights(id="p-Flights", classes="panel")
        with Container(id="p-Versions", classes="panel"):
            yield Table(id="versions", enter="Use it")
        with VerticalScroll(id="p-Evidence", classes="panel"):
            yield Static(id="evidence")
        with Container(id="p-Residuals", classes="panel"):
            yield Static(id="against")
            yield Plot(id="residuals")
        with VerticalScroll(id="p-Fingerprint", classes="panel"):
            yield Static(id="marks")
        with Vertical(id="p-Ranking", classes="panel"):
            yield Table(id="ranking", empty="S to search for missing effects", enter="Fingerprint")
            yield Static(id="at-length")

    def on_mount(self) -> None:
        """Set the titles of the panels, which show if all are visible."""
        for name in PANELS:
            panel = self.query_one(f"#p-{name}")
            panel.border_title = name
            panel.add_class("-first" if name in FRONT else "-deep")
        self.forget()

    def forget(self, why: str = "") -> None:
        """Clear the findings: no search has run yet, or the reason `why` there are none."""
        self.found, self._why = None, why
        self.headline.wait(why or TEXT_BEFORE_RUN["verdict"])
        for name, text in (TEXT_BEFORE_RUN | {"at-length": ""}).items():
            if name != "verdict":
                self.query_one(f"#{name}", Static).update(text)
        self.query_one(Plot).show(None)
        self.query_one("#ranking", Table).show((), (), lambda _: ())

    def progress(self, text: str, done: float) -> None:
        """Show the current step and the fraction done."""
        if self.found is None or done < 1:
            bar = "█" * round(done * 24)
            self.headline.wait(Content(f"searching: {printable(text)}\n[{bar:24}]"))

    def show(self, found: Findings, system: str) -> None:
        """Show the findings."""
        self.found = found
        self.show_flights(found.flights, system)
        self.show_verdict(system)
        self.show_residuals(0, system)
        self.show_marks(0)

    def show_verdict(self, system: str, *, accepted: bool = False) -> None:
        """Show the verdict and the ranking, in these units, and whether the verdict was accepted."""
        if self.found is not None:
            self.headline.show(self.found, system, accepted=accepted, odd=len(odd_flights(self._beside)))
            self.query_one("#evidence", Static).update(verdict(self.found, system))
            self._system = system
            rows = ranking_rows(self.found.diagnosis, system)
            heads = [Head("candidate effect", 0), Head("chance", 6, True), Head("evidence", 8, True)]
            heads.append(Head("strength", 16))
            self.query_one("#ranking", Table).show(heads, list(rows), rows.__getitem__)

    def show_flights(self, found: Sequence[FlightBesideOthers], system: str) -> None:
        """Show the flights beside the others of their rocket."""
        self._beside = found
        single = self.query_one(SingleFlights)
        single.found = found
        single.show(found, system)

    def show_residuals(self, turn: int, system: str) -> None:
        """Show residuals against the `turn`-th column, flight by flight; after the last column comes the first."""
        if self.found is not None:
            caption, points, ticks = residual_points(self.found, turn, system)
            self.query_one("#against", Static).update(Content(caption))
            self.query_one("#residuals", Plot).show(partial(draw_points, points, ticks))

    def show_marks(self, turn: int) -> None:
        """Show the fingerprints of the residual and of the `turn`-th effect; after the last effect comes the first
        again."""
        if self.found is not None:
            self._effect = turn
            width = self.size.width // 2 if self.screen.has_class("-wide") else self.size.width
            self.query_one("#marks", Static).update(fingerprint(self.found, turn, width - PANEL_FRAME))

    def on_resize(self) -> None:
        """Fit the bars of the fingerprint to the new width."""
        self.show_marks(self._effect)

    @on(Table.Moved, "#ranking")
    def _at_length(self, message: Table.Moved) -> None:
        """Show the effect under the cursor, in full."""
        caption: Content | str = ""
        if self.found is not None and message.key is not None:
            caption = effect_at_length(self.found.diagnosis, message.key, self._system)
        elif message.key in self._tried:
            caption = explained_before(self._tried[message.key])
        self.query_one("#at-length", Static).update(caption)

    def show_before(self, standing: Standing, system: str) -> None:
        """Show what a search would compare and the effects that it would try, until one runs."""
        if self.found is None:
            about = self._why or TEXT_BEFORE_RUN["verdict"]
            self.headline.wait(before_search(about, standing.flights, standing.motors))
            self.query_one("#evidence", Static).update("After S: why, how sure, and the error on held-out flights.")
            self.query_one("#marks", Static).update(effects_before(TEXT_BEFORE_RUN["marks"], standing.tried))
            self._tried = {effect.title: effect for effect in standing.tried}
            rows = rows_before(standing.tried, system)
            heads = [Head("effect that S looks for", 0), Head("up to", 30)]
            self.query_one("#ranking", Table).show(heads, list(rows), rows.__getitem__)
            caption, draw = flown_apogees(standing.flights, system)
            self.query_one("#against", Static).update(Content(caption))
            self.query_one("#residuals", Plot).show(draw)

    def show_versions(self, standing: Standing, system: str) -> None:
        """Show the models of the rocket, and which is in use."""
        rows = version_rows(standing.versions, system)
        heads = [Head("no.", 3, True), Head("made", 10), Head("adds", 0), Head("held-out error", 18, True), Head("", 8)]
        self.query_one("#versions", Table).show(heads, list(rows), rows.__getitem__)

    def front(self, panel: int) -> Widget | None:
        """Bring a panel to the front; returns the widget for its keys, None if it needs none."""
        for number, name in enumerate(PANELS):
            self.query_one(f"#p-{name}").set_class(number == panel, "-front")
        name = PANELS[panel]
        self.set_class(name not in FRONT, "-under")
        if name == "Residuals":
            return None
        return self.query_one(
            {"Ranking": "#ranking", "Versions": "#versions", "Flights": "#odd"}.get(name, f"#p-{name}")
        )
