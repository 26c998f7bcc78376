"""The histories for checking the fit: drawn from the model, and some difficult ones."""

from collections.abc import Iterator

import numpy as np

from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import OBSERVED_READOUTS
from studies.generated_ledgers import SUBSETS, GeneratedHistory, LedgerRecipe, ledger, random_recipe
from studies.reference_posterior.sampler import Case

SEED = 18
DRAWN_HISTORIES = 20
"""Number of histories from random recipes."""
HARD_RECIPES = {
    "apogees alone, six flights": LedgerRecipe(6, readouts=SUBSETS["apogee"]),
    "one flight, apogee alone": LedgerRecipe(1, readouts=SUBSETS["apogee"]),
    "one flight, all readouts": LedgerRecipe(1),
    "two motors, then a third": LedgerRecipe(8, 2, new_motor=True),
    "one apogee half of what it was": LedgerRecipe(8, 2, outlier=0.5),
    "diameter not recorded": LedgerRecipe(5, readouts=SUBSETS["apogee, speed"], diameter=False),
    "twenty flights, all readouts": LedgerRecipe(20, 3),
}
"""Recipes of the difficult ones by name."""
FLEET = (
    LedgerRecipe(5, 2),
    LedgerRecipe(4, 1, SUBSETS["apogee"]),
    LedgerRecipe(6, 2),
    LedgerRecipe(2, 1, SUBSETS["apogee, speed"]),
)
"""Number of rockets in a ledger; the last one is forecast with information from the others."""


def cases(hyperprior: Hyperprior) -> Iterator[tuple[str, Case]]:
    """Every case and its name."""
    for number in range(DRAWN_HISTORIES):
        rng = np.random.default_rng([SEED, number])
        recipe = random_recipe(rng)
        name = f"{number + 1}: {recipe.flights} flights, {recipe.motors} motors, {_subset(recipe)}"
        yield name, _case(ledger(rng, [recipe], hyperprior)[-1], hyperprior)
    for number, (name, recipe) in enumerate(HARD_RECIPES.items()):
        yield (
            name,
            _case(
                ledger(np.random.default_rng([SEED, DRAWN_HISTORIES + number]), [recipe], hyperprior)[-1], hyperprior
            ),
        )
    histories = ledger(np.random.default_rng([SEED, DRAWN_HISTORIES + len(HARD_RECIPES)]), FLEET, hyperprior)
    shared = shared_prior([rocket_fit(history.flown, hyperprior) for history in histories[:-1]])
    last = histories[-1]
    yield "two flights, three other rockets", Case(last.flown, last.plan, hyperprior, shared)


def _case(history: GeneratedHistory, hyperprior: Hyperprior) -> Case:
    return Case(history.flown, history.plan, hyperprior)


def _subset(recipe: LedgerRecipe) -> str:
    kept = next(name for name, readouts in SUBSETS.items() if readouts == recipe.readouts)
    return f"{kept} ({len(recipe.readouts)} of {len(OBSERVED_READOUTS)})"
