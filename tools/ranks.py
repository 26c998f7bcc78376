"""Simulation-based calibration of forecasts: `python -m tools.ranks LEDGERS > docs/ranks.md`.

Every ledger is drawn from the model of the forecasts: scales, terms of the rocket and its motors, single flights and
their causes. The next flight is drawn as well, without a cause, and forecast from the others. If the forecast is the
posterior predictive distribution, the rank of the flight among its draws is uniform (Talts, Betancourt, Simpson,
Vehtari and Gelman, Validating Bayesian Inference Algorithms with Simulation-Based Calibration, 2018).
"""

import os
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy import stats

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed, forecast_model
from fieldkit.forecast.predict import predict
from fieldkit.model.hyperprior import START, Hyperprior
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.motors import catalogue
from fieldkit.parallel import processes
from fieldkit.physics.history import flown_and_planned
from fieldkit.shapes import Array, Float
from studies.generated_ledgers import drawn_flights, drawn_scale
from tools.markdown import prose

MOTORS = ("F24", "F39", "E35")
READOUTS = ("apogee", "top_speed", "burn_time", "peak_accel", "coast_to_apogee")
BINS = 20
CHUNK = 10


def rank(rng: np.random.Generator, hyperprior: Hyperprior) -> float:
    """The fraction of the draws of a forecast below the flight, for one ledger; nan if one stays on the pad. [1]"""
    count = int(rng.integers(1, 9))
    kept = READOUTS if rng.uniform() < 0.5 else READOUTS[:1]
    plans: list[FlownFlight] = []
    for turn in range(count + 1):
        motor = str(rng.choice(MOTORS[: int(rng.integers(1, 4))]))
        flight = Flight(str(turn), "R", "A", motor, dry_mass=float(rng.uniform(0.25, 0.45)), diameter=0.066)
        plans.append((flight, catalogue().resolve(motor)))
    model = forecast_model(flown_and_planned(plans), hyperprior=hyperprior)
    scales = [drawn_scale(rng, one) for one in model.hyperprior.unknown_scales]
    seen = np.isin(OBSERVED_READOUTS, kept)
    readouts = drawn_flights(rng, replace(model, hyperprior=model.hyperprior.with_scales(*scales)), seen).readouts
    if not np.isfinite(readouts).all(where=np.isin(OBSERVED_READOUTS, READOUTS)):
        return np.nan
    figures = [dict(zip(OBSERVED_READOUTS, row.tolist(), strict=True)) for row in readouts]
    flown = [
        (flight.with_changes(**{name: own[name] for name in kept}), motor)
        for (flight, motor), own in zip(plans, figures, strict=True)
    ]
    draws_of_its_own = int(
        rng.integers(2**31)
    )  # with the same draws in all ledgers, their ranks would not be independent
    (made,) = predict(flown[:-1], [plans[-1]], Assumed(hyperprior=hyperprior), seed=draws_of_its_own)
    return float(np.mean(made.apogee < figures[-1]["apogee"]))


def ranks(count: int) -> Iterator[float]:
    """The ranks of some ledgers, each with its own seed."""
    with processes(os.cpu_count() or 1) as pool:
        yield from (found for found in pool.map(_rank, range(count), chunksize=CHUNK) if np.isfinite(found))


def _rank(seed: int) -> float:
    return rank(np.random.default_rng(seed), START)


def page(found: Float[Array, "ledger"]) -> Iterator[str]:
    """The page about some ranks."""
    counts = np.histogram(found, BINS, (0.0, 1.0))[0]
    low, high = 0.05, 0.95
    yield "# Ranks of simulated flights in their forecasts\n"
    yield "Written by `python -m tools.ranks LEDGERS`.\n"
    yield from prose(" ".join((__doc__ or "").split("\n\n", 1)[1].split()))
    yield ""
    yield "| ledgers | mean rank | below 5% | above 95% | chi-square, p | Kolmogorov-Smirnov, p |"
    yield "|---|---|---|---|---|---|"
    yield (
        f"| {len(found)} | {found.mean():.3f} | {np.mean(found < low):.1%} | {np.mean(found > high):.1%} | "
        f"{stats.chisquare(counts).pvalue:.2g} | {stats.kstest(found, 'uniform').pvalue:.2g} |"
    )
    yield ""
    yield f"Ledgers in each twentieth of the ranks: {', '.join(map(str, counts.tolist()))}."


if __name__ == "__main__":
    print(*page(np.array(list(ranks(int(sys.argv[1]))))), sep="\n")
