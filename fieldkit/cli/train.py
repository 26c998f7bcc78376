"""`fieldkit train`: simulate, train, export."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from fieldkit.cli.screen import AsJson, print_json, say
from fieldkit.quantities import counted

app = typer.Typer()


class Recipe(StrEnum):
    """What to train: the reference paper's ensemble."""

    paper = "paper"


class TrainingLength(StrEnum):
    """How long to train."""

    quick = "quick"
    published = "published"


@app.command()
def train(
    out: Annotated[Path, typer.Option(help="A new folder for the ensemble and its card.", show_default=False)],
    recipe: Annotated[Recipe, typer.Option(help="What to train.")] = Recipe.paper,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulated flights and the networks.")] = 1,
    schedule: Annotated[
        TrainingLength,
        typer.Option(help="The paper's 100 epochs (published), or 10 that reach the same errors (quick)."),
    ] = TrainingLength.quick,
    n_train: Annotated[int, typer.Option(min=10, help="Number of simulated flights.")] = 10_000,
    json: AsJson = False,
) -> None:
    """Train an ensemble on simulated flights; needs the extra `train`."""
    from rich.console import Console
    from rich.progress import Progress

    from fieldkit.inference.training import trainer
    from fieldkit.inference.validation.score import score

    train_by_recipe = trainer(recipe.value, out)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("training")

        def on_progress(epoch: int, epochs: int, loss: float) -> None:
            progress.update(task, completed=epoch, total=epochs, description=f"loss {loss:.5f}")

        summary = train_by_recipe(
            out, evaluate=score, seed=seed, schedule=schedule.value, n_train=n_train, progress=on_progress
        )
    if json:
        print_json(summary)
        return
    flights = counted(summary["n_train"], "simulated flight")
    say(f"Trained {summary['recipe']} on {flights} in {summary['seconds']:.0f} s")
    say(f"Mean absolute error on held-out ones: Cd {summary['cd_mae']:.4f}, alpha {summary['alpha_mae']:.4f}")
    for file in summary["files"]:
        say(file)
