"""`fieldkit inspect`, `fieldkit import` and `fieldkit export`."""

import json
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from enum import StrEnum
from io import TextIOWrapper
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.completing import rocket_names
from fieldkit.cli.options import takes_lacking
from fieldkit.cli.predictions import print_outcome
from fieldkit.cli.screen import AsJson, complain, print_json, progress, say, say_lines, say_wrapped, system
from fieldkit.cli.session import MotorCheck, given_columns, known_motors, open_ledger, read_settings
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.cli.units import system_named
from fieldkit.errors import BadValue
from fieldkit.files import write
from fieldkit.flight import Flight
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.quantities import counted, in_system

if TYPE_CHECKING:
    from fieldkit.importing import Rejected
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue
    from fieldkit.services.imports import Gathered, Receipt

app = typer.Typer()
MAX_LISTED = 100
"""Maximum number of rejected rows, and of notes, that are printed. [1]"""
SPREADSHEETS = (".xlsx", ".xls", ".ods", ".numbers")
"""Suffixes of files that spreadsheets write; one of them that holds a CSV table does not open in some."""

MAX_COMPARED_FLIGHTS = 6
"""Maximum number of imported flights that are compared with their forecasts, one line each. [1]"""

FILES = 20
"""Maximum number of files that get a line each. [1]"""


EXAMPLES = {"rocket": "NAME", "motor": "F24-4W", "dry_mass": "320g"}
"""What a flight needs to be used in forecasts, as it is typed."""


class ExportFormat(StrEnum):
    """Formats of `export`."""

    CSV = "csv"
    JSON = "json"


Files = Annotated[list[Path], typer.Argument(help="Logs, flight tables, or folders of them.", show_default=False)]
OptionalFiles = Annotated[
    list[Path] | None, typer.Argument(help="Logs, flight tables, or folders of them.", show_default=False)
]
Format = Annotated[str | None, typer.Option(help="The parser, if the format is not recognized.")]
GivenValues = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="COLUMN=VALUE", help="Other values that the files lack: wind=8mph."),
]
ColumnMappings = Annotated[
    list[str] | None,
    typer.Option(
        "--map",
        metavar="CHANNEL=COLUMN",
        help="Meaning of a column: 'altitude=Alt (ft)' for samples, 'apogee=Reached (ft)' for flights. Saved for "
        "tables with these headers.",
    ),
]


@app.command()
def inspect(
    files: Files, format: Format = None, given: GivenValues = None, columns: ColumnMappings = None, json: AsJson = False
) -> None:
    """Show what logs and flight tables contain, without importing anything.

    Prints the format and why it was recognized, the columns and their units, the readouts with their standard
    deviations, their sensors and the device's own values, the events, and what would be imported.
    """
    from fieldkit.presentation.import_view import document, lines

    gathered, _ = _gathered(files, format, given_columns(given, {}), columns)
    complain_of(gathered.rejected, ())
    if json:
        print_json(document(gathered.files))
        _fail_for(gathered.unusable)
        return
    for place, one in enumerate(gathered.files):
        if place:
            say()
        for line in lines(one, system()):
            say(line)
    _fail_for(gathered.unusable)


def _gathered(
    files: Sequence[Path], format: str | None, given: Mapping[str, str], columns: Sequence[str] | None
) -> "tuple[Gathered, Catalogue]":
    """The contents of files, as for an import, and the motors."""
    from fieldkit.services.imports import gather, read_as

    check_motor = MotorCheck()
    how = read_as(format, read_settings(given, check_motor), columns or ())
    with progress("reading") as on_progress:
        gathered = gather(files, check_motor, how, jobs=os.cpu_count() or 1, on_progress=on_progress)
    return gathered, check_motor.catalogue


