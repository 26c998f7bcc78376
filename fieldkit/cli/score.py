"""`fieldkit score`: how good the forecasts are, on flights that came after what they rest on."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit.cli.screen import print_json, print_table, progress, say
from fieldkit.cli.session import known_motors, open_ledger

if TYPE_CHECKING:
    from fieldkit.loop.forward import Forecast

app = typer.Typer()


@app.command()
def score(
    context: typer.Context,
    rocket: Annotated[str | None, typer.Option(help="By default every rocket.", show_default=False)] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Forecast each flight from the ones before it, and compare with three simpler ways."""
    from dataclasses import asdict

    from fieldkit.errors import NoFlights
    from fieldkit.loop.desk import flown, keep_forecasts, which_rocket
    from fieldkit.loop.forward import corrected_by_earlier, forward, tally

    with open_ledger(context) as ledger, progress("forecasting each flight from the ones before") as tell:
        motors = known_motors()
        rockets = [which_rocket(ledger, rocket)] if rocket else ledger.names("rocket")
        rows = [row for name in rockets for row in forward(name, flown(ledger, motors, name), tell=tell)]
        rows = corrected_by_earlier(rows)
        keep_forecasts(ledger, rows)
    if not rows:
        raise NoFlights("found no rocket with two clean flights that have an apogee, expected at least one")
    ways, inside = tally(rows)
    if json:
        print_json(
            {
                "flights": [_document(row) for row in rows],
                "errors": [asdict(way) for way in ways],
                "coverage90": inside,
                "corrected": _corrected(rows),
                "evaluation": "forward in time: each flight from the earlier ones of its rocket",
            }
        )
        return
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
    say(f"{len(rows)} flights, each forecast from the earlier ones of its rocket; {inside:.0%} in the 90 % interval")
    if corrected := _corrected(rows):
        say(
            f"the intervals of the last {corrected['flights']} are corrected by how the ones before fared: "
            f"{corrected['coverage90']:.0%} inside, {corrected['own_coverage90']:.0%} without"
        )


def _document(row: "Forecast") -> dict[str, Any]:
    from dataclasses import asdict

    numbers = {key: None if value != value else value for key, value in asdict(row).items()}
    return {**numbers, "when": row.when.isoformat() if row.when else None}


def _corrected(rows: "Sequence[Forecast]") -> dict[str, Any] | None:
    """Coverage of the intervals that earlier flights corrected, and of the model's own for the same flights."""
    later = [row for row in rows if row.corrected]
    if not later:
        return None
    own = [row.p05 <= row.flown <= row.p95 for row in later]
    shares = {"coverage90": sum(row.inside for row in later) / len(later), "own_coverage90": sum(own) / len(later)}
    return {"flights": len(later), **shares, "last_stretch": later[-1].stretch}
