"""`fieldkit inspect`, `fieldkit import` and `fieldkit export`: files looked at, files in, files out."""

import os
from collections.abc import Iterator, Sequence
from enum import StrEnum
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.completing import rocket_names
from fieldkit.cli.screen import complain, print_json, progress, say, say_lines, say_wrapped
from fieldkit.cli.session import MotorCheck, open_ledger, read_settings, split_settings
from fieldkit.cli.targets import Force, settled

if TYPE_CHECKING:
    from fieldkit.importing import ColumnChoice, Rejected
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue
    from fieldkit.services.imports import Gathered, Receipt

app = typer.Typer()

MAX_COMPARED_FLIGHTS = 6
"""How many imported flights are compared with their forecasts, a line each."""

FILES = 20
"""What so many files were is said, a line each."""


class ExportFormat(StrEnum):
    """What `export` writes."""

    CSV = "csv"
    JSON = "json"


Files = Annotated[list[Path], typer.Argument(help="Logs and flight tables, or folders of them.", show_default=False)]
Format = Annotated[str | None, typer.Option(help="The parser to read them with, where none is recognised.")]
Given = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="COLUMN=VALUE", help="What the files leave open: rocket=Astra."),
]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        "--map",
        metavar="CHANNEL=COLUMN",
        help="What a column is: 'altitude=Alt [ft]' of samples, 'apogee=Reached [ft]' of flights. Remembered for "
        "tables with these headers.",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]


@app.command()
def inspect(
    files: Files, format: Format = None, given: Given = None, columns: Columns = None, json: AsJson = False
) -> None:
    """Say what logs and flight tables are, before anything is stored.

    The format and why it was taken, the columns and their units, the readouts with how sure they are and which sensor
    they rest on beside what the device states, the events, and what an import would store.
    """
    from fieldkit.presentation.import_view import document, lines

    gathered = _gathered(files, format, given, columns)[0]
    _complain_of(gathered.rejected, ())
    if json:
        print_json(document(gathered.files))
        _fail_for(gathered.unusable)
        return
    for place, one in enumerate(gathered.files):
        if place:
            say()
        for line in lines(one):
            say(line)
    _fail_for(gathered.unusable)


def _gathered(
    files: Sequence[Path], format: str | None, given: Sequence[str] | None, columns: Sequence[str] | None
) -> "tuple[Gathered, list[ColumnChoice], Catalogue]":
    """What files hold, read as for an import, the choices of columns that they were read with, and the motors."""
    from fieldkit.importing.tables.mapping import read_choice, remembered
    from fieldkit.services.imports import gather

    choices = ([read_choice(columns)] if columns else []) + list(remembered())
    check_motor = MotorCheck()
    defaults = read_settings(split_settings(given or ()), check_motor)
    with progress("reading") as on_progress:
        gathered = gather(
            files,
            check_motor,
            format=format,
            defaults=defaults,
            choices=choices,
            jobs=os.cpu_count() or 1,
            on_progress=on_progress,
        )
    return gathered, choices, check_motor.catalogue


@app.command("import")
def import_(
    context: typer.Context,
    files: Files,
    format: Format = None,
    given: Given = None,
    columns: Columns = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would happen, change nothing.")] = False,
    json: AsJson = False,
) -> None:
    """Take logs and flight tables into the ledger; what is there already changes nothing.

    What cannot be taken in is named, and the rest goes in.
    """
    from fieldkit.importing.tables.mapping import remember
    from fieldkit.services.imports import take_in

    gathered, choices, motors = _gathered(files, format, given, columns)
    with open_ledger(context) as ledger:
        receipt = take_in(ledger, gathered, choices=choices, dry_run=dry_run, motors=motors)
        foretold = [] if json or dry_run or not receipt.ids else list(_foretold(ledger, receipt.ids))
    for mapped in receipt.mapped:
        if mapped.chosen and not dry_run:
            remember(mapped.choice)
    _complain_of(receipt.rejected, receipt.notes)
    if json:
        print_json(_document(receipt))
    else:
        _say(receipt, "would be imported" if dry_run else "imported", foretold)
    _fail_for(receipt.unusable)


