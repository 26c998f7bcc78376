"""`fieldkit landing`, `track`: where a plan lands and which rail angle is best; a GPS track as KML."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit import files
from fieldkit.cli.numbers import finite
from fieldkit.cli.options import takes_plan
from fieldkit.cli.planning import AllChecks, about_plan, planning, print_plan
from fieldkit.cli.screen import AsJson, complain, print_json, say, system
from fieldkit.cli.session import open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.errors import BadValue
from fieldkit.flight.short_name import flight_label

if TYPE_CHECKING:
    from fieldkit.planning.landing import Landing

app = typer.Typer()

USUAL_WIND_FROM = 270.0
"""Direction of the wind on a map if none is given, clockwise from north. [deg]"""


def landing(
    context: typer.Context,
    kml: Annotated[
        Path | None,
        typer.Option(
            "--kml",
            "--gpx",
            metavar="FILE",
            help="Write the landing ellipse as KML, or as GPX to a name in .gpx; needs --pad.",
        ),
    ] = None,
    pad: Annotated[str | None, typer.Option(help="Latitude and longitude of the pad: 47.5,8.7.")] = None,
    card: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a one-page range card: .png, .pdf, .svg.")
    ] = None,
    safety_sheet: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write a page for the range safety officer to sign: .png, .pdf, .svg."),
    ] = None,
    wind_from: Annotated[
        float | None,
        typer.Option(callback=finite, help="Direction the wind blows from, in degrees from north. Default: 270, west."),
    ] = None,
    force: ForceOption = False,
    checks: AllChecks = False,
    json: AsJson = False,
    **given: str | None,
) -> None:
    """Forecast where a plan lands, its duration, and the rail angle that lands it nearest the pad."""
    from fieldkit.planning.planned_flight import planned_flight
    from fieldkit.presentation.forecast_text import motor_in_words
    from fieldkit.presentation.kml import landing_gpx, landing_kml, read_place
    from fieldkit.presentation.landing_text import landing_in_words

    if (kml is None) != (pad is None):
        raise typer.BadParameter("found one of --kml and --pad, expected both: a map needs the position of the pad")
    place = None if pad is None else read_place(pad)
    for page in filter(None, (card, safety_sheet)):
        from fieldkit.presentation.report.finals_card import check_card

        check_card(page)
    replaces = {file: settled(file, force) for file in (kml, card, safety_sheet) if file is not None}
    with planning(context, given) as planned:
        if kml is not None and planned.flight.wind is None:
            raise BadValue("found --kml without a wind, expected --wind too: the landing depends on it")
        one, site, known = (
            planned_flight(planned.plan(), planned.site, planned.limits),
            planned.site,
            planned.rocket.known,
        )
    prediction, found, down, lines = one.prediction, one.prediction.found, one.down, one.lines
    words = list(landing_in_words(one, site, system()))
    if kml is not None and place is not None:
        name = f"{prediction.plan.rocket} on {motor_in_words(prediction.plan, found)}"
        if wind_from is None:
            complain(
                f"note: the map assumes a wind from {USUAL_WIND_FROM:g}° (west); another, by --wind-from, turns the map"
            )
        blows_from = USUAL_WIND_FROM if wind_from is None else wind_from
        gpx = kml.suffix.lower() == ".gpx"
        content = (
            landing_gpx(name, down, place, blows_from) if gpx else landing_kml(name, down, place, blows_from, system())
        )
        files.write(kml, content, force=replaces[kml])
        complain(f"Wrote the landing ellipse to {kml}")
    if card is not None:
        from fieldkit.presentation.report.plan_pages import range_card_of

        content = range_card_of(one, known, site, card.suffix.lower(), system())
        files.write(card, content, force=replaces[card])
        complain(f"Wrote the range card to {card}")
    if safety_sheet is not None:
        from fieldkit.presentation.report.plan_pages import safety_sheet_of

        content = safety_sheet_of(one, known, site, safety_sheet.suffix.lower(), system())
        files.write(safety_sheet, content, force=replaces[safety_sheet])
        complain(f"Wrote the range safety sheet to {safety_sheet}")
    if json:
        document: dict[str, Any] = {"rocket": prediction.plan.rocket, "motor": found.motor.designation} | one.json()
        print_json(document | {"on_field": _on_field(down, site.size)} | about_plan(prediction, lines))
        return
    print_plan(words, prediction.plan, lines, known, every=checks)


def _on_field(down: "Landing", size: float | None) -> float | None:
    """Fraction of landings on a field of a size [m] with the pad in its middle; None if it or the wind is unknown."""
    return None if size is None or down.wind is None else float((down.away <= size / 2).mean())


takes_plan(landing)
app.command()(landing)


@app.command()
def track(
    context: typer.Context,
    flight: Annotated[str, typer.Argument(help="Flight id.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="File to write; ends in .kml or .gpx.", show_default=False)],
    force: ForceOption = False,
) -> None:
    """Write the GPS track of a flight's log as KML or GPX."""
    from fieldkit.presentation.kml import check_track, track_file
    from fieldkit.services.replay import track_of

    check_track(out)
    force = settled(out, force)
    with open_ledger(context) as ledger:
        positions = track_of(ledger, flight)
    files.write(out, track_file(flight_label(flight), positions, out.suffix.lower()), force=force)
    say(f"Wrote the track of {flight_label(flight)} to {out}")
