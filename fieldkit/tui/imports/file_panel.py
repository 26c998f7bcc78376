"""The contents of a file on the Import page; on a large screen also the climb in a log, and how the file was read."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from textual.containers import Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.quantities import spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.tui.flights.log_view import draw_height, file_facts
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import stacked
from fieldkit.tui.widgets.plots import Plot

if TYPE_CHECKING:
    from fieldkit.services.imports import Receipt


class FilePanel(Vertical):
    """What is in a file; on a large screen above it the height against time, if it is a log, and below it the parser
    and the columns."""

    DEFAULT_CSS = """
    FilePanel, FilePanel Static { height: auto; }
    FilePanel .-large-only { display: none; }
    FilePanel Plot { height: 30vh; margin-bottom: 1; border-top: solid $border-blurred;
        border-title-color: $foreground; }
    FilePanel #how { margin-top: 1; }
    """

    def compose(self) -> Iterable[Widget]:
        """The plot, the contents, the facts."""

        yield Plot(classes="-large-only")
        yield Static("", id="more")
        yield Static("", id="how", classes="-large-only")

    def show(self, receipt: "Receipt | None", system: str) -> None:
        """Show the climb and the facts of the only file of a receipt, in the units of a system, else neither."""

        files = receipt.files if receipt is not None else ()
        file = files[0] if len(files) == 1 else None
        shown = next((one for one in file.shown if one.curve is not None), None) if file is not None else None
        plot, how = self.query_one(Plot), self.query_one("#how", Static)
        plot.set_class(shown is not None, "-filled")
        how.set_class(file is not None, "-filled")
        if shown is not None and shown.curve is not None:
            unit = spelled(unit_of(cards.APOGEE, system))
            plot.border_title = Content(printable(f"Height of {shown.flight.flight_id} [{unit}]"))
            plot.show(draw_height(shown.curve, system))
        if file is not None:
            how.update(stacked(file_facts(file, system)))