def import_(
    context: typer.Context,
    files: OptionalFiles = None,
    format: Format = None,
    given: GivenValues = None,
    columns: ColumnMappings = None,
    example: Annotated[bool, typer.Option("--example", help="The twelve flights of Astra in the manual.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what would happen without changing anything.")
    ] = False,
    json: AsJson = False,
    **named: str | None,
) -> None:
    """Import logs and flight tables into the ledger; duplicates change nothing.

    Rejected rows and files are listed; the rest is imported. The log of a known rocket gets the dry mass and diameter
    of its last flight in that configuration, and is compared with its forecast.
    """
    from fieldkit.services.imports import take_in

    if not files and not example:
        raise typer.BadParameter("found no file, expected at least one, or --example", param_hint="FILE...")
    settings = given_columns(given, named)
    gathered, motors = _gathered([*(files or ()), *[REFERENCE_FLIGHTS] * example], format, settings, columns)
    with open_ledger(context) as ledger:
        complain_of_names(ledger, settings)
        receipt = take_in(ledger, gathered, dry_run=dry_run, motors=motors)
        complain_of(receipt.rejected, receipt.notes)
        if json:
            print_json(_document(receipt))
        else:
            say_receipt(receipt, "Would import" if dry_run else "Imported")
            if not dry_run:
                say_next(ledger, receipt)
    _fail_for(receipt.unusable)


def complain_of_names(ledger: "Ledger", settings: Mapping[str, str]) -> None:
    """Note names that the ledger does not know and that resemble known ones."""
    from fieldkit.services.unknown_names import unknown_names

    flight = Flight().with_changes(**{name: settings.get(name, "") for name in ("rocket", "config", "site")})
    for phrase in unknown_names(ledger, flight, settings, new=True):
        complain(f"note: {phrase}")


takes_lacking(import_)
app.command("import")(import_)


def _fail_for(unusable: int) -> None:
    """Exit with status 1 if a file could not be used at all; it was named, and the others were imported."""
    if unusable:
        raise typer.Exit(1)


def complain_of(rejected: "Sequence[Rejected]", notes: Sequence[str]) -> None:
    """Print rejected rows and notes, one line each, up to `MAX_LISTED` of them."""
    for row in rejected[:MAX_LISTED]:
        place = [row.file, f"row {row.row}" if row.row is not None else "", row.column or ""]
        complain(f"{', '.join(part for part in place if part)}: {row.error}")
    for note in notes[:MAX_LISTED]:
        complain(f"note: {in_system(note, system())}")
    for found, what in ((rejected, "rejected row"), (notes, "note")):
        if more := len(found[MAX_LISTED:]):
            complain(f"{counted(more, f'more {what}')}; --json lists them all")


def _document(receipt: "Receipt") -> dict[str, object]:
    """The result of an import under the contract's keys."""
    from fieldkit.presentation.import_view import receipts

    return {
        "imported": len(receipt.ids),
        "duplicates": receipt.duplicates,
        "rejected": [asdict(row) for row in receipt.rejected],
        "flights": list(receipt.ids),
        "joined": list(receipt.joined),
        "files": receipts(receipt.files),
    }


def say_receipt(receipt: "Receipt", done: str) -> None:
    """Print the counts of an import, and one line per file."""
    from fieldkit.presentation.import_view import in_a_line

    counts = f"{counted(receipt.duplicates, 'duplicate')}, {len(receipt.rejected)} rejected"
    joined = f"{len(receipt.joined)} added to existing flights, " if receipt.joined else ""
    say(f"{done} {len(receipt.ids)}, {joined}{counts}")
    for one in receipt.files[:FILES]:
        say_wrapped(in_a_line(one, system()), "  ")
    if len(receipt.files) > FILES:
        say(f"and {counted(len(receipt.files) - FILES, 'more file')}; --json lists them all")


