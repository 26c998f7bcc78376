"""`fieldkit demo`: everything on the twelve reference flights."""

import sys
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import typer

from fieldkit.cli.screen import measured, print_table, progress, say, say_wrapped, system
from fieldkit.errors import LedgerError
from fieldkit.files import replace
from fieldkit.quantities import ShownUnits

if TYPE_CHECKING:
    from fieldkit.services.demo import Demo

app = typer.Typer()


@app.command()
def demo(context: typer.Context) -> None:
    """Show what fieldkit does on twelve flights of one rocket: import, infer, predict, and loop.

    Your own ledger is not touched: the demo uses a temporary one, or the empty one
    that --ledger names.
    """
    from fieldkit.ledger import Ledger
    from fieldkit.motors import catalogue
    from fieldkit.services.demo import demo, new_ledger_file

    named = _named_ledger(context)
    new = new_ledger_file(named)
    with TemporaryDirectory(prefix="fieldkit-") as folder:
        made = Path(folder) / "demo.db"
        with Ledger.open(made if named is None or new else named) as ledger, progress("demo") as on_progress:
            found = demo(ledger, catalogue(), on_progress)
        if new is not None:
            _put(made, new)
    _import(found)
    _infer(found)
    _predict(found)
    _loop(found)
    _next(named)


def _next(ledger: str | None) -> None:
    """What to type next: a flight of the user's own, and the same flights again."""
    fieldkit = "fieldkit" if which("fieldkit") else sys.argv[0]
    say("Next, enter a flight of yours (add asks for each figure) and forecast another:")
    say(f"  {fieldkit} add")
    say(f"  {fieldkit} predict --motor F24-4W --wind 8mph")
    if ledger is None:
        say("These twelve flights were in a temporary ledger. To add them to yours:")
        say(f"  {fieldkit} import --example")
    of_ledger = f" --ledger {ledger}" if ledger else ""
    say(f"  {fieldkit}{of_ledger} predict --rocket Astra --motor F24-7W")
    say("The app, and the manual:")
    say(f"  {fieldkit}")
    say(f"  {fieldkit} docs start")


def _named_ledger(context: typer.Context) -> str | None:
    """The ledger on the command line; one from the environment is the user's own."""
    root = context.find_root()
    source = root.get_parameter_source("ledger")
    return root.obj if source is not None and source.name == "COMMANDLINE" else None


def _put(made: Path, new: Path) -> None:
    """Move a finished ledger to its path. Raises FieldkitError if another one has been created there in the
    meantime."""
    if new.exists():
        raise LedgerError(f"{new}: found a file that was made in the meantime, expected no ledger yet")
    replace(new, made.read_bytes())


def _import(found: "Demo") -> None:
    clean = sum(flight.clean for flight in found.flights)
    say_wrapped(
        f"1. {len(found.flights)} flights of {found.rocket} imported. {clean} are normal and used in the model; "
        f"{len(found.flights) - clean} have a tag such as weak_launch and are not used.",
        "   ",
    )
    say()


def _infer(found: "Demo") -> None:
    say_wrapped(
        "2. Drag (Cd) and thrust factor (alpha, 1 as certified) inferred from each apogee. An apogee alone barely "
        "separates the two, hence the wide ±.",
        "   ",
    )
    say()
    headers = ("flight", "motor", "apogee", "Cd", "thrust", "tag")
    rows = [
        (
            f"{one.flight.flight_id} {one.flight.config}",
            one.flight.motor,
            measured("apogee", one.flight.apogee),
            "" if one.cd is None else f"{one.cd:.2f} ± {one.cd_sd:.2f}",
            f"{one.alpha:.2f} ± {one.alpha_sd:.2f}",
            ", ".join(one.flight.tags),
        )
        for one in found.inferred
    ]
    print_table(headers, rows, numbers=("flight", *headers[2:5]))
    say()


def _predict(found: "Demo") -> None:
    from fieldkit.presentation.forecast_text import ejection_in_words

    say(f"3. The next flight, forecast from the {found.predictions[0].rests_on} normal flights with certified thrust")
    say()
    headers = ("motor", "config", "apogee", "90% interval", "ejection")
    shown, rows = ShownUnits(system()), []
    for one in found.predictions:
        p05, p50, p95 = one.apogee_quantiles()
        rows.append(
            (
                one.plan.motor,
                one.plan.config,
                shown.length(p50),
                shown.lengths(p05, p95),
                ejection_in_words(one).partition(";")[0],
            )
        )
    print_table(headers, rows, numbers=headers[2:4])
    say()


def _loop(found: "Demo") -> None:
    from fieldkit.presentation.loop_headline import headline

    say("4. The loop: what forecasts leave out, and by how much they miss")
    say()
    one, shown = headline(found.loop, system()), ShownUnits(system())
    missed = f"Each flight, forecast from the others, misses by {shown.length(one.before, 1)} on average"
    missed += "." if one.after is None else f", {shown.length(one.after, 1)} with the corrections of the loop."
    for line in (one.sentence, *one.also, missed, f"Next: {one.step}"):
        say_wrapped(f"   {line}")
    say()
