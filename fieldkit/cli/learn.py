"""`fieldkit learn`: fit how much rockets, motors and flights vary, from the exports of several flyers."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import replace
from datetime import datetime
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit.cli.screen import AsJson, complain, print_json, print_table, progress, remark, say, say_wrapped
from fieldkit.cli.session import known_motors
from fieldkit.cli.targets import ForceOption, settled
from fieldkit.files import write
from fieldkit.quantities import counted

if TYPE_CHECKING:
    from fieldkit.model.hyperprior import Hyperprior

app = typer.Typer()


@app.command()
def learn(
    exports: Annotated[
        list[Path] | None,
        typer.Argument(
            help="One flight table per flyer, or a folder of one flyer's files.", exists=True, show_default=False
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="Write the card to this file.", show_default="the screen"),
    ] = None,
    keep: Annotated[bool, typer.Option("--keep", help="Use the card for your forecasts from now on.")] = False,
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="Cross-validate: forecast each rocket with a card fitted without it; takes minutes."
        ),
    ] = False,
    from_start: Annotated[
        bool, typer.Option("--from-scratch", help="Start from the expert priors, not from the card in use.")
    ] = False,
    cluster: Annotated[
        str,
        typer.Option(help="Run --check on Dask workers: local, local:4, or a scheduler's address.", show_default=False),
    ] = "",
    since: Annotated[
        datetime | None,
        typer.Option(
            formats=["%Y-%m-%d"],
            help="Leave out earlier flights, such as those with estimated altitudes.",
            show_default=False,
        ),
    ] = None,
    high_power: Annotated[
        Path | None,
        typer.Option(
            "--high-power",
            metavar="FILE",
            help="Also fit how closely high-power flights follow their simulation, to a table of first flights with "
            "the columns diameter_mm, motor, apogee_m, peak_mach and predicted_..._m (what a design program forecast).",
            exists=True,
            show_default=False,
        ),
    ] = None,
    force: ForceOption = False,
    json: AsJson = False,
) -> None:
    """Fit how much rockets, motors, and flights vary, from the flights of several flyers (tables from `export`).

    The result, the hyperprior, is a JSON file called its card. Every forecast starts from it and is then updated by
    your own flights.
    """
    from fieldkit.model.hyperprior import START, learned
    from fieldkit.parallel import workers
    from fieldkit.services.learn import check as left_out
    from fieldkit.services.learn import keep_card, own_card, read_flyer, scores, scores_by_readouts
    from fieldkit.services.learn import learn as learned_from
    from fieldkit.services.learn_high_power import learn_from_table, read_table

    if not exports and not high_power:
        raise typer.BadParameter("found no tables, expected at least one, or --high-power FILE")
    force = settled(out, force) if out else force
    motors, before = known_motors(), own_card()
    found = START if from_start else learned()
    flyers = [read_flyer(path, motors, since.date() if since else None) for path in exports or ()]
    for line in (line for flyer in flyers for line in flyer.left_out):
        remark(line)
    if flyers:
        with progress("learning") as on_progress:
            found = learned_from(
                flyers, from_start=from_start, since=since.date() if since else None, on_progress=on_progress
            )
    if check and flyers:
        with (
            workers(cluster) if cluster else nullcontext() as pool,
            progress("cross-validating each rocket") as on_progress,
        ):
            checked = left_out(flyers, found, from_start=from_start, pool=pool, on_progress=on_progress)
        by_readouts = {"scores_by_readouts": scores_by_readouts(checked)}
        found = replace(found, about={**found.about, "scores": scores(checked), **by_readouts})
    if high_power:
        with progress("learning from high-power flights"):
            found = learn_from_table(read_table(high_power, motors), found)
    text = dumps(found.json(), indent=1, sort_keys=False)
    if out:
        write(out, (text + "\n").encode(), force=force)
        complain(f"Wrote the card to {out}")
    if keep:
        own = keep_card(text + "\n", before)
        complain(f"Forecasts now start from it; delete {own} to go back")
    if json:
        print_json(found.json())
    elif out is None:
        _print(found)


def _print(found: "Hyperprior") -> None:
    """Print every standard deviation, and the cross-validated scores."""
    for line in _fitted_to(found.about):
        say_wrapped(line)
    rows = [_row(name, sd) for name, sd in found.sds.items()]
    rows.append(("drag", "design", f"{found.design_drag:.3f}"))
    print_table(["quantity", "differs by", "sd"], rows, ["sd"])
    say(f"Mass, thrust and apogee of a rocket with a design on high-power motors: {found.high_power:.2f} of that")
    scored = ["forecast by", "flights", "median", "mean", "CRPS", "interval score", "coverage"]
    _print_tables(found.about.get("scores", {}), "each rocket forecast with a card fitted without it", scored, _scored)
    steps = ["readouts", "flights", "median", "mean", "CRPS", "log score", "less than before"]
    _print_tables(
        found.about.get("scores_by_readouts", {}), "from more and more readouts of the earlier flights", steps, _step
    )


def _print_tables(
    by_flyer: Mapping[str, Any], what: str, headers: list[str], cells: Callable[[Any], tuple[str, ...]]
) -> None:
    """Print the tables of every flyer, whose first column is a name and whose others are figures."""
    for flyer, tables in by_flyer.items():
        for title, rows in tables.items():
            say()
            say_wrapped(f"{flyer}, {what}: {title}")
            print_table(headers, [cells(row) for row in rows], headers[1:])


def _fitted_to(about: Mapping[str, Any]) -> Iterator[str]:
    """What the card was fitted to, a line each."""
    if data := about.get("data"):
        flights, evidence = sum(one["flights"] for one in data), about["log_evidence"]
        yield (
            f"Fitted to {counted(flights, 'flight')} of {counted(len(data), 'flyer')}: log evidence "
            f"{evidence['before']:.1f} before, {evidence['after']:.1f} after."
        )
    if high_power := about.get("high_power_flights"):
        density = high_power["log_density"]
        yield (
            f"High power fitted to {counted(high_power['flights'], 'first flight')}: log density "
            f"{density['before']:.1f} before, {density['after']:.1f} after."
        )


def _row(name: str, sd: float) -> tuple[str, str, str]:
    quantity, _, level = name.partition(".")
    return quantity.replace("_", " "), level.replace("_", " x "), f"{sd:.3f}"


def _step(row: Mapping[str, Any]) -> tuple[str, ...]:
    percents = tuple(f"{100 * row[name]:.1f}%" for name in ("median_share", "mean_share", "crps"))
    low, high = (100 * end for end in row.get("crps_less90", (0.0, 0.0)))
    less = f"{100 * row['crps_less']:+.1f} ({low:+.1f} to {high:+.1f})" if "crps_less" in row else ""
    return (row["name"], str(row["flights"]), *percents, f"{row['log_score']:+.2f}", less)


def _scored(row: dict[str, float | str | int]) -> tuple[str, ...]:
    fractions = (row["median_share"], row["mean_share"], row["crps"])
    percents = tuple(f"{100 * float(value):.1f}%" for value in fractions)
    return (
        str(row["name"]),
        str(row["flights"]),
        *percents,
        f"{float(row['interval_score']):.2f}",
        f"{float(row['coverage90']):.0%}",
    )
