"""`fieldkit score`: how good the forecasts are, on flights that came after what they rest on."""

from typing import Annotated

import typer

from fieldkit.cli.screen import print_json, print_table, progress, say
from fieldkit.cli.session import known_motors, open_ledger

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
    from fieldkit.loop.desk import flown, which_rocket
    from fieldkit.loop.forward import forward, tally

    with open_ledger(context) as ledger, progress("forecasting each flight from the ones before") as tell:
        motors = known_motors()
        rockets = [which_rocket(ledger, rocket)] if rocket else ledger.names("rocket")
        rows = [row for name in rockets for row in forward(name, flown(ledger, motors, name), tell=tell)]
    if not rows:
        raise NoFlights("found no rocket with two clean flights that have an apogee, expected at least one")
    ways, inside = tally(rows)
    if json:
        print_json(
            {
                "flights": [asdict(row) for row in rows],
                "errors": [asdict(way) for way in ways],
                "coverage90": inside,
                "evaluation": "forward in time: each flight from the earlier ones of its rocket",
            }
        )
        return
    cells = [
        (way.name, f"{way.median_share:.1%}", f"{way.mean_share:.1%}", f"{way.mae:.1f}", f"{way.bias:+.1f}")
        for way in ways
    ]
    numbers = ("median", "mean", "MAE m", "bias m")
    print_table(("forecast by", *numbers), cells, numbers=numbers)
    say(f"{len(rows)} flights, each forecast from the earlier ones of its rocket; {inside:.0%} in the 90 % interval")
