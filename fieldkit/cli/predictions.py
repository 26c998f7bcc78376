"""`fieldkit predictions`: saved forecasts, their outcome, and what has changed since."""

from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.screen import AsJson, complain, print_json, print_table, say, say_wrapped, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.quantities import ShownUnits

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.ledger import Ledger
    from fieldkit.services.saved_forecasts import SavedForecast

app = typer.Typer()


@app.command()
def predictions(
    context: typer.Context,
    rocket: Annotated[str | None, typer.Option(help="Forecasts of this rocket only.", show_default=False)] = None,
    every: Annotated[
        bool, typer.Option("--all", help="Include forecasts that were replaced or that expired without a flight.")
    ] = False,
    json: AsJson = False,
) -> None:
    """List saved forecasts: open, stale (with the reason), and flown."""
    from fieldkit.services.forecasts import which_rocket
    from fieldkit.services.saved_forecasts import LISTED_STATES, list_forecasts, standing

    with open_ledger(context) as ledger:
        name = which_rocket(ledger, rocket) if rocket else None
        found = list_forecasts(ledger, known_motors(), name)
        where = ledger.name
    shown = [one for one in found if every or one.state in LISTED_STATES]
    if json:
        print_json({"predictions": [one.json() for one in shown]})
        return
    if not found:
        complain(f"No forecasts saved in {where} yet; `fieldkit predict` saves one")
        return
    units = ShownUnits(system())
    apogee = f"apogee {units.length_unit}"
    headers = ["no.", "made", "flight", "motor", apogee, "90%", "flown", "miss", ""]
    rows = [_cells(one, units) for one in shown]
    builds = [f"{one.made.rocket} {one.made.payload.get('config', '')}".strip() for one in shown]
    if len(set(builds)) > 1:
        headers.insert(2, "rocket")
        rows = [[*row[:2], build, *row[2:]] for row, build in zip(rows, builds, strict=True)]
    print_table(headers, rows, numbers=["no.", "made", apogee, "90%", "flown", "miss"])
    for one in shown:
        if one.stale:
            say_wrapped(f"  {one.made.number}: {'; '.join(one.changes_in(units.system))}", "   ")
    say(standing(found))


def _cells(one: "SavedForecast", units: "ShownUnits") -> list[str]:
    low, middle, high = (units.length(height).split()[0] for height in one.interval)
    payload = one.made.payload
    flight = one.flight.flight_id if one.flight else one.made.flight_id
    return [
        str(one.made.number),
        f"{one.made.at.astimezone():%Y-%m-%d}",
        flight,
        str(payload.get("motor", "")),
        middle,
        f"{low}-{high}",
        "" if one.flown is None else units.length(one.flown, 1).split()[0],
        "" if one.miss is None else units.difference(one.miss).split()[0],
        "stale" if one.stale else one.state,
    ]


def prediction_of(ledger: "Ledger", flight: "Flight") -> "SavedForecast | None":
    """The forecast that a flight is compared with, or None."""
    if not ledger.predictions(flight.rocket):
        return None
    from fieldkit.services.saved_forecasts import of_flight

    return of_flight(ledger, known_motors(), flight)


def print_prediction(forecast: "SavedForecast | None") -> None:
    """Print the forecast of a flight and its flown apogee, if there is a forecast."""
    if forecast is None:
        return
    from fieldkit.services.saved_forecasts import in_words

    first, *others = in_words(forecast, system())
    say_wrapped(f"Forecast    {first}", " " * 12)
    for line in others:
        say_wrapped(f"{'':12}{line}")


def print_outcome(ledger: "Ledger", flight: "Flight") -> None:
    """Print how a new flight compares with its forecast, and the next one; if none can be made, the saved one."""
    from fieldkit.presentation.after_flight_text import outcome_lines
    from fieldkit.services.after_flight import outcome

    saved, found = prediction_of(ledger, flight), outcome(ledger, known_motors(), flight)
    if found is None:
        print_prediction(saved)
        return
    say_wrapped(" ".join(outcome_lines(found, system())))
    if saved is not None and saved.stale:
        say_wrapped(f"The forecast was stale: {'; '.join(saved.changes_in(system()))}.")