def say_next(ledger: "Ledger", receipt: "Receipt") -> None:
    """Print what follows from the new flights: of a single log, how it compares with its forecast and what the rocket
    flies next, as after `add`, or how to complete it; of others, their saved forecasts."""
    from fieldkit.services.manual_entry import planned_answers

    if not receipt.ids:
        return
    flight = ledger.flight(receipt.ids[0])
    if len(receipt.ids) > 1 or not flight.has_log:
        _say_forecasts(list(_forecast_lines(ledger, receipt.ids)))
    elif flight.rocket and flight.motor and flight.dry_mass is not None:
        print_outcome(ledger, flight)
    else:
        examples = EXAMPLES | planned_answers(ledger)
        typed = examples | {"dry_mass": examples["dry_mass"].replace(" ", "")}
        lacking = [f"{name}={quote(typed[name])}" for name in EXAMPLES if not getattr(flight, name)]
        say_wrapped(f"To use it in forecasts: fieldkit edit {quote(receipt.ids[0])} {' '.join(lacking)}")


def _say_forecasts(forecasts: Sequence[str]) -> None:
    """Print a line for each flight with a saved forecast."""
    for line in forecasts[:MAX_COMPARED_FLIGHTS]:
        say_wrapped(line, "  ")
    if len(forecasts) > MAX_COMPARED_FLIGHTS:
        say(f"and {len(forecasts) - MAX_COMPARED_FLIGHTS} more with a forecast; see `fieldkit predictions`")


def _forecast_lines(ledger: "Ledger", ids: Sequence[str]) -> Iterator[str]:
    """A line for each imported flight that had a forecast: forecast and flown."""
    if not ledger.predictions():
        return
    from fieldkit.services.saved_forecasts import by_flight, in_words, list_forecasts

    forecasts = by_flight(list_forecasts(ledger, known_motors()))
    flights = ledger.flights(ids=ids)
    for id, flight in zip(ledger.ids(flights), flights, strict=True):
        if one := forecasts.get((flight.rocket, flight.flight_id)):
            yield f"{id}: {'; '.join(in_words(one, system()))}"


@app.command()
def export(
    context: typer.Context,
    file: Annotated[Path | None, typer.Argument(help="The file to write; default: standard output.")] = None,
    format: Annotated[ExportFormat | None, typer.Option(help="Default: from the file's suffix, else csv.")] = None,
    rocket: Annotated[
        str | None, typer.Option(help="Flights of this rocket only.", autocompletion=rocket_names)
    ] = None,
    units: Annotated[
        str,
        typer.Option(
            metavar="[SI|US|mixed]",
            help="The units of a table; a column of yours keeps its own, JSON has SI.",
        ),
    ] = "SI",
    force: ForceOption = False,
) -> None:
    """Write flights as a table or as JSON, to import again or open in a spreadsheet."""
    from fieldkit.presentation.export import csv_table, document
    from fieldkit.services.forecasts import which_rocket

    file = None if file is not None and str(file) in ("-", "/dev/stdout") else file
    if file is not None and format is None and file.suffix.lower() in SPREADSHEETS:
        raise BadValue(f"{file}: found {file.suffix}, expected .csv, which every spreadsheet opens, or .json")
    chosen = system_named(units)
    as_json = format is ExportFormat.JSON or (format is None and file is not None and file.suffix.lower() == ".json")
    if as_json and chosen != "SI":
        raise typer.BadParameter(f"found --units {units} with JSON, expected a table: JSON is always in SI")
    with open_ledger(context) as ledger:
        force = file is not None and settled(file, force)
        flights = ledger.flights(which_rocket(ledger, rocket) if rocket else None)
    if as_json:
        text = json.dumps({"flights": [document(one) for one in flights]}, indent=2, allow_nan=False) + "\n"
    else:
        text = csv_table(flights, chosen)
    if file is None and sys.stdout.isatty():
        say_lines(text)
    elif file is None:
        if isinstance(sys.stdout, TextIOWrapper):
            sys.stdout.reconfigure(
                encoding="utf-8", newline=""
            )  # UTF-8 even if the terminal differs: this output goes to a file or a pipe
        sys.stdout.write(text)
    else:
        write(file, text.encode(), force=force)
        complain(f"Wrote {counted(len(flights), 'flight')} to {file}")
