"""`fieldkit demo`: everything on the twelve reference flights."""

import sys
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import typer

from fieldkit.cli.screen import measured, print_table, progress, say, say_report, say_wrapped, system
from fieldkit.cli.units import ask_units_once
from fieldkit.errors import LedgerError
from fieldkit.files import replace
from fieldkit.progress import ReportProgress, part
from fieldkit.quantities import ShownUnits

if TYPE_CHECKING:
    from fieldkit.reference.report import PaperReport
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

    ask_units_once()
    named = _named_ledger(context)
    new = new_ledger_file(named)
    with TemporaryDirectory(prefix="fieldkit-") as folder:
        made = Path(folder) / "demo.db"
        with Ledger.open(made if named is None or new else named) as ledger, progress("demo") as on_progress:
            found = demo(ledger, catalogue(), part(on_progress, 0.0, 0.7))
            paper = _paper(part(on_progress, 0.7, 0.3))
        if new is not None:
            _put(made, new)
    _import(found)
    _infer(found)
    _predict(found)
    _loop(found)
    _profile(paper)
    _next(named)


def _next(ledger: str | None) -> None:
    """What to type next: a flight of the user's own, and the same flights again."""
    fieldkit = "fieldkit" if which("fieldkit") else sys.argv[0]
    say("Next, enter a flight of yours (add asks for each figure) and forecast another:")
    say(f"  {fieldkit} add")
    say(f"  {fieldkit} predict --motor F24-4W --wind 8mph")
    if ledger is None:
        say("These twelve flights were in a temporary ledger. To save and use them:")
        ledger = "demo.db"
        say(f"  {fieldkit} --ledger {ledger} demo")
    say(f"  {fieldkit} --ledger {ledger} predict --motor F24-7W")
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
        "separates the two, hence the wide ±; the reference paper's network (last two columns) has none.",
        "   ",
    )
    say()
    headers = ("flight", "motor", "apogee", "Cd", "thrust", "tag", "paper Cd", "paper thrust")
    rows = [
        (
            f"{one.flight.flight_id} {one.flight.config}",
            one.flight.motor,
            measured("apogee", one.flight.apogee),
            f"{one.cd:.2f} ± {one.cd_sd:.2f}",
            f"{one.alpha:.2f} ± {one.alpha_sd:.2f}",
            ", ".join(one.flight.tags),
            f"{its.cd:.2f}",
            f"{its.alpha:.2f}",
        )
        for one, its in zip(found.inferred, found.by_paper, strict=True)
    ]
    print_table(headers, rows, numbers=[name for name in headers if name not in ("motor", "tag")])
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
    from fieldkit.presentation.loop_text import report

    say("4. The loop: what the model gets wrong, and what may be missing from it")
    say()
    say_report(report(found.loop, system()))
    say()


def _paper(on_progress: ReportProgress) -> "PaperReport":
    """The reference paper's test."""
    from fieldkit.reference.report import report

    on_progress("flying the published thrust", 0.0)
    return report()


def _profile(paper: "PaperReport") -> None:
    say("5. What the reference paper's published thrust profile costs")
    say()
    profile, bias = paper.thrust_profile, paper.thrust_profile["exact_posterior_bias_m"]
    count, shown = paper.reconstruction["n"], ShownUnits(system())
    headers = ("motor", "certified", "profile delivers", "excess")
    rows = [
        (
            one["motor"],
            f"{one['certified_ns']:.1f} N s",
            f"{one['delivered_ns']:.1f} N s",
            f"{one['delivered_ns'] / one['certified_ns'] - 1:+.0%}",
        )
        for one in profile["motors"]
    ]
    print_table(headers, rows, numbers=headers[1:])
    say()
    below = profile["below_lowest_apogee_of_prior"]
    say_wrapped(
        f"   Apogees simulated with it are biased by {shown.difference(bias['published'])} over the {count} normal "
        f"flights, and {shown.difference(bias['certified'])} with certified curves; {below['published']} of the "
        f"{count} lie below the lowest apogee that its prior allows, {below['certified']} with certified curves."
    )
    say()
    missed = {rule["rule"]: rule for rule in paper.rules}
    before, after = missed["published_carried_over"], missed["hierarchical_certified"]
    was, now = (f"{shown.length(one['mae_m'], 1)} (bias {shown.difference(one['bias_m'])})" for one in (before, after))
    say_wrapped(
        f"   Each normal flight forecast from the others (leave-one-out): mean error {was} with the published profile "
        f"and parameters, {now} with certified curves. `fieldkit paper` has the rest."
    )
    say()
