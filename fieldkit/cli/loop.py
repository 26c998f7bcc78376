"""`fieldkit loop` and `fieldkit model`: missing effects, and the model version in use."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from fieldkit.cli.completing import rocket_names
from fieldkit.cli.screen import AsJson, complain, print_json, print_table, progress, say_report, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.errors import BadValue
from fieldkit.progress import part
from fieldkit.quantities import ShownUnits

app = typer.Typer()


@app.command()
def loop(
    context: typer.Context,
    rocket: Annotated[
        str | None,
        typer.Option(help="Default: that of the flight entered last.", show_default=False, autocompletion=rocket_names),
    ] = None,
    effect: Annotated[
        str | None,
        typer.Option(help="Use this effect whatever the evidence; several: wind+mass_offset.", show_default=False),
    ] = None,
    decline: Annotated[
        str | None,
        typer.Option(
            help="Exclude this effect from the search; several: wear+mass_offset. Forecasts use recorded wind anyway.",
            show_default=False,
        ),
    ] = None,
    look: Annotated[
        bool, typer.Option("--dry-run", "--look", help="Show the result without changing the model.")
    ] = False,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="Provisional probabilities at once, which do not change the model; in 21% of simulated seasons the "
            "search has another verdict, mostly a name.",
        ),
    ] = False,
    fleet: Annotated[
        bool, typer.Option("--fleet", help="Look at all rockets: a motor type or lot, a day, a site, an altimeter.")
    ] = False,
    details: Annotated[
        bool, typer.Option("--details", help="Also print every effect, the residuals and the held-out errors.")
    ] = False,
    page: Annotated[
        Path | None,
        typer.Option(
            "--report", metavar="FILE", help="Also write a page with pictures: .html or .png.", show_default=False
        ),
    ] = None,
    force: ForceOption = False,
    json: AsJson = False,
) -> None:
    """Find what the model of a rocket gets wrong, the likely cause, and the error after correcting it."""
    refused = {"--effect": effect, "--decline": decline, "--report": page}
    if fleet:
        _fleet(context, refused={"--quick": quick or None, "--rocket": rocket, **refused}, json=json)
        return
    if quick:
        _quick(context, rocket, refused=refused, json=json)
        return
    from fieldkit.presentation.json_documents import loop_document
    from fieldkit.presentation.loop_text import report
    from fieldkit.services.close_loop import adopt, diagnosis_of, findings_of
    from fieldkit.services.forecasts import which_rocket

    if page is not None:
        from fieldkit.presentation.report.loop.page import check_page, write_page

        check_page(page)
        force = settled(page, force)
    with open_ledger(context) as ledger:
        name = which_rocket(ledger, rocket)
        given, declined = (names.split("+") if names else [] for names in (effect, decline))
        with progress("searching for missing effects") as on_progress:
            motors = known_motors()
            diagnosis = diagnosis_of(ledger, motors, name, part(on_progress, 0.0, 0.7), given, declined)
            if not look:
                adopt(ledger, name, diagnosis)
            found = findings_of(ledger, motors, name, diagnosis, part(on_progress, 0.7, 0.3))
    if page is not None:
        write_page(found, page, force=force, system=system())
        complain(f"Wrote the report to {page}")
    if json:
        print_json(loop_document(found))
        return
    say_report(report(found, system(), details=details))


def _quick(context: typer.Context, rocket: str | None, *, refused: Mapping[str, object], json: bool) -> None:
    """Print a quick look."""
    from fieldkit.presentation.quick_look import quick_document, quick_lines
    from fieldkit.services.forecasts import which_rocket
    from fieldkit.services.quick_look import look_quickly

    _refuse(refused, "--quick")
    with open_ledger(context) as ledger:
        found = look_quickly(ledger, known_motors(), which_rocket(ledger, rocket))
    if json:
        print_json(quick_document(found))
        return
    say_report(quick_lines(found, system()))


def _fleet(context: typer.Context, *, refused: Mapping[str, object], json: bool) -> None:
    """Print what several rockets share."""
    from fieldkit.presentation.fleet_text import fleet_document, fleet_lines
    from fieldkit.services.fleet_loop import close_fleet_loop

    _refuse(refused, "--fleet")
    with open_ledger(context) as ledger, progress("searching over all rockets") as on_progress:
        found = close_fleet_loop(ledger, known_motors(), on_progress)
    if json:
        print_json(fleet_document(found))
        return
    say_report(fleet_lines(found, system()))


def _refuse(options: Mapping[str, object], beside: str) -> None:
    """Raise BadValue for an option that cannot be combined with another."""
    if given := [option for option, value in options.items() if value is not None]:
        raise BadValue(f"{given[0]}: found together with {beside}, expected one of the two")


@app.command()
def model(
    context: typer.Context,
    rocket: Annotated[
        str | None,
        typer.Option(help="Default: that of the flight entered last.", show_default=False, autocompletion=rocket_names),
    ] = None,
    use: Annotated[int | None, typer.Option(min=0, help="Use this version from now on; 0 is no correction.")] = None,
) -> None:
    """List the model versions of a rocket, or switch to one."""
    from fieldkit.services.forecasts import which_rocket
    from fieldkit.services.model_versions import version_summary

    with open_ledger(context) as ledger:
        name = which_rocket(ledger, rocket)
        if use is not None:
            ledger.activate(name, use or None)
        versions = ledger.versions(name)
    shown = ShownUnits(system())
    rows = [("0", "", "no correction", "", "in use" if not any(v.active for v in versions) else "")]
    for version in versions:
        adds, *errors = version_summary(version)
        before, after = ("?" if error is None else shown.length(error, 1) for error in errors)
        rows.append(
            (
                str(version.number),
                f"{version.at:%Y-%m-%d}",
                adds,
                f"{before.split()[0]} -> {after}",
                "in use" if version.active else "",
            )
        )
    print_table(("version", "made", "adds", "mean miss", ""), rows)