def _fail_for(unusable: int) -> None:
    """End with status 1 where a file could not be used at all; it was named, and the others were taken."""
    if unusable:
        raise typer.Exit(1)


def _complain_of(rejected: "Sequence[Rejected]", notes: Sequence[str]) -> None:
    """Rows that were refused and what else is worth a note, a line each."""
    for row in rejected:
        place = [row.file, f"row {row.row}" if row.row is not None else "", row.column or ""]
        complain(f"{', '.join(part for part in place if part)}: {row.error}")
    for note in notes:
        complain(f"note: {note}")


def _document(receipt: "Receipt") -> dict[str, object]:
    """What came in, under the contract's keys."""
    from dataclasses import asdict

    from fieldkit.presentation.import_view import receipts

    return {
        "imported": len(receipt.ids),
        "duplicates": receipt.duplicates,
        "rejected": [asdict(row) for row in receipt.rejected],
        "flights": list(receipt.ids),
        "joined": list(receipt.joined),
        "files": receipts(receipt.files),
    }


def _say(receipt: "Receipt", done: str, forecasts: Sequence[str]) -> None:
    """What came in, in a line; what each file was; and beside it what had been forecast."""
    from fieldkit.presentation.import_view import in_a_line

    counts = f"{receipt.duplicates} there already, {len(receipt.rejected)} rejected"
    joined = f"{len(receipt.joined)} joined to their flight, " if receipt.joined else ""
    say(f"{len(receipt.ids)} {done}, {joined}{counts}")
    for one in receipt.files[:FILES]:
        say_wrapped(in_a_line(one), "  ")
    if len(receipt.files) > FILES:
        say(f"and {len(receipt.files) - FILES} more files; --json lists all")
    for line in forecasts[:MAX_COMPARED_FLIGHTS]:
        say_wrapped(line, "  ")
    if len(forecasts) > MAX_COMPARED_FLIGHTS:
        say(f"and {len(forecasts) - MAX_COMPARED_FLIGHTS} more with a forecast; see `fieldkit predictions`")


def _foretold(ledger: "Ledger", ids: Sequence[str]) -> Iterator[str]:
    """What was foretold of flights that came in, a line for each of which something was."""
    if not ledger.predictions():
        return
    from fieldkit.cli.session import known_motors
    from fieldkit.services.saved_forecasts import by_flight, in_words, list_forecasts

    said = by_flight(list_forecasts(ledger, known_motors()))
    flights = ledger.flights(ids=ids)
    for id, flight in zip(ledger.ids(flights), flights, strict=True):
        if one := said.get((flight.rocket, flight.flight_id)):
            yield f"{id}: {'; '.join(in_words(one))}"


@app.command()
def export(
    context: typer.Context,
    file: Annotated[Path | None, typer.Argument(help="The file to write; without one, the screen.")] = None,
    format: Annotated[ExportFormat | None, typer.Option(help="By default what the file's name says, or csv.")] = None,
    rocket: Annotated[
        str | None, typer.Option(help="Flights of this rocket only.", autocompletion=rocket_names)
    ] = None,
    force: Force = False,
) -> None:
    """Write flights as a table or as JSON, to be imported again or opened in a spreadsheet."""
    import json
    import sys

    from fieldkit.files import write
    from fieldkit.presentation.export import csv_table, document

    with open_ledger(context) as ledger:
        force = file is not None and settled(file, force)
        flights = ledger.flights(rocket)
    as_json = format is ExportFormat.JSON or (format is None and file is not None and file.suffix.lower() == ".json")
    if as_json:
        text = json.dumps({"flights": [document(one) for one in flights]}, indent=2, allow_nan=False) + "\n"
    else:
        text = csv_table(flights)
    if file is None and sys.stdout.isatty():
        say_lines(text)
    elif file is None:
        if isinstance(sys.stdout, TextIOWrapper):
            sys.stdout.reconfigure(encoding="utf-8", newline="")  # whatever the terminal: it is a file on its way
        sys.stdout.write(text)
    else:
        write(file, text.encode(), force=force)
        complain(f"{len(flights)} flights written to {file}")
