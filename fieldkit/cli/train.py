"""`fieldkit train`: simulate, train, export."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from fieldkit.cli.screen import AsJson, print_json, say
from fieldkit.errors import BadValue

app = typer.Typer()


class Recipe(StrEnum):
    """What to train: the reference paper's ensemble, or the forecast model's network, which is used in the field."""

    paper = "paper"
    field = "field"
    history = "history"


class TrainingLength(StrEnum):
    """How long to train."""

    quick = "quick"
    published = "published"


@app.command()
def train(
    out: Annotated[Path, typer.Option(help="A new folder for the ensemble and its card.", show_default=False)],
    recipe: Annotated[Recipe, typer.Option(help="What to train; field is another name of history.")] = Recipe.paper,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulated flights and the networks.")] = 1,
    schedule: Annotated[
        TrainingLength,
        typer.Option(help="The paper's 100 epochs (published), or 10 that reach the same errors (quick)."),
    ] = TrainingLength.quick,
    n_train: Annotated[
        int | None,
        typer.Option(
            min=10,
            help="By default 10,000 simulated flights for paper, 13,100 simulated rockets for history.",
        ),
    ] = None,
    effects: Annotated[
        str,
        typer.Option(
            help="The only effects in the simulated histories, separated by commas; all by default.", show_default=False
        ),
    ] = "",
    cluster: Annotated[
        str,
        typer.Option(
            help="Simulate histories on Dask workers: local, local:4, or a scheduler's address.",
            show_default=False,
        ),
    ] = "",
    json: AsJson = False,
) -> None:
    """Train an ensemble on simulated flights; needs the extra `train`."""
    from rich.console import Console
    from rich.progress import Progress

    from fieldkit.inference.training import trainer

    recipe = Recipe.history if recipe is Recipe.field else recipe
    for option, value in (("--effects", effects), ("--cluster", cluster)):
        if value and recipe is Recipe.paper:
            raise BadValue(f"{option}: found with the recipe paper, expected --recipe history")
    train_by_recipe = trainer(recipe.value, out)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("training")

        def on_progress(epoch: int, epochs: int, loss: float) -> None:
            progress.update(task, completed=epoch, total=epochs, description=f"loss {loss:.5f}")

        more: dict[str, Any] = {} if n_train is None else {"n_train": n_train}
        if recipe is Recipe.history:
            from fieldkit.inference.validation.history import judge
            from fieldkit.selection.prior import inclusion_of
            from fieldkit.selection.quick_candidates import quick_candidates

            names = [name.strip() for name in effects.split(",") if name.strip()]
            more |= {"evaluate": judge, "candidates_of": quick_candidates, "inclusion": inclusion_of(names)}
            more |= {"cluster": cluster, "effects": names}
        else:
            from fieldkit.inference.validation.score import score

            more["evaluate"] = score
        summary = train_by_recipe(out, seed=seed, schedule=schedule.value, progress=on_progress, **more)
    if json:
        print_json(summary)
        return
    what = "rockets" if recipe is Recipe.history else "flights"
    say(f"Trained {summary['recipe']} on {summary['n_train']} simulated {what} in {summary['seconds']:.0f} s")
    say(f"Mean absolute error on held-out ones: Cd {summary['cd_mae']:.4f}, alpha {summary['alpha_mae']:.4f}")
    for file in summary["files"]:
        say(file)
