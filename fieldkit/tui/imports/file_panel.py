"""A file on the Import page of a large screen: the climb in a log, and how the file was read."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from textual.containers import Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.quantities import spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import stacked

if TYPE_CHECKING:
    from fieldkit.services.imports import Receipt


class FilePanel(Vertical):
    """The height against time, if the file is a log, and below it the parser and the columns."""

    DEFAULT_CSS = """
    FilePanel { height: auto; display: none; }
    FilePanel Plot { height: 30vh; border-top: solid $border-blurred; border-title-color: $foreground; }
    FilePanel Static { height: auto; margin: 1 0; }
    """

    def compose(self) -> Iterable[Widget]:
        """The plot, the facts."""
        from fieldkit.tui.widgets.plots import Plot

        yield Plot()
        yield Static("")

    def show(self, receipt: "Receipt | None", system: str) -> None:
        """Show the only file of a receipt, in the units of a system; without one, nothing."""
        from fieldkit.tui.flights.log_view import draw_height, file_facts
        from fieldkit.tui.widgets.plots import Plot

        files = receipt.files if receipt is not None else ()
        self.set_class(len(files) == 1, "-read")
        if len(files) != 1:
            return
        (file,) = files
        plot = self.query_one(Plot)
        shown = next((one for one in file.shown if one.curve is not None), None)
        plot.display = shown is not None
        if shown is not None and shown.curve is not None:
            unit = spelled(unit_of(cards.APOGEE, system))
            plot.border_title = Content(printable(f"Height of {shown.flight.flight_id} [{unit}]"))
            plot.show(draw_height(shown.curve, system))
        self.query_one(Static).update(stacked(file_facts(file, system)))
