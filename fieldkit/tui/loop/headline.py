"""The front of the Loop page: one sentence, the miss before and after in large digits with bars, one next step."""

from collections.abc import Iterable, Sequence

from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.presentation.loop_headline import Headline, compared_bars, headline
from fieldkit.quantities import number, spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.services.findings import Findings
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import Hanging, hanging

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
        unit = spelled(unit_of(cards.APOGEE, system))
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


def _answer(one: Headline, accepted: bool) -> str:
    """The keys that answer the headline."""
    if accepted:
        return "Accepted: forecasts use it. u to undo"
    return "A to accept, D to decline" if one.after is not None else "Nothing to accept: forecasts stay as they are"
