"""`fieldkit report`: a flight card, a day or a rocket as pages for the log book."""

from pathlib import Path
from typing import Annotated

import typer

from fieldkit.cli.screen import complain, progress, say, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.progress import part
from fieldkit.quantities import counted

app = typer.Typer()
LAST_FLIGHTS = 60
"""Number of flights in the report of a rocket or a day unless the user wants more: each has a page. [1]"""


@app.command()
def report(
    context: typer.Context,
    what: Annotated[
        str,
        typer.Argument(metavar="FLIGHT|ROCKET|DAY", help="Flight id, rocket, or day such as 2026-05-01."),
    ],
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="File to write; ends in .html, .pdf, .png, or .md.", show_default=False)
    ],
    last: Annotated[
        int, typer.Option(help="So many flights of a rocket or a day, the latest ones.", min=1)
    ] = LAST_FLIGHTS,
    force: ForceOption = False,
) -> None:
    """Write a report for the log book: a flight, a day, or a rocket with the loop's result."""
    from fieldkit.presentation.report.book import book
    from fieldkit.presentation.report.write import check_report, write_report

    check_report(out)
    force = settled(out, force)
    with open_ledger(context) as ledger, progress("report") as on_progress:
        made = book(ledger, known_motors(), what, part(on_progress, 0.0, 0.6), system(), last)
        files = write_report(made, out, part(on_progress, 0.6, 0.4), force=force)
    if made.earlier:
        complain(f"note: without {counted(made.earlier, 'earlier flight')}; --last {last + made.earlier} for all")
    say(f"Wrote {made.title} to {', '.join(str(file) for file in files[:3])}{' and more' if len(files) > 3 else ''}")
