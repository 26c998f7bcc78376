"""`fieldkit train`: simulate, train, export."""

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from fieldkit.cli.screen import AsJson, print_json, say
from fieldkit.cli.studies import studies_are_here
from fieldkit.errors import BadValue

app = typer.Typer()


class Recipe(StrEnum):
    """What to train."""

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
    recipe: Annotated[Recipe, typer.Option(help="What to train.")] = Recipe.paper,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulated flights and the networks.")] = 1,
    schedule: Annotated[
        TrainingLength,
        typer.Option(help="The paper's 100 epochs (published), or 10 that reach the same errors (quick)."),
    ] = TrainingLength.quick,
    n_train: Annotated[
        int | None,
        typer.Option(
            min=10,
            help="Simulated flights to train on: 10,000 for paper, a million for field; rockets for history: 13,100.",
        ),
    ] = None,
    effects: Annotated[
        str, typer.Option(help="Effects in the field recipe's flights, separated by commas.", show_default=False)
    ] = "",
    cluster: Annotated[
        str,
        typer.Option(
            help="Simulate flights or histories on Dask workers: local, local:4, or a scheduler's address.",
            show_default=False,
        ),
    ] = "",
    report: Annotated[bool, typer.Option("--report", help="Print the field ensemble's full evaluation.")] = False,
    json: AsJson = False,
) -> None:
    """Train an ensemble on simulated flights; needs the extra `train`."""
    from rich.console import Console
    from rich.progress import Progress

    from fieldkit.inference.training import trainer

    for option, value, known in (
        ("--effects", effects, (Recipe.field,)),
        ("--cluster", cluster, (Recipe.field, Recipe.history)),
    ):
        if value and recipe not in known:
            raise BadValue(f"{option}: found with the recipe {recipe.value}, expected --recipe {known[0].value}")
    beside_exact = recipe is Recipe.field and schedule is TrainingLength.published and studies_are_here()
    train_by_recipe = trainer(recipe.value, out)
    evaluate = _evaluation(recipe, beside_exact)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("training")

        def on_progress(epoch: int, epochs: int, loss: float) -> None:
            progress.update(task, completed=epoch, total=epochs, description=f"loss {loss:.5f}")

        more: dict[str, Any] = {"evaluate": evaluate} | ({} if n_train is None else {"n_train": n_train})
        if names := [name.strip() for name in effects.split(",") if name.strip()]:
            more["effects"] = names
        if cluster:
            more["cluster"] = cluster
        if recipe is Recipe.history:
            from fieldkit.selection.prior import inclusion_probabilities
            from fieldkit.selection.quick_candidates import quick_candidates

            more |= {"candidates_of": quick_candidates, "inclusion": inclusion_probabilities()}
        summary = train_by_recipe(out, seed=seed, schedule=schedule.value, progress=on_progress, **more)
    if json:
        print_json(summary)
        return
    what = "rockets" if recipe is Recipe.history else "flights"
    say(f"Trained {summary['recipe']} on {summary['n_train']} simulated {what} in {summary['seconds']:.0f} s")
    say(f"Mean absolute error on held-out ones: Cd {summary['cd_mae']:.4f}, alpha {summary['alpha_mae']:.4f}")
    for file in summary["files"]:
        say(file)
    if report and recipe is Recipe.field:
        from fieldkit.inference.network.ensemble import read_card
        from fieldkit.inference.validation.field import table

        for line in table(read_card(out)):
            say(line)


def _evaluation(recipe: Recipe, beside_exact: bool) -> Callable[..., dict[str, Any]]:
    """What computes the figures of the card; `beside_exact` compares also with exact posteriors, from the studies of a
    checkout."""
    if recipe is Recipe.history:
        from fieldkit.inference.validation.history import judge

        return judge
    if recipe is Recipe.paper:
        from fieldkit.inference.validation.score import score

        return score
    if beside_exact:
        from studies.validation.restricted_training import evaluate_with_exact

        return evaluate_with_exact
    from fieldkit.inference.validation.field import evaluate

    return evaluate
