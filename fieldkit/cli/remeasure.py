"""`fieldkit remeasure`: read the files of flights again with the current parsers and analysis."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.screen import AsJson, complain, print_json, print_table, progress, say, system
from fieldkit.cli.session import open_ledger
from fieldkit.errors import FieldkitError, UnusableLedger

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.services.imports import Remeasured

app = typer.Typer()


@app.command()
def remeasure(
    context: typer.Context,
    flights: Annotated[
        list[str] | None, typer.Argument(metavar="FLIGHT...", help="Default: all.", show_default=False)
    ] = None,
    rocket: Annotated[str | None, typer.Option(help="Flights of this rocket only.", show_default=False)] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what would change without changing anything.")
    ] = False,
    json: AsJson = False,
) -> None:
    """Measure the logs of flights again; what you typed or edited is not changed. Can be undone."""
    from fieldkit.ledger import Renewal
    from fieldkit.services.forecasts import which_rocket
    from fieldkit.services.imports import Remeasured, remeasured

    found, without, errors = list[Remeasured](), 0, dict[str, str]()
    if flights and rocket:
        raise typer.BadParameter("found flights and --rocket, expected one of the two")
    with open_ledger(context) as ledger:
        ids = flights or ledger.ids(ledger.flights(which_rocket(ledger, rocket) if rocket else None))
        with progress("reading logs again") as on_progress:
            for place, id in enumerate(ids):
                on_progress(id, place / len(ids))
                try:
                    one = remeasured(ledger, id)
                except FieldkitError as error:
                    if isinstance(error, UnusableLedger) or (flights and len(flights) == 1):
                        raise
                    errors[id] = str(error)
                    continue
                without += one is None
                found += [one] if one else []
        renewals = [Renewal(one.id, one.flight, one.renewed, one.renewed_entered) for one in found]
        changed = ledger.renew(renewals, dry_run=dry_run)
    for id, text in errors.items():
        complain(f"{id}: {text}")
    if json:
        print_json(_document(found, changed, without, errors, dry_run))
    else:
        _print(found, changed, without, dry_run)
    if errors:
        raise typer.Exit(1)


def _print(found: "Sequence[Remeasured]", changed: int, without: int, dry_run: bool) -> None:
    from fieldkit.analysis.labels import TITLES

    rows = []
    for one in found:
        for name, (old, new) in one.changes.items():
            rows.append((one.id, TITLES[name], _figure(name, old, one.flight), _figure(name, new, one.renewed)))
        if one.others and not one.changes:
            rows.append((one.id, "notes", "", ", ".join(one.others)))
        for name in one.kept:
            complain(f"note: {one.id}: {TITLES[name].lower()} was typed or edited; not changed")
    if rows:
        print_table(("flight", "", "before", "now"), rows)
    done = "would change" if dry_run else "changed"
    after = "" if dry_run or not changed else ". `fieldkit undo` to undo."
    say(f"{changed} {done}, {len(found) - changed} unchanged, {without} without samples{after}")


def _figure(name: str, value: float | None, flight: "Flight") -> str:
    """A readout with its uncertainty, `553.70 ± 0.70 m`, or a dash if there is none."""
    from fieldkit.analysis.labels import figure_text

    return "-" if value is None else figure_text(name, value, flight.sd.get(name, 0.0), system())


def _document(
    found: "Sequence[Remeasured]", changed: int, without: int, errors: dict[str, str], dry_run: bool
) -> dict[str, object]:
    from fieldkit.analysis.labels import column_header

    return {
        "flights": [
            {
                "flight": one.id,
                "changes": {
                    column_header(name): {
                        "there": _in_column_unit(name, old, one.flight),
                        "now": _in_column_unit(name, new, one.renewed),
                    }
                    for name, (old, new) in one.changes.items()
                },
                "others": list(one.others),
                "kept": [column_header(name) for name in one.kept],
            }
            for one in found
        ],
        "changed": changed,
        "without_samples": without,
        "errors": [{"flight": id, "error": text} for id, text in errors.items()],
        "dry_run": dry_run,
    }


def _in_column_unit(name: str, value: float | None, flight: "Flight") -> dict[str, float | None] | None:
    """A readout and its standard deviation in the unit of the flight table, None if there is none."""
    from fieldkit.analysis.labels import in_column_unit

    if value is None:
        return None
    sd = flight.sd.get(name)
    return {"value": in_column_unit(name, value), "sd": None if sd is None else in_column_unit(name, sd)}
