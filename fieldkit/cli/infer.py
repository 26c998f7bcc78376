"""`fieldkit infer`: drag and thrust of flights that were flown."""

from enum import StrEnum
from typing import Annotated

import typer

from fieldkit.cli.completing import flight_ids
from fieldkit.cli.screen import AsJson, complain, measured, print_json, print_table, progress, say_wrapped, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.errors import NoFlights
from fieldkit.quantities import in_system

app = typer.Typer()


class InferenceName(StrEnum):
    """The forecast model, or the reference paper's network."""

    field = "field"
    paper = "paper"


@app.command()
def infer(
    context: typer.Context,
    flights: Annotated[
        list[str] | None,
        typer.Argument(metavar="FLIGHT...", help="Default: all.", show_default=False, autocompletion=flight_ids),
    ] = None,
    model: Annotated[InferenceName, typer.Option(help="The model to use.")] = InferenceName.field,
    json: AsJson = False,
) -> None:
    """Estimate drag (Cd) and the thrust factor (alpha, 1 as certified) from each flight."""
    from fieldkit.services.inferred import infer_flights

    with open_ledger(context) as ledger, progress("inferring") as on_progress:
        found = infer_flights(ledger, known_motors(), flights or [], model.value, on_progress)
    for line in found.left_out:
        complain(f"left out: {in_system(line, system())}")
    if not found.inferred:
        raise NoFlights("no flight could be used for inference")
    if json:
        print_json({"flights": [one.json() for one in found.inferred]})
        return
    for warning, ids in found.warnings():
        complain(f"note: flight{'s' if len(ids) > 1 else ''} {', '.join(ids)}: {in_system(warning, system())}")
    headers = ("flight", "motor", "apogee", "Cd", "±", "thrust", "±")
    rows = [
        (
            id,
            one.flight.motor,
            measured("apogee", one.flight.apogee),
            *("" if figure is None else f"{figure:.3f}" for figure in (one.cd, one.cd_sd)),
            f"{one.alpha:.3f}",
            f"{one.alpha_sd:.3f}",
        )
        for id, one in zip(found.ids, found.inferred, strict=True)
    ]
    print_table(headers, rows, numbers=headers[2:])
    if model is InferenceName.field:
        say_wrapped(
            "Provisional, from each flight alone: half of the Cd are off by more than a tenth, either way; `fieldkit "
            "predict` fits a rocket's flights together"
        )
