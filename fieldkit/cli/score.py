"""`fieldkit score`: the quality of the forecasts, on flights that they were not fitted to."""

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.completing import rocket_names
from fieldkit.cli.screen import AsJson, complain, print_json, print_table, progress, say, say_wrapped, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.errors import LedgerError
from fieldkit.quantities import ShownUnits

if TYPE_CHECKING:
    from fieldkit.forecast.evaluation.comparison import ScoreReport
    from fieldkit.services.scores import LedgerScores

app = typer.Typer()


@app.command()
def score(
    context: typer.Context,
    rocket: Annotated[
        str | None, typer.Option(help="Default: every rocket.", show_default=False, autocompletion=rocket_names)
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Also plot the calibration: .png, .svg, or .pdf.", show_default=False),
    ] = None,
    hyperprior: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Forecast with this hyperprior; nothing is saved.", hidden=True),
    ] = None,
    since: Annotated[
        datetime | None,
        typer.Option(
            formats=["%Y-%m-%d"],
            help="Leave out the forecasts of earlier flights, such as those with estimated altitudes.",
            show_default=False,
        ),
    ] = None,
    force: ForceOption = False,
    json: AsJson = False,
) -> None:
    """Score saved forecasts, and forecasts of each flight from the earlier ones, against simpler methods."""
    from fieldkit.services.scores import score_forecasts

    if out is not None:
        from fieldkit.presentation.report.score import check_picture

        check_picture(out)
        force = settled(out, force)
    with open_ledger(context) as ledger, progress("forecasting each flight from earlier ones") as on_progress:
        found = score_forecasts(
            ledger, known_motors(), rocket, hyperprior, on_progress, since=since.date() if since else None
        )
    if out is not None:
        from fieldkit.presentation.report.score import write_picture

        write_picture(found, out, force=force)
        complain(f"Wrote the calibration plot to {out}")
    if json:
        from fieldkit.presentation.json_documents import scores_document

        print_json(scores_document(found))
    else:
        _print_scores(found)
    if found.unsaved is not None:
        raise LedgerError(f"saving the forecasts failed: {found.unsaved}") from found.unsaved


def _print_scores(found: "LedgerScores") -> None:
    """Print saved forecasts, later flights and first flights, each if there are any, and the next forecast's
    weights."""
    from fieldkit.presentation.score_text import LEGEND, next_lines, titles

    for report, title in titles(found):
        say_wrapped(title)
        _print(report, placed=report is not found.first)
        say()
    for line in (*next_lines(found), LEGEND):
        say_wrapped(line)


def _print(found: "ScoreReport", *, placed: bool = True) -> None:
    """Print the scores of each method, the differences from each rival, the verdicts, and, with `placed`, the quantiles
    of the flights."""
    from fieldkit.presentation.score_text import (
        DIFFERENCE_HEADERS,
        DIFFERENCE_LEGEND,
        HEADERS,
        behind_the_bar,
        difference_rows,
        histogram,
        too_few,
        verdict_lines,
        way_rows,
    )

    print_table(HEADERS, way_rows(found), numbers=HEADERS[1:])
    say_wrapped(f"fieldkit's CRPS is {ShownUnits(system()).length(found.crps, 1)}")
    if few := too_few(found):
        say_wrapped(few)
    else:
        say()
        print_table(DIFFERENCE_HEADERS, difference_rows(found), numbers=DIFFERENCE_HEADERS[1:])
        say_wrapped(DIFFERENCE_LEGEND)
        for line in (*verdict_lines(found), *behind_the_bar(found)):
            say_wrapped(line, "  ")
    if not placed:
        return
    say()
    for line in histogram(found.calibration):
        say_wrapped(line)
