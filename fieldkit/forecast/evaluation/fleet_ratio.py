"""The fleet ratio: a normal model of log(apogee flown / simulated) with a mean, a rocket effect and Student-t flights.

It uses no physics except the uncalibrated simulation, has six lines of algebra, and is fitted again before each flight.

Source: the weights of a Student t (Lange, Little and Taylor, 1989).
Derivation: the posterior of a normal random-effects model with known variances.
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.forecast.evaluation.uncalibrated import Simulated
from fieldkit.shapes import Array, Float, Int, Integers

MEAN, MEAN_SD = float(np.log(0.85)), 0.1
"""Prior mean and standard deviation of the log ratio over all rockets: sport flights reach 0.85 of the simulated
apogee. [1]"""
ROCKET_SD, FLIGHT_SD, FREEDOM = 0.2, 0.15, 4.0
"""Standard deviations of rockets and flights, and the degrees of freedom of the flights' Student t. [1]"""
DRAWS, SEED = 2000, 1
ITERATIONS, TOLERANCE = 50, 1e-6
"""Maximum number of reweighting steps, and the convergence tolerance of the mean. [1]"""


def fleet_ratio(earlier: Sequence[Simulated], plan: Simulated) -> Float[Array, "draw"]:
    """Predictive draws of the apogee, from the earlier flights of all rockets. [m]"""
    known = [one for one in earlier if np.isfinite(one.ratio)]
    rockets = [plan.flight.rocket, *(one.flight.rocket for one in known)]
    _, group = np.unique(rockets, return_inverse=True)
    mean, variance = ratio_posterior(np.log([one.ratio for one in known]), group[1:], int(group[0]))
    rng = np.random.default_rng(SEED)
    center = mean + np.sqrt(variance) * rng.normal(size=DRAWS)
    return np.asarray(plan.simulated * np.exp(center + FLIGHT_SD * rng.standard_t(FREEDOM, DRAWS)))


def ratio_posterior(logs: Float[Array, "flight"], rocket: Int[Integers, "flight"], wanted: int) -> tuple[float, float]:
    """Posterior mean and variance of the expected log ratio of one rocket, from those of flights of numbered rockets.
    [1]

    A Student t is a normal whose precision has a gamma prior; its expectation given the fit so far weights each flight
    (expectation maximization; Lange, Little and Taylor, 1989).
    """
    count = max(int(rocket.max(initial=0)), wanted) + 1
    weight = np.ones(len(logs))
    before = np.inf
    for _ in range(ITERATIONS):
        precision = np.diag(np.r_[MEAN_SD**-2.0, np.full(count, ROCKET_SD**-2.0)])
        each = weight / FLIGHT_SD**2
        own = np.bincount(rocket, each, count)
        precision[0, 0] += own.sum()
        precision[0, 1:] += own
        precision[1:, 0] += own
        precision[np.arange(1, count + 1), np.arange(1, count + 1)] += own
        moved = each * (logs - MEAN)
        covariance = np.linalg.inv(precision)
        effect = covariance @ np.r_[moved.sum(), np.bincount(rocket, moved, count)]
        spread = covariance[0, 0] + 2 * covariance[0, 1:] + np.diag(covariance)[1:]
        mean = float(MEAN + effect[0] + effect[1 + wanted])
        missed = (logs - MEAN - effect[0] - effect[1 + rocket]) ** 2 + spread[rocket]
        weight = (FREEDOM + 1) / (FREEDOM + missed / FLIGHT_SD**2)
        if abs(mean - before) < TOLERANCE:
            break
        before = mean
    return mean, float(spread[wanted])
