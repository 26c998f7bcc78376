"""Simulation-based calibration of forecasts over the hyperprior: python -m studies.calibration [--table FILE].

Ledgers are drawn from the model; the next flight of one rocket is forecast with information from the ledger's other
rockets. If fit and forecast are right, the rank of the truth among the forecast's draws is uniform (Talts, Betancourt,
Simpson, Vehtari and Gelman, 2018). Uniformity is tested simultaneously at all points (Säilynoja, Bürkner and Vehtari,
2022).
"""

import argparse
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import fly_ahead, learn
from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.simulated_readouts import bent
from fieldkit.parallel import processes
from fieldkit.physics.history import flown_and_planned
from fieldkit.shapes import Array, Float
from studies.generated_ledgers import SUBSETS, GeneratedHistory, ledger, random_recipe

SEED = 2018
LEDGERS = 1000
CHUNK = 10
ROCKETS = 4
"""Maximum number of rockets in a ledger."""
DRAWS = 999
"""Number of draws of each forecast, and the maximum rank."""
UNIFORM_SIMULATIONS = 2000
"""Number of sets of uniform ranks for the null distribution."""
PLACES = 50
"""Points at which distribution functions are compared."""


@dataclass(frozen=True, slots=True)
class TruthRank:
    """A forecast and the fraction of its draws below the truth: of the apogee and of the rocket's log Cd. [1]"""

    flights: int
    readouts: tuple[str, ...]
    others: int
    new_motor: bool
    apogee: float
    log_cd: float


def ranked(number: int, hyperprior: Hyperprior, *, rockets: int = ROCKETS, flights: int | None = None) -> TruthRank:
    """Draw a ledger, forecast the next flight of its last rocket, and rank the truth. The last rocket has flown
    `flights`, by default a random number."""
    rng = np.random.default_rng([SEED, number])
    recipes = [random_recipe(rng) for _ in range(int(rng.integers(1, rockets + 1)))]
    if flights is not None:
        recipes[-1] = replace(recipes[-1], flights=flights, motors=min(recipes[-1].motors, flights))
    histories = ledger(rng, recipes, hyperprior)
    asked = histories[-1]
    shared = shared_prior([rocket_fit(history.flown, hyperprior) for history in histories[:-1]])
    fitted = learn(
        flown_and_planned(asked.flown, [asked.plan]),
        Assumed(shared=shared, hyperprior=hyperprior),
        draws=DRAWS,
        seed=number,
    )
    (prediction,) = fly_ahead(fitted)
    log_cd = bent(fitted.model, fitted.values, "drag")[:, 0]
    flown = {found.motor.designation for _, found in asked.flown}
    readouts = next(kept for kept in SUBSETS.values() if set(kept) >= _seen(asked) and len(kept) >= len(_seen(asked)))
    return TruthRank(
        len(asked.flown),
        readouts,
        len(histories) - 1,
        asked.plan[1].motor.designation not in flown,
        rank(prediction.apogee, asked.truth.apogee, rng),
        rank(log_cd, asked.truth.log_cd, rng),
    )


def _ranked(number: int, flights: int | None) -> TruthRank:
    return ranked(number, learned(), flights=flights)


def _seen(history: GeneratedHistory) -> set[str]:
    return {name for flight, _ in history.flown for name in flight.readouts()}


def rank(draws: Float[Array, "draw"], truth: float, rng: np.random.Generator) -> float:
    """The fraction of draws below the truth, randomized between two draws so that it is continuous and uniform. [1]"""
    return float((np.sum(draws < truth) + rng.uniform()) / (len(draws) + 1))


def uniformity(ranks: Float[Array, "forecast"], seed: int = 0) -> float:
    """p-value of the ranks' uniformity. [1]

    At each of `PLACES` the number of ranks below is binomial; the statistic is the least likely point, compared with
    sets of uniform ranks of the same size.
    """
    from scipy.stats import binom

    count = len(ranks)
    places = np.arange(1, PLACES) / PLACES
    counts = np.arange(count + 1)[:, None]
    tail = np.minimum(binom.cdf(counts, count, places), binom.sf(counts - 1, count, places))

    def least(values: Array) -> Array:
        below = np.stack([(values < place).sum(axis=-1) for place in places], axis=-1)
        return np.asarray(tail[below, np.arange(len(places))].min(axis=-1))

    chance = least(np.random.default_rng(seed).uniform(size=(UNIFORM_SIMULATIONS, count)))
    return float((np.sum(chance <= least(ranks)) + 1) / (UNIFORM_SIMULATIONS + 1))


def coverage(ranks: Float[Array, "forecast"], level: float) -> float:
    """Fraction of truths inside the central interval of a level. [1]"""
    return float((np.abs(ranks - 0.5) < level / 2).mean())


def _with(readouts: tuple[str, ...]) -> Callable[[TruthRank], bool]:
    return lambda one: one.readouts == readouts


GROUPS: Mapping[str, Callable[[TruthRank], bool]] = {
    "all": lambda one: True,
    "1 flight": lambda one: one.flights == 1,
    "2 or 3 flights": lambda one: 2 <= one.flights <= 3,
    "4 to 7 flights": lambda one: 4 <= one.flights <= 7,
    "8 to 12 flights": lambda one: one.flights >= 8,
    **{f"readouts: {name}": _with(readouts) for name, readouts in SUBSETS.items()},
    "no other rocket": lambda one: one.others == 0,
    "other rockets": lambda one: one.others > 0,
    "on a motor flown before": lambda one: not one.new_motor,
    "on a new motor": lambda one: one.new_motor,
}
"""Groups of forecasts by their data."""


def table(found: Sequence[TruthRank]) -> list[str]:
    """Coverage at 50 and 90% with the range expected by chance, mean rank and uniformity, one line per group."""
    lines = [f"{'':26s} {'':>5s} {'apogee':^34s}  {'log Cd':^34s}"]
    columns = f"{'50%':>7s} {'90%':>7s} {'rank':>6s} {'uniform':>10s}"
    lines.append(f"{'':26s} {'cases':>5s} {columns:>34s}  {columns:>34s}  90% by chance")
    for name, belongs in GROUPS.items():
        group = [one for one in found if belongs(one)]
        if group:
            parts = [_figures(np.array([getattr(one, figure) for one in group])) for figure in ("apogee", "log_cd")]
            spread = 100 * 1.645 * np.sqrt(0.09 / len(group))
            lines.append(f"{name:26s} {len(group):5d} {parts[0]:>34s}  {parts[1]:>34s}  ± {spread:.1f}%")
    return lines


def _figures(ranks: Float[Array, "forecast"]) -> str:
    half, most = (100 * coverage(ranks, level) for level in (0.5, 0.9))
    return f"{half:6.1f}% {most:6.1f}% {ranks.mean():6.3f}  p={uniformity(ranks):6.4f}"


def main(arguments: list[str] | None = None) -> None:
    """Read the command line, draw ledgers and forecast, print the table and save it if requested."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ledgers", type=int, default=LEDGERS)
    parser.add_argument("--flights", type=int, metavar="N", help="Every rocket that is forecast has flown N times.")
    parser.add_argument("--table", type=Path, metavar="FILE")
    asked = parser.parse_args(arguments)
    with processes(os.cpu_count() or 1) as pool:
        found = list(pool.map(partial(_ranked, flights=asked.flights), range(asked.ledgers), chunksize=CHUNK))
    text = "\n".join([f"{asked.ledgers} ledgers from seed {SEED}:", "", *table(found), ""])
    sys.stdout.write(text)
    if asked.table:
        asked.table.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
