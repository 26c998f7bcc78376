"""The rocket of a flight in a strip across the page: what it looks like, what it flew on, and how high."""

from typing import TYPE_CHECKING

from textual.containers import Horizontal
from textual.content import Content
from textual.css.styles import RulesMap
from textual.widgets import Static

from fieldkit.safe_text import printable
from fieldkit.tui.resources import IMPORTING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldkit.flight import Flight
    from fieldkit.tui.resources import Resources
    from fieldkit.tui.setup.setup_card import Facts
    from fieldkit.tui.widgets.hanging import Hanging


def rocket_facts(resources: "Resources", flight: "Flight") -> "Facts | None":
    """What the strip shows of the rocket of a flight; None for a flight without a rocket.

    A worker reads it, and imports what reads and draws it: 0.17 s of processor time after the ledger is open.
    """
    with IMPORTING:
        from fieldkit.tui.setup.setup_card import of_build
        from fieldkit.tui.widgets.groups import rocket_of

    rocket = rocket_of(resources.ledger, flight)
    return None if rocket is None else of_build(rocket[0], resources.settings.units, rocket[1], resources.motors)


class WholeBlocks(Static):
    """As many blocks of lines as there is room for, and none in part: nothing here can be scrolled."""

    _blocks: "Sequence[Hanging]" = ()

    def show(self, blocks: "Sequence[Hanging]") -> None:
        """Show the first of these blocks that fit."""
        self._blocks = blocks
        self._fit()

    def on_resize(self) -> None:
        """Show those that fit now."""
        self._fit()

    def _fit(self) -> None:
        from fieldkit.tui.widgets.hanging import stacked  # imported with the facts

        fitting, (width, height) = list(self._blocks), self.content_size
        while width and fitting and stacked(fitting).get_height(RulesMap(), width) > height:
            fitting.pop()
        self.update(stacked(fitting), layout=False)


class RocketStrip(Horizontal):
    """Facts on the left, apogees on the right; shown by pages with room for it if there is a rocket (`-shown`). What
    it shows is mounted when there is something to show, so that the first paint does not wait for it."""

    DEFAULT_CSS = """
    RocketStrip { height: 40vh; max-height: 24; display: none; margin: 0 1; border-top: solid $border-blurred;
        border-title-color: $foreground; border-title-align: right; }
    RocketStrip #rocket { width: 62; height: 1fr; padding: 0 1; }
    RocketStrip Static { height: auto; }
    RocketStrip Plot { width: 1fr; height: 1fr; }
    """

    def show(self, facts: "Facts | None") -> None:
        """Show the flights of a rocket, and its design if known; None to hide the strip."""
        self.set_class(facts is not None, "-shown")
        if facts is None:
            return
        from fieldkit.tui.widgets.plots import draw_in  # before the first paint it would take 0.1 s

        text = next(iter(self.query(WholeBlocks)), None)
        if text is None:
            text = WholeBlocks(id="rocket")
            self.mount(text)
        text.show(facts.blocks)
        draw_in(self, facts.draw)
        self.border_title = Content(printable(facts.title)) if facts.draw is not None else ""
