"""The panels of the Loop page: one at a time, or all of a level at once if there is room.

The front of the Loop page: one sentence, the miss before and after in large digits with bars, one next step.

The Loop page before a search: what would be compared, the flown apogees, and the effects that would be tried.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np
from textual import on
from textual.containers import Container, Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.flight import CONDITIONS, READOUTS, Flight
from fieldkit.forecast.one_offs import FlightBesideOthers
from fieldkit.messages import message, of_unit
from fieldkit.physics.effect import Effect
from fieldkit.presentation.loop_headline import Headline, compared_bars, headline
from fieldkit.quantities import in_system, number, spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.services.findings import Findings
from fieldkit.services.quick_look import MIN_FLIGHTS
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
from fieldkit.tui.setup.setup_card import draw_apogees
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import Hanging, hanging, stacked
from fieldkit.tui.widgets.misses import draw_misses
from fieldkit.tui.widgets.plots import Plot
from fieldkit.tui.widgets.table import Head, Table

RARE_SDS = 2.0
"""Standard deviations of a prior that an effect rarely exceeds. [1]"""


def before_search(about: str, flights: Sequence[Flight], motors: Sequence[str]) -> Hanging:
    """What a search does, and which flights of the rocket, readouts and conditions it would compare."""
    used = [flight for flight in flights if flight.clean and flight.readouts()]
    names = [*READOUTS, *CONDITIONS]
    counts = {one.title: sum(flight.number(one.name) is not None for flight in used) for one in names}
    pairs = [
        ("flights", f"{len(used)} of {len(flights)}: with readouts, without an anomaly tag"),
        ("motors", ", ".join(motors)),
        ("configurations", ", ".join(dict.fromkeys(flight.config for flight in used if flight.config))),
        ("recorded", ", ".join(f"{title.lower()} {count}" for title, count in counts.items() if count)),
        ("not recorded", ", ".join(title.lower() for title, count in counts.items() if not count)),
    ]
    return stacked(
        [Hanging(((0, Content(about)),)), cards.lines("What would be compared", [one for one in pairs if one[1]], 16)]
    )


def effects_before(about: str, tried: Sequence[Effect]) -> Hanging:
    """What a fingerprint is, and each effect that a search would try, with what it does to a flight."""
    pairs = [(effect.title, effect.explains) for effect in tried]
    return stacked([Hanging(((0, Content(about)),)), cards.lines("What a search tries", pairs, 26)])


def rows_before(tried: Sequence[Effect], system: str) -> dict[str, tuple[str, ...]]:
    """A row for each effect that a search would try, by its title: the title, and how large it may be in the units of a
    system."""
    return {effect.title: (effect.title, _size(effect, system)) for effect in tried}


def _size(effect: Effect, system: str) -> str:
    """The strength that an effect rarely exceeds by its prior: `10% of the height`."""
    prior = effect.prior
    ends = np.clip([prior.mean - RARE_SDS * prior.sd, prior.mean + RARE_SDS * prior.sd], prior.low, prior.high)
    largest = float(np.max(np.abs(effect.strength(ends))))
    whole = effect.unit.removeprefix("fraction ")
    if whole != effect.unit:
        return f"{largest:.0%} {whole}"
    return in_system(message(of_unit(largest, effect.unit, digits=2)), system)


def explained_before(effect: Effect) -> Content:
    """What an effect does to a flight, and what to fly or record to recognize it."""
    explained = f"{effect.explains[:1].upper()}{effect.explains[1:]}."
    return Content.assemble((effect.title, "b $primary"), f"\n{explained}\ntest     {effect.tell_apart}")


def flown_apogees(flights: Sequence[Flight], system: str) -> tuple[str, Callable[..., None] | None]:
    """The apogees of all flights of a rocket in the order flown, as a caption and a drawing; no drawing of fewer than
    two."""
    known = [flight for flight in flights if flight.apogee is not None]
    caption = f"Apogee [{_unit(system)}], flight by flight; ✗ tagged. After S: residuals against a column (v)"
    return caption, partial(draw_apogees, known, None, system) if len(known) > 1 else None


BAR = 24
"""Longest bar of a miss. [cell]"""


class HeadlinePanel(VerticalScroll):
    """The headline of a search; before one `#verdict` says what it would do, and during one how far it is."""

    DEFAULT_CSS = """
    HeadlinePanel #headline { height: auto; display: none; }
    HeadlinePanel.-found #headline { display: block; }
    HeadlinePanel.-found #verdict { display: none; }
    HeadlinePanel #sentence { text-style: bold; color: $primary; margin-bottom: 1; }
    HeadlinePanel #misses { height: 4; margin-bottom: 1; }
    HeadlinePanel #misses Vertical { width: auto; height: 4; margin-right: 4; }
    HeadlinePanel #misses Static { width: auto; }
    HeadlinePanel #after.-better { color: $success; }
    HeadlinePanel #after.-worse { color: $warning; }
    HeadlinePanel #step, HeadlinePanel #also, HeadlinePanel #fleet { margin-top: 1; }
    HeadlinePanel Plot { height: 1fr; min-height: 9; max-height: 30; margin-top: 1; display: none;
        border-top: solid $border-blurred; border-title-color: $foreground; }
    """

    def compose(self) -> Iterable[Widget]:
        """The sentence, the misses, the next step, and what all rockets share."""
        yield Static("", id="verdict")
        with Vertical(id="headline"):
            yield Static("", id="sentence")
            with Horizontal(id="misses"):
                for name in ("before", "after"):
                    with Vertical():
                        yield Static("", id=f"{name}-title")
                        yield Big(id=name)
            yield Static("", id="bars")
            yield Static("", id="step")
            yield Static("", id="also")
        yield Static("", id="fleet")
        yield Plot(id="each")

    def show_each(self, found: Sequence[FlightBesideOthers], system: str, *, searched: bool) -> None:
        """Draw the miss of every flight against the others of its rocket, after a search as its effects explain them;
        nothing for fewer than two."""
        missed = [(one.flight.flight_id, one.miss) for one in found if np.isfinite(one.miss)]
        plot = self.query_one("#each", Plot)
        plot.set_class(len(missed) > 1, "-shown")
        way = ", with what S found" if searched else ""
        plot.border_title = Content(f"Each flight beside the others{way} [{_unit(system)}]")
        plot.show(partial(draw_misses, missed, None, system) if len(missed) > 1 else None)

    def wait(self, text: Content | Hanging | str) -> None:
        """Show what a search would do, or how far it is."""
        self.remove_class("-found")
        self.query_one("#verdict", Static).update(text)

    def show(self, found: Findings, system: str, *, accepted: bool, odd: int) -> None:
        """Show the headline of findings, whether they were `accepted`, and how many single flights stand out."""
        one = headline(found, system)
        self.add_class("-found")
        self.query_one("#sentence", Static).update(Content(printable(one.sentence)))
        self._show_misses(one, system)
        rows = [
            Content.assemble(
                (f"{name:7}", "$text-muted"), (bar, "$accent" if name == "before" else "$success"), f" {value}"
            )
            for name, bar, value in compared_bars(one, BAR, system)
        ]
        self.query_one("#bars", Static).update(Content("\n").join(rows))
        step = Content.assemble(("Next  ", "b $primary"), printable(one.step), ("\n" + _answer(one, accepted), "b"))
        self.query_one("#step", Static).update(step)
        beside = [f"Also: {text}" for text in one.also]
        beside += [f"{odd} single flight{'s stand' if odd > 1 else ' stands'} out: see Flights"] * bool(odd)
        self.query_one("#also", Static).update(hanging([*beside, "→ for the evidence"]))

    def _show_misses(self, one: Headline, system: str) -> None:
        unit = _unit(system)
        worse = one.after is not None and one.after > one.before
        after = self.query_one("#after", Big)
        after.set_class(not worse, "-better")
        after.set_class(worse, "-worse")
        for name, value in (("before", one.before), ("after", one.after)):
            known = "" if value is None else number(cards.APOGEE, value, system)
            self.query_one(f"#{name}", Big).show(known)
            title = Content(f"mean miss {name} [{unit}]" if known else "")
            self.query_one(f"#{name}-title", Static).update(title)

    def show_fleet(self, lines: Sequence[str]) -> None:
        """Show what several rockets share."""
        heading = ["What your rockets share"] if lines else []
        self.query_one("#fleet", Static).update(hanging([*heading, *(f"  {line}" for line in lines)]))


def _unit(system: str) -> str:
    return spelled(unit_of(cards.APOGEE, system))


def _answer(one: Headline, accepted: bool) -> str:
    """The keys that answer the headline."""
    if accepted:
        return "Accepted: forecasts use it. u to undo"
    return "A to accept, D to decline" if one.after is not None else "Nothing to accept: forecasts stay as they are"


TEXT_BEFORE_RUN = {
    "verdict": "Press S to search for missing effects: each flight is forecast from the others, and the residuals are "
    "compared with those that known effects would cause. It takes a few seconds and changes nothing.",
    "against": "",
    "marks": "After S: the residual that an effect would cause in each readout, beside the one observed.",
}
"""The text in a panel before a search."""
ADDS = 2
"""The column of versions with the effects that they add. [1]"""
WIDE_RANKING = 70
"""Width from which the ranking has the evidence beside the chance. [cell]"""
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
    Panels #p-Versions Table { height: 1fr; min-height: 3; }
    Panels #p-Versions Static { margin-top: 1; }
    """

    def __init__(self) -> None:
        super().__init__(id="panels")
        self.found: Findings | None = None
        self._system, self._why, self._effect = "SI", "", 0
        self._tried: dict[str, Effect] = {}
        self.beside: Sequence[FlightBesideOthers] = ()
        """The flights of the rocket, each beside the others."""

    @property
    def headline(self) -> HeadlinePanel:
        """The first panel."""
        return self.query_one(HeadlinePanel)

    def compose(self) -> Iterable[Widget]:
        """One frame per panel."""
        yield HeadlinePanel(id="p-Verdict", classes="panel")
        yield SingleFlights(id="p-Flights", classes="panel")
        with Vertical(id="p-Versions", classes="panel"):
            yield Table(id="versions", enter="Use it")
            yield Static(id="adds")
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
        self.query_one("#residuals", Plot).show(None)
        self.query_one("#ranking", Table).show((), (), lambda _: ())

    def progress(self, text: str, done: float) -> None:
        """Show the current step and the fraction done."""
        if self.found is None or done < 1:
            bar = "█" * round(done * 24)
            self.headline.wait(Content(f"searching: {printable(text)}\n[{bar:24}]"))

    def show(self, found: Findings, system: str) -> None:
        """Show the findings."""
        self.found = found
        self.show_flights(found.flights or self.beside, system, searched=bool(found.flights))
        self.show_verdict(system)
        self.show_residuals(0, system)
        self.show_marks(0)

    def show_verdict(self, system: str, *, accepted: bool = False) -> None:
        """Show the verdict and the ranking, in these units, and whether the verdict was accepted."""
        if self.found is not None:
            self.headline.show(self.found, system, accepted=accepted, odd=len(odd_flights(self.beside)))
            self.query_one("#evidence", Static).update(verdict(self.found, system))
            self._system = system
            rows = ranking_rows(self.found.diagnosis, system)
            heads = [Head("effect", 0), Head("chance", 6, True), Head("evidence", 8, True), Head("strength", 16)]
            columns = range(len(heads)) if self._panel_width >= WIDE_RANKING else (0, 1, 3)
            shown = {row: [cells[n] for n in columns] for row, cells in rows.items()}
            self.query_one("#ranking", Table).show([heads[n] for n in columns], list(rows), shown.__getitem__)

    def show_flights(self, found: Sequence[FlightBesideOthers], system: str, *, searched: bool | None = None) -> None:
        """Show the flights beside the others of their rocket, after a search as its effects explain them; the same as
        before in other units if `searched` is None."""
        self.beside = found
        single = self.query_one(SingleFlights)
        single.found = found
        single.searched = single.searched if searched is None else searched
        single.show(found, system)
        self.headline.show_each(found, system, searched=single.searched)

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
            self.query_one("#marks", Static).update(fingerprint(self.found, turn, self._panel_width - PANEL_FRAME))

    @property
    def _panel_width(self) -> int:
        """Width of a panel. [cell]"""
        return self.size.width // 2 if self.screen.has_class("-wide") else self.size.width

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
            usable = sum(flight.clean and flight.apogee is not None for flight in standing.flights)
            few = f"A search needs {MIN_FLIGHTS} normal flights with an apogee; {standing.rocket} has {usable}."
            about = self._why or (printable(few) if usable < MIN_FLIGHTS else TEXT_BEFORE_RUN["verdict"])
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
        heads = [Head("no.", 3, True), Head("made", 10), Head("adds", 0), Head("held-out error", 17, True), Head("", 8)]
        self.query_one("#versions", Table).show(heads, list(rows), rows.__getitem__)
        self._show_added()

    @on(Table.Moved, "#versions")
    def _show_added(self) -> None:
        """Show in full what the version under the cursor adds, which its column may cut."""
        table = self.query_one("#versions", Table)
        added = table.cells(table.current)[ADDS] if table.current else ""
        text = f"Version {table.current} adds {added}" if added else ""
        self.query_one("#adds", Static).update(Content(text))

    def front(self, panel: int) -> Widget | None:
        """Bring a panel to the front; returns the widget for its keys, None if it needs none."""
        for row, name in enumerate(PANELS):
            self.query_one(f"#p-{name}").set_class(row == panel, "-front")
        name = PANELS[panel]
        self.set_class(name not in FRONT, "-under")
        if name == "Residuals":
            return None
        return self.query_one(
            {"Ranking": "#ranking", "Versions": "#versions", "Flights": "#odd"}.get(name, f"#p-{name}")
        )
