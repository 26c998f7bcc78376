"""`fieldkit weather`: the weather of flights, flown or planned, from saved files."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit import files
from fieldkit.cli.completing import rocket_names
from fieldkit.cli.screen import AsJson, complain, print_json, print_table, say, system
from fieldkit.cli.session import MotorCheck, open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.flight import BY_NAME
from fieldkit.flight.short_name import short_name
from fieldkit.quantities import ShownUnits, counted, spelled, unit_of, with_sd
from fieldkit.units import unit

if TYPE_CHECKING:
    from fieldkit.services.weather import FilledIn

app = typer.Typer()
MOST_DAMAGED_ROWS = 5
"""Number of damaged rows that are printed; the others are counted. [1]"""


@app.command()
def weather(
    context: typer.Context,
    saved: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="Saved weather of one place: Open-Meteo, Meteostat, METAR lines, winds aloft, or a table with units.",
            show_default=False,
        ),
    ],
    site: Annotated[str | None, typer.Option(help="Only flights at this site.", show_default=False)] = None,
    rocket: Annotated[
        str | None, typer.Option(help="Only flights of this rocket.", autocompletion=rocket_names, show_default=False)
    ] = None,
    timezone: Annotated[
        str | None,
        typer.Option(
            metavar="ZONE", help="Zone of the flights, for files in UTC: America/Chicago, -5.", show_default=False
        ),
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Also replace weather that is recorded.")] = False,
    plans: Annotated[
        Path | None, typer.Option(help="Fill in a table of planned flights instead; needs --out.", show_default=False)
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The completed table of --plans.", show_default=False)
    ] = None,
    look: Annotated[bool, typer.Option("--dry-run", help="Show the weather without saving it.")] = False,
    force: ForceOption = False,
    json: AsJson = False,
) -> None:
    """Fill in the weather of flights by date, hour and site from saved weather files, each value with its standard
    deviation. Can be undone."""
    from fieldkit.importing.read import read_plans
    from fieldkit.importing.weather import read_weather
    from fieldkit.presentation.export import csv_table
    from fieldkit.services.imports import read_file
    from fieldkit.services.weather import NamedWeather, fill_ledger, filled, flights_to_fill, read_zone

    if (plans is None) != (out is None):
        raise typer.BadParameter("found --plans or --out alone, expected both: --plans plans.csv --out filled.csv")
    zone = read_zone(timezone) if timezone else None
    if plans is None:
        with open_ledger(context) as ledger:
            flights = flights_to_fill(ledger, site, rocket)
    sources, formats = [], []
    for file in saved:
        format, one = read_weather(read_file(file, kind="weather"), file.name)
        sources.append(NamedWeather(file.name, one))
        formats.append({"file": file.name, "format": format, "reports": len(one.reports)})
    rejected = [bad for one in sources for bad in one.weather.rejected]
    if plans is not None and out is not None:
        force = settled(out, force)
        table = read_plans(read_file(plans), plans.name, MotorCheck())
        found = [filled(one, sources, zone, replace=replace) for one in table if site in (None, one.site)]
        files.write(out, csv_table([one.after for one in found]).encode(), force=force)
    else:
        with open_ledger(context) as ledger:
            found = fill_ledger(ledger, flights, sources, zone, replace=replace, dry_run=look)
    if json:
        print_json(
            {
                "files": formats,
                "rejected": [
                    {"file": one.source, "row": one.row, "column": one.column, "error": one.found} for one in rejected
                ],
                "flights": [_document(one) for one in found],
            }
        )
        return
    _print(found)
    for bad in rejected[:MOST_DAMAGED_ROWS]:
        complain(str(bad))
    if more := rejected[MOST_DAMAGED_ROWS:]:
        complain(f"and {counted(len(more), 'more damaged row')}")
    done = sum(one.changed for one in found)
    if out is not None:
        complain(f"Wrote {counted(len(found), 'plan')} to {out}")
    elif look or not done:
        say(f"{counted(done, 'flight')} would be filled in" if look else "No flight was filled in")
    else:
        say(f"Filled in {counted(done, 'flight')}. `fieldkit undo` to undo.")


def _print(found: "list[FilledIn]") -> None:
    """Print the weather found for every flight, with its standard deviation, in the user's units."""
    chosen = system()
    names = ("temperature", "pressure", "humidity", "wind")
    headers = ["flight", "date", *(f"{name} {spelled(unit_of(BY_NAME[name], chosen))}" for name in names), "aloft"]
    rows = []
    for one in found:
        when = "" if one.before.date_time is None else f"{one.before.date_time:%Y-%m-%d %H:%M}"
        if one.changed:
            cells = [_cell(one, name, chosen) for name in names]
            aloft = one.aloft
            shown = ShownUnits(chosen)
            rows.append([short_name(one.before), when, *cells])
            rows[-1].append(f"{shown.speed(aloft.speed)} at {shown.length(aloft.height)}" if aloft else "")
        else:
            rows.append([short_name(one.before), when, one.reason, *[""] * 4])
    print_table(headers, rows)


def _cell(one: "FilledIn", name: str, chosen: str) -> str:
    if name not in one.values:
        return ""
    value, sd = one.values[name]
    scale = unit(BY_NAME[name].quantity, unit_of(BY_NAME[name], chosen))
    return with_sd(scale.from_si(value), scale.difference_from_si(sd))


def _document(one: "FilledIn") -> dict[str, object]:
    figures: dict[str, object] = {}
    for name, (value, sd) in one.values.items():
        scale = unit(BY_NAME[name].quantity, BY_NAME[name].unit)
        figures |= {BY_NAME[name].header: scale.from_si(value), BY_NAME[name].sd_header: scale.difference_from_si(sd)}
    aloft = None if one.aloft is None else {"height_m": one.aloft.height, "speed_mps": one.aloft.speed}
    return {
        "flight_id": one.before.flight_id,
        "rocket": one.before.rocket,
        "filled": figures,
        "wind_aloft": aloft,
        "reason": one.reason or None,
    }
