"""`fieldkit demo`: the whole of fieldkit on twelve flights that come with it."""

import re
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import typer

from fieldkit.cli.screen import print_table, progress, say, say_wrapped
from fieldkit.units import FOOT

if TYPE_CHECKING:
    from fieldkit.demo import Demo

app = typer.Typer()


@app.command()
def demo(context: typer.Context) -> None:
    """Show it all on twelve flights of one rocket: import, infer, predict, close the loop.

    Your own ledger is left alone: the demo keeps its flights in a temporary one, or in the empty one
    that --ledger names.
    """
    from fieldkit.demo import demo
    from fieldkit.ledger import Ledger
    from fieldkit.motors import catalogue

    named = _named_ledger(context)
    with ExitStack() as stack:
        folder = stack.enter_context(TemporaryDirectory(prefix="fieldkit-"))
        ledger = stack.enter_context(Ledger.open(named or Path(folder) / "demo.db"))
        with progress("demo") as tell:
            found = demo(ledger, catalogue(), tell)
    _import(found)
    _infer(found)
    _predict(found)
    _loop(found)
    _profile(found)
    if named is None:
        say("The flights were kept in a temporary ledger. To keep them and go on from here:")
        say("  fieldkit --ledger demo.db demo")


def _named_ledger(context: typer.Context) -> str | None:
    """The ledger of the command line; one that only the environment names is the flyer's own."""
    root = context.find_root()
    source = root.get_parameter_source("ledger")
    return root.obj if source is not None and source.name == "COMMANDLINE" else None


def _import(found: "Demo") -> None:
    clean = sum(flight.clean for flight in found.flights)
    say_wrapped(
        f"1. {len(found.flights)} flights of {found.rocket} imported. {clean} are clean and teach the model; "
        f"{len(found.flights) - clean} bear a tag such as weak_launch and only stay on record.",
        "   ",
    )
    say()


def _infer(found: "Demo") -> None:
    say_wrapped(
        "2. Drag (Cd) and thrust (alpha, 1 as declared) inferred from each apogee, "
        f"by the ensemble {found.inferred[0].model}, with the spread of its members",
        "   ",
    )
    say()
    headers = ("flight", "motor", "apogee", "", "Cd", "alpha", "tag")
    rows = [
        (
            f"{one.flight.flight_id} {one.flight.config}",
            one.flight.motor,
            *_heights(one.flight.apogee or 0.0, 1),
            f"{one.cd:.3f} ± {one.cd_sd:.3f}",
            f"{one.alpha:.3f} ± {one.alpha_sd:.3f}",
            ", ".join(one.flight.tags),
        )
        for one in found.inferred
    ]
    print_table(headers, rows, numbers=("flight", "apogee", "", "Cd", "alpha"))
    say()


def _predict(found: "Demo") -> None:
    say(f"3. The next flight, forecast from the {found.predictions[0].rests_on} clean ones with certified thrust")
    say()
    headers = ("motor", "config", "apogee", "", "90 % between", "ejection")
    rows = []
    for one in found.predictions:
        p05, p50, p95 = (float(quantile) for quantile in one.apogee_quantiles())
        eject = one.median_eject
        rows.append(
            (
                one.plan.motor,
                one.plan.config,
                *_heights(p50, 0),
                f"{p05:.0f} and {p95:.0f} m",
                "no delay known"
                if eject is None
                else f"{abs(eject):.1f} s {'after' if eject >= 0 else 'BEFORE'} apogee",
            )
        )
    print_table(headers, rows, numbers=headers[2:5])
    say()


def _heights(height: float, digits: int) -> tuple[str, str]:
    """A height in metres, and in feet without decimals, as altimeters show it."""
    return f"{height:.{digits}f} m", f"{height / FOOT:.0f} ft"


def _loop(found: "Demo") -> None:
    from fieldkit.loop.words import report

    say("4. The loop closed: what the model gets wrong, and what could be missing")
    say()
    for line in report(found.rocket, found.diagnosis):
        say_wrapped(line, _column(line)) if line else say()
    say()


def _column(line: str) -> str:
    """Blanks up to the last column of a line, for what does not fit to go on below it."""
    text = line.strip()
    columns = list(re.finditer(r"\s{3,}", text))
    return " " * (columns[-1].end() if columns else 2)


def _profile(found: "Demo") -> None:
    profile, bias = found.paper.thrust_profile, found.paper.thrust_profile["exact_posterior_bias_m"]
    count = found.paper.reconstruction["n"]
    say("5. What the thrust profile costs that the reference paper published")
    say()
    headers = ("motor", "certified", "profile delivers", "too much")
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
        f"   Apogees rebuilt with it are {bias['published']:+.1f} m off in the mean of the {count} clean flights, "
        f"and {bias['certified']:+.1f} m with certified curves; {below['published']} of the {count} lie below the "
        f"lowest apogee that its prior can make, {below['certified']} with certified curves. "
        "`fieldkit paper` tells the rest."
    )
    say()
