"""`fieldkit sites`: launch sites."""

from collections.abc import Sequence
from typing import Annotated

import typer

from fieldkit.cli.numbers import length
from fieldkit.cli.planning import check_rules
from fieldkit.cli.screen import AsJson, complain, print_json, print_table, system
from fieldkit.cli.session import open_ledger
from fieldkit.errors import BadValue, unknown
from fieldkit.flight.site import SITE_LENGTHS, Site
from fieldkit.quantities import ShownUnits

app = typer.Typer()


@app.command()
def sites(
    context: typer.Context,
    name: Annotated[str | None, typer.Argument(help="Name of the site to save.")] = None,
    elevation: Annotated[str | None, typer.Option(help="Elevation of the pad above sea level: 212m, 700ft.")] = None,
    size: Annotated[
        str | None, typer.Option("--size", "--field-size", help="Shorter side of the field: 400m, 1300ft.")
    ] = None,
    ceiling: Annotated[str | None, typer.Option(help="Ceiling above the pad, by waiver or rule: 900m, 3000ft.")] = None,
    people: Annotated[
        str | None, typer.Option(help="Distance from the pad to the people at the launch: 30m, 100ft.")
    ] = None,
    bystanders: Annotated[
        str | None,
        typer.Option(help="Distance from the pad to people and property not involved in the launch: 500m, 1500ft."),
    ] = None,
    rules: Annotated[str | None, typer.Option(help="Rules that govern it: NAR,FAA or UKRA.")] = None,
    json: AsJson = False,
) -> None:
    """List launch sites, or save one with elevation, size, ceiling, distances, and rules."""
    from fieldkit.services.sites import keep_site
    from fieldkit.services.sites import sites as sites_of

    given = {"elevation": length("--elevation", elevation, signed=True), "size": length("--size", size)}
    given |= {"ceiling": length("--ceiling", ceiling), "people": length("--people", people)}
    given["bystanders"] = length("--bystanders", bystanders)
    if rules is not None:
        check_rules(rules)
    changed = rules is not None or any(value is not None for value in given.values())
    if name is None and changed:
        raise typer.BadParameter("found values and no site, expected its name first")
    with open_ledger(context) as ledger:
        if name is not None and changed:
            keep_site(ledger, name, rules=rules, **given)
        known = _named(sites_of(ledger), name)
    if json:
        lengths = [{f"{key}_m": getattr(one, key) for key in SITE_LENGTHS} for one in known]
        names = [{"site": one.name, "rules": one.rules} for one in known]
        print_json({"sites": [name | own for name, own in zip(names, lengths, strict=True)]})
        return
    if not known:
        complain("No sites yet; `fieldkit sites NAME --elevation 212m` saves one")
        return
    shown = ShownUnits(system())
    rows = [
        (
            one.name,
            *("" if (value := getattr(one, key)) is None else shown.length(value).split()[0] for key in SITE_LENGTHS),
            one.rules,
        )
        for one in known
    ]
    headers = ("site", *(f"{key} {shown.length_unit}" for key in SITE_LENGTHS), "rules")
    print_table(headers, rows, numbers=headers[1:6])


def _named(known: "Sequence[Site]", name: str | None) -> "Sequence[Site]":
    """The site with a name, or all without one. Raises BadValue that suggests the nearest."""
    found = [site for site in known if name in (None, site.name)]
    if name is not None and not found:
        raise BadValue(f"{unknown('site', name, (site.name for site in known))} --elevation 212m saves a new one")
    return found
