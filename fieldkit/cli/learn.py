"""`fieldkit learn`: fit how much rockets, motors and flights vary, from the exports of several flyers."""

from contextlib import nullcontext
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit.cli.screen import complain, print_json, print_table, progress, remark, say, say_wrapped
from fieldkit.cli.session import known_motors
from fieldkit.cli.targets import Force, settled

if TYPE_CHECKING:
    from fieldkit.model.hyperprior import Hyperprior

app = typer.Typer()


@app.command()
def learn(
    exports: Annotated[
        list[Path],
        typer.Argument(help="One flight table per flyer, or a folder of one flyer's files.", exists=True),
    ],
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
    force: Force = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Fit how much rockets, motors, and flights vary, from the flights of several flyers (tables from `export`).

    Every forecast starts from this card and is then updated by your own flights.
    """
    from dataclasses import replace
    from json import dumps

    from fieldkit.files import replace as replace_file
    from fieldkit.files import write
    from fieldkit.parallel import workers
    from fieldkit.paths import hyperprior_file
    from fieldkit.services.learn import check as left_out
    from fieldkit.services.learn import learn as learned_from
    from fieldkit.services.learn import read_flyer, scores

    force = settled(out, force) if out else force
    motors = known_motors()
    flyers = [read_flyer(path, motors, since.date() if since else None) for path in exports]
    for line in (line for flyer in flyers for line in flyer.left_out):
        remark(line)
    with progress("learning") as on_progress:
        found = learned_from(
            flyers, from_start=from_start, since=since.date() if since else None, on_progress=on_progress
        )
    if check:
        with (
            workers(cluster) if cluster else nullcontext() as pool,
            progress("cross-validating each rocket") as on_progress,
        ):
            checked = left_out(flyers, found, from_start=from_start, pool=pool, on_progress=on_progress)
        found = replace(found, about={**found.about, "scores": scores(checked)})
    text = dumps(found.json(), indent=1, sort_keys=False)
    if out:
        write(out, (text + "\n").encode(), force=force)
        complain(f"card written to {out}")
    if keep:
        own = hyperprior_file()
        own.parent.mkdir(parents=True, exist_ok=True)
        replace_file(own, (text + "\n").encode())
        complain(f"forecasts now start from it; delete {own} to go back")
    if json:
        print_json(found.json())
    elif out is None:
        _print(found)


def _print(found: "Hyperprior") -> None:
    """Print every standard deviation, and the cross-validated scores."""
    flights = sum(one["flights"] for one in found.about["data"])
    evidence = found.about["log_evidence"]
    say_wrapped(
        f"Fitted to {flights} flights of {len(found.about['data'])} flyers: log evidence "
        f"{evidence['before']:.1f} before, {evidence['after']:.1f} after."
    )
    print_table(["quantity", "differs by", "sd"], [_row(name, sd) for name, sd in found.sds.items()], ["sd"])
    for flyer, tables in found.about.get("scores", {}).items():
        for title, rows in tables.items():
            say()
            say_wrapped(f"{flyer}, each rocket forecast with a card fitted without it: {title}")
            print_table(
                ["forecast by", "flights", "median", "mean", "CRPS", "interval score", "coverage"],
                [_scored(row) for row in rows],
                ["flights", "median", "mean", "CRPS", "interval score", "coverage"],
            )


def _row(name: str, sd: float) -> tuple[str, str, str]:
    quantity, _, level = name.partition(".")
    return quantity.replace("_", " "), level.replace("_", " x "), f"{sd:.3f}"


def _scored(row: dict[str, float | str | int]) -> tuple[str, ...]:
    shares = (row["median_share"], row["mean_share"], row["crps"])
    percents = tuple(f"{100 * float(value):.1f}%" for value in shares)
    return (
        str(row["name"]),
        str(row["flights"]),
        *percents,
        f"{float(row['interval_score']):.2f}",
        f"{float(row['coverage90']):.0%}",
    )
