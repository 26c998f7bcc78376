"""Simulation-based calibration of forecasts: `python -m tools.ranks LEDGERS > docs/ranks.md`.

Every ledger is drawn from the model of the forecasts: scales, terms of the rocket and its motors, single flights and
their causes. The next flight is drawn as well, without a cause, and forecast from the others. If the forecast is the
posterior predictive distribution, the rank of the flight among its draws is uniform (Talts, Betancourt, Simpson,
Vehtari and Gelman, Validating Bayesian Inference Algorithms with Simulation-Based Calibration, 2018).
"""

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy import stats

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed, forecast_model
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.posterior import term_sds
from fieldkit.model.causes import USUAL_PROBABILITY, signatures
from fieldkit.model.hyperprior import START, Hyperprior
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, compared, reading_sd
from fieldkit.model.rocket_model import FlownFlight, Model, apogee_scatter
from fieldkit.model.scale import Scale
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.history import flown_and_planned
from fieldkit.shapes import Array, Flags, Float
from tools.markdown import prose

MOTORS = ("F24", "F39", "E35")
READOUTS = ("apogee", "top_speed", "burn_time", "peak_accel", "coast_to_apogee")
FINE = 400
"""Number of values from which a scale is drawn. [1]"""
BINS = 20


def drawn_scale(rng: np.random.Generator, scale: Scale) -> Scale:
    """One value of a scale from its prior; of documents from the values over which a fit sums."""
    fine = scale.refined() if scale.range[0] == scale.range[1] else replace(scale, points=FINE).between(*scale.range)
    chance = np.exp(fine.log_prior - np.logaddexp.reduce(fine.log_prior))
    return replace(scale, grid=(float(rng.choice(fine.values, p=chance)),), step=0.0)


def drawn_readouts(rng: np.random.Generator, model: Model, seen: Flags) -> Float[Array, "flight readout"]:
    """The readouts of all flights of a model with one value of every scale, in SI; the last flight is a usual one.
    `seen` marks the readouts that flights have: only those can be misread."""
    sds, tail = term_sds(model)[0], model.hyperprior.tail
    values = np.array([_within(rng, one.mean, sd, one.low, one.high) for one, sd in zip(model.terms, sds, strict=True)])
    scales = model.scatter_scales()[0]
    flights = len(model.flights)
    scatter = {
        str(kind.bends): kind.sd * scale * rng.normal(size=(1, flights))
        for kind, scale in zip(model.scatter, scales, strict=True)
    }
    expected = shown(model, values[None], scatter)
    raw = np.stack([expected[name][0] for name in OBSERVED_READOUTS], axis=-1)
    (scatter_scale,), (reading_scale,), _ = model.hyperprior.scales()
    sd = reading_sd(raw, model.hyperprior)
    sd = np.where(np.array(OBSERVED_READOUTS) == "apogee", sd, sd * reading_scale)
    sd[:, 0] = np.hypot(sd[:, 0], scatter_scale * apogee_scatter(model))
    error = sd * rng.standard_t(tail, size=raw.shape)
    error[:-1] += drawn_causes(rng, model, values, np.broadcast_to(seen, raw.shape))[:-1]
    return np.where(IS_LOGARITHMIC, raw * np.exp(error), raw + error)


def drawn_causes(
    rng: np.random.Generator, model: Model, at: Float[Array, "term"], seen: Flags
) -> Float[Array, "flight readout"]:
    """The change of every flight's readouts as compared [1] or [s] by its cause, zero on a usual flight."""
    expected = shown(model, at[None], {})
    usual = compared(np.stack([expected[name][0] for name in OBSERVED_READOUTS], axis=-1))
    known = signatures(model, at, usual, seen)
    change = np.zeros_like(usual)
    for row in range(len(usual)):
        chance = np.append(np.exp(known.log_prior[:, row]), USUAL_PROBABILITY)
        drawn = int(rng.choice(len(chance), p=chance / chance.sum()))
        if drawn < len(known.cause):
            change[row] = rng.normal(known.shift[drawn, row], np.abs(known.spread[drawn, row]))
    return change


def _within(rng: np.random.Generator, mean: float, sd: float, low: float, high: float) -> float:
    below, above = (float(stats.norm.cdf(end, mean, sd)) for end in (low, high))
    return float(stats.norm.ppf(rng.uniform(below, above), mean, sd))


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
    readouts = drawn_readouts(rng, replace(model, hyperprior=model.hyperprior.with_scales(*scales)), seen)
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
    for seed in range(count):
        found = rank(np.random.default_rng(seed), START)
        if np.isfinite(found):
            yield found


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
