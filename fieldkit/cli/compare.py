"""`fieldkit compare`: recordings of one flight compared."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.screen import AsJson, complain, print_json, print_table, say, system
from fieldkit.cli.session import open_ledger
from fieldkit.errors import NoFlights
from fieldkit.quantities import ShownUnits, in_system

if TYPE_CHECKING:
    from fieldkit.analysis.compare import Comparison
    from fieldkit.services.replay import Recording

app = typer.Typer()


@app.command()
def compare(
    context: typer.Context,
    what: Annotated[list[str], typer.Argument(metavar="A B...", help="Logs, simulation exports, or flight ids.")],
    format: Annotated[str | None, typer.Option(help="The parser for the files.")] = None,
    json: AsJson = False,
) -> None:
    """Compare recordings of one flight: two devices, or a flight and a simulation; the first is the reference."""
    from fieldkit.analysis.compare import compare as against
    from fieldkit.importing.tables.mapping import remembered
    from fieldkit.services.replay import recordings

    found: list[Recording] = []
    choices = list(remembered())
    if all(Path(one).is_file() for one in what):
        found = [recording for one in what for recording in recordings(None, one, format, choices)]
    else:
        with open_ledger(context) as ledger:
            found = [recording for one in what for recording in recordings(ledger, one, format, choices)]
    if len(found) < 2:
        raise NoFlights(f"{what[0]}: found {len(found)} recording, expected two or more to compare")
    compared = [against(found[0].recorded, other.recorded) for other in found[1:]]
    if json:
        print_json(_document(found, compared))
        return
    for recording in found:
        for note in recording.recorded.notes:
            complain(f"note: {recording.name}: {in_system(note, system())}")
    _print(found, compared)


def _print(found: "list[Recording]", compared: "list[Comparison]") -> None:
    """Print a table of figures, a column per recording, with their differences."""
    from fieldkit.analysis.labels import TITLES, figure_text

    chosen = system()
    headers = ["", *(recording.name for recording in found), *("difference" for _ in compared)]
    rows = []
    for name, title in TITLES.items():
        figures = [recording.recorded.figures.get(name) for recording in found]
        if any(figures):
            differences = [comparison.differences.get(name) for comparison in compared]
            cells = [figure_text(name, figure.value, figure.sd, chosen) if figure else "" for figure in figures]
            rows.append(
                (
                    title,
                    *cells,
                    *(_difference_text(name, one.value, one.in_sd, chosen) if one else "" for one in differences),
                )
            )
    print_table(headers, rows)
    for recording, comparison in zip(found[1:], compared, strict=True):
        if comparison.rms is not None and comparison.shift is not None:
            shift = round(comparison.shift, 2) + 0.0  # zero is never negative
            say(
                f"{recording.name}: heights differ by {ShownUnits(chosen).length(comparison.rms, 1)} (RMS) over "
                f"{comparison.seconds:.1f} s of ascent, after shifting its clock by {shift:.2f} s"
            )
        else:
            say(f"{recording.name}: no samples to compare with those of {found[0].name}")


def _difference_text(name: str, value: float, in_sd: float | None, system: str) -> str:
    from fieldkit.analysis.labels import figure_text

    sign = "+" if value >= 0 else ""
    return sign + figure_text(name, value, 0.0, system) + (f", {abs(in_sd):.1f} sd" if in_sd is not None else "")


def _document(found: "list[Recording]", compared: "list[Comparison]") -> dict[str, object]:
    """Recordings and comparisons as JSON, in the units of the flight table."""
    from fieldkit.analysis.labels import column_header, in_column_unit

    return {
        "recordings": [{"name": one.name, "kind": one.kind} | document(one) for one in found],
        "compared": [
            {
                "with": found[0].name,
                "name": other.name,
                "shift_s": comparison.shift,
                "rms_height_m": comparison.rms,
                "ascent_s": comparison.seconds,
                "differences": {
                    column_header(name): {
                        "difference": in_column_unit(name, one.value),
                        "sd": in_column_unit(name, one.sd),
                        "in_sd": one.in_sd,
                    }
                    for name, one in comparison.differences.items()
                },
            }
            for other, comparison in zip(found[1:], compared, strict=True)
        ],
    }


def document(recording: "Recording") -> dict[str, object]:
    """What was measured in a recording as JSON, in the units of the flight table."""
    from fieldkit.analysis.labels import column_header, in_column_unit

    recorded = recording.recorded
    return {
        "figures": {
            column_header(name): {
                "value": in_column_unit(name, one.value),
                "sd": in_column_unit(name, one.sd),
                "source": one.source,
            }
            for name, one in recorded.figures.items()
        },
        "stated": {column_header(name): in_column_unit(name, value) for name, value in recording.stated.items()},
        "events": {
            name: {"time_s": one.time, "sd_s": one.sd, "source": one.source} for name, one in recorded.events.items()
        },
        "notes": list(recorded.notes),
    }
