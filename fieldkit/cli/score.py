"""`fieldkit score`: how good the forecasts are, on flights that came after what they rest on."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.completing import rocket_names
from fieldkit.cli.screen import complain, print_json, print_table, progress, say, say_wrapped
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.cli.targets import Force, settled

if TYPE_CHECKING:
    from fieldkit.forecast.evaluation.comparison import ScoreReport

app = typer.Typer()


@app.command()
def score(
    context: typer.Context,
    rocket: Annotated[
        str | None, typer.Option(help="By default every rocket.", show_default=False, autocompletion=rocket_names)
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw the calibration too: .png, .svg or .pdf.", show_default=False),
    ] = None,
    hyperprior: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Forecast with this hyperprior; nothing is kept.", hidden=True),
    ] = None,
    force: Force = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Score the predictions made before flights, and forecasts of each flight from those before it, against rivals."""
    from fieldkit.errors import NoFlights
    from fieldkit.forecast.evaluation.comparison import judged_report
    from fieldkit.forecast.evaluation.forward_in_time import corrected_coverage, next_weights
    from fieldkit.forecast.evaluation.rivals import LABELS
    from fieldkit.presentation.json_documents import finite, replayed_document, saved_forecasts_document
    from fieldkit.services.forecasts import keep_forecasts, which_rocket
    from fieldkit.services.saved_forecasts import list_forecasts
    from fieldkit.services.track_record import read_hyperprior, record, replayed

    if out is not None:
        from fieldkit.presentation.report.score import check_picture

        check_picture(out)
        force = settled(out, force)
    other = read_hyperprior(hyperprior) if hyperprior else None
    with open_ledger(context) as ledger, progress("forecasting each flight from the ones before") as on_progress:
        motors = known_motors()
        name = which_rocket(ledger, rocket) if rocket else None
        made = [one for one in list_forecasts(ledger, motors) if name in (None, one.made.rocket)]
        before = record(ledger, motors, made)
        rows = replayed(ledger, motors, name, hyperprior=other, on_progress=on_progress)
        if other is None:
            keep_forecasts(ledger, rows)
    if not rows:
        raise NoFlights("found no clean flight with an apogee and a dry mass, expected at least one")
    later, first = (judged_report([row for row in rows if bool(row.earlier) == known]) for known in (True, False))
    said = judged_report(before) if before else None
    if out is not None:
        from fieldkit.presentation.report.score import write_picture

        pictures = {"kept predictions": said, "replayed forward in time": later, "first flights": first}
        write_picture({title: report for title, report in pictures.items() if report and report.rows}, out, force=force)
        complain(f"calibration drawn to {out}")
    weights = next_weights(rows)
    if json:
        stale = sum(one.stale for one in made if one.flown is not None)
        document = replayed_document(later, first, weights)
        print_json(finite({**document, "kept": None if said is None else saved_forecasts_document(said, stale)}))
        return
    if said is not None:
        say_wrapped(f"Predictions kept, made before the flight: {len(said.rows)} flown and clean")
        _print(said)
        say()
    if later.rows:
        say_wrapped(
            f"Replayed forward in time: {len(later.rows)} flights, each forecast from the earlier ones of its rocket "
            "and of all others"
        )
        _print(later)
        say()
    if first.rows:
        say_wrapped(
            f"First flights of a rocket: {len(first.rows)}, each forecast from those of other rockets before it"
        )
        _print(first, placed=False)
        say()
    if corrected := corrected_coverage(rows):
        say_wrapped(
            f"Intervals of the last {corrected['flights']} corrected by how the ones before fared would hold "
            f"{corrected['coverage90']:.0%}, without correction {corrected['own_coverage90']:.0%}."
        )
    parts = ", ".join(f"{weight:.0%} {LABELS.get(way, way)}" for way, weight in weights.items() if weight)
    say_wrapped(f"The next flight stacked would be {parts}.")


def _print(found: "ScoreReport", *, placed: bool = True) -> None:
    """Scores of each way, the difference to each rival, the verdicts, and where flights lay in their forecasts."""
    from fieldkit.presentation.score_text import (
        DIFFERENCES,
        WAYS,
        against_the_bar,
        difference_rows,
        histogram,
        verdict_lines,
        way_rows,
    )

    print_table(WAYS, way_rows(found), numbers=WAYS[1:])
    say_wrapped(f"all in percent of the apogee flown; fieldkit's CRPS is {found.crps:.1f} m")
    say()
    print_table(DIFFERENCES, difference_rows(found), numbers=DIFFERENCES[1:])
    say_wrapped("90 % bootstrap intervals in percent of the apogee flown, * where zero is outside")
    for line in (*verdict_lines(found), *against_the_bar(found)):
        say_wrapped(line, "  ")
    if not placed:
        return
    say()
    for line in histogram(found.calibration):
        say_wrapped(line)
