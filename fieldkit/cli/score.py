"""`fieldkit score`: how good the forecasts are, on flights that came after what they rest on."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.completing import rocket_names
from fieldkit.cli.screen import complain, print_json, print_table, progress, say, say_wrapped
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.cli.targets import Force, settled

if TYPE_CHECKING:
    from fieldkit.forecast.evaluation.rivals import Report

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
    force: Force = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Score the predictions made before flights, and forecasts of each flight from those before it, against rivals."""
    from fieldkit.errors import NoFlights
    from fieldkit.forecast.evaluation.forward_in_time import corrected_by_earlier, corrected_shares, forward
    from fieldkit.forecast.evaluation.rivals import judged_report
    from fieldkit.presentation.json_documents import finite, kept_document, score_document
    from fieldkit.services.forecasts import flown, keep_forecasts, which_rocket
    from fieldkit.services.saved_forecasts import kept
    from fieldkit.services.track_record import record

    if out is not None:
        from fieldkit.presentation.report.score import check_picture

        check_picture(out)
        force = settled(out, force)
    with open_ledger(context) as ledger, progress("forecasting each flight from the ones before") as tell:
        motors = known_motors()
        rockets = [which_rocket(ledger, rocket)] if rocket else ledger.names("rocket")
        made = [one for name in rockets for one in kept(ledger, motors, name)]
        before = record(ledger, motors, made)
        rows = [row for name in rockets for row in forward(name, flown(ledger, motors, name), tell=tell)]
        rows = corrected_by_earlier(rows)
        keep_forecasts(ledger, rows)
    if not rows:
        raise NoFlights("found no rocket with two clean flights that have an apogee, expected at least one")
    replayed, said = judged_report(rows), judged_report(before) if before else None
    if out is not None:
        from fieldkit.presentation.report.score import write_picture

        write_picture({"kept predictions": said, "replayed forward in time": replayed}, out, force=force)
        complain(f"calibration drawn to {out}")
    if json:
        stale = sum(one.stale for one in made if one.flown is not None)
        print_json(finite({**score_document(replayed), "kept": None if said is None else kept_document(said, stale)}))
        return
    if said is not None:
        say_wrapped(f"Predictions kept, made before the flight: {len(said.rows)} flown and clean")
        _print(said)
        say()
    say_wrapped(f"Replayed forward in time: {len(rows)} flights, each forecast from the earlier ones of its rocket")
    _print(replayed)
    if corrected := corrected_shares(replayed.rows):
        say_wrapped(
            f"the intervals of the last {corrected['flights']} are corrected by how the ones before fared: "
            f"{corrected['coverage90']:.0%} inside, {corrected['own_coverage90']:.0%} without"
        )


def _print(found: "Report") -> None:
    """Errors by each way, the difference to each rival, the verdict on the bar, and calibration."""
    from fieldkit.forecast.evaluation.forward_in_time import tally
    from fieldkit.forecast.evaluation.rivals import RIVALS
    from fieldkit.presentation.score_text import against_the_bar, histogram

    ways, inside = tally(found.rows)
    cells = [
        (
            way.name,
            str(way.flights),
            f"{way.median_share:.1%}",
            f"{way.mean_share:.1%}",
            f"{way.mae:.1f}",
            f"{way.bias:+.1f}",
        )
        for way in ways
    ]
    numbers = ("flights", "median", "mean", "MAE m", "bias m")
    print_table(("forecast by", *numbers), cells, numbers=numbers)
    say(f"{inside:.0%} in the 90 % interval; CRPS {found.crps:.1f} m")
    say()
    heads = ("rival", "our mean error is less by", "our CRPS is less by m", "")
    rivals = [
        (
            RIVALS[one.rival],
            "{:+.1%} ({:+.1%} to {:+.1%})".format(one.less, *one.interval),
            "{:+.1f} ({:+.1f} to {:+.1f})".format(one.crps_less, *one.crps_interval),
            one.verdict,
        )
        for one in found.against
    ]
    print_table(heads, rivals, numbers=heads[1:3])
    for line in against_the_bar(found):
        say_wrapped(line, "  ")
    say()
    for line in histogram(found.calibration):
        say_wrapped(line)
