"""`fieldkit sites`: the fields that are flown at."""

from typing import Annotated

import typer

from fieldkit.cli.planning import length
from fieldkit.cli.screen import print_json, print_table
from fieldkit.cli.session import open_ledger

app = typer.Typer()


@app.command()
def sites(
    context: typer.Context,
    name: Annotated[str | None, typer.Argument(help="The site to save what follows of.")] = None,
    elevation: Annotated[str | None, typer.Option(help="Of the pad above sea level: 212m.")] = None,
    size: Annotated[str | None, typer.Option(help="The field's shorter side: 400m.")] = None,
    ceiling: Annotated[str | None, typer.Option(help="Above the pad, by waiver or rule: 3000ft.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List launch sites, or save the elevation, size and ceiling of one."""
    from fieldkit.ledger.sites import keep_site
    from fieldkit.ledger.sites import sites as sites_of

    given = {"elevation": length(elevation, signed=True), "size": length(size), "ceiling": length(ceiling)}
    if name is None and any(value is not None for value in given.values()):
        raise typer.BadParameter("found what to save and no site, expected its name first")
    with open_ledger(context) as ledger:
        if name is not None and any(value is not None for value in given.values()):
            keep_site(ledger, name, **given)
        known = [site for site in sites_of(ledger) if name in (None, site.name)]
    if json:
        keys = ("elevation", "size", "ceiling")
        print_json({"sites": [{"site": one.name} | {f"{key}_m": getattr(one, key) for key in keys} for one in known]})
        return
    rows = [
        (one.name, *("" if value is None else f"{value:.0f}" for value in (one.elevation, one.size, one.ceiling)))
        for one in known
    ]
    headers = ("site", "elevation m", "size m", "ceiling m")
    print_table(headers, rows, numbers=headers[1:])
