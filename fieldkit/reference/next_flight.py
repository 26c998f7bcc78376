"""Leave-one-out forecasts of a flight, by rules from the simplest to a hierarchical fit."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.model.paper_prior_predictive import APOGEE_NOISE
from fieldkit.physics import paper
from fieldkit.physics.thrust_steps import Burns
from fieldkit.reference.exact import cells
from fieldkit.reference.flights import NOMINAL_CD, Reference, certified, height_grid, heights
from fieldkit.shapes import Array, Float, Int

ForecastBy = Callable[[Reference, Int[Any, "other"], int], float]
"""The apogee of a flight, given by its row, from other flights, given by their rows; nan if they are not informative.
[m]"""


@dataclass(frozen=True, slots=True)
class ForecastRule:
    """A forecasting rule with its exact description in `how`."""

    key: str
    title: str
    how: str
    forecast: ForecastBy


def leave_one_out(flights: Reference, forecast: ForecastBy, rows: Int[Any, "row"]) -> Float[Array, "row"]:
    """Forecasts of some flights, each from all other valid flights. [m]"""
    valid = np.flatnonzero(flights.valid)
    return np.array([forecast(flights, valid[valid != row], row) for row in rows.tolist()])


def _same_motor(flights: Reference, others: Int[Any, "other"], row: int) -> float:
    peers = others[flights.motor[others] == flights.motor[row]]
    return float(flights.apogee[peers].mean()) if len(peers) else np.nan


def _same_setup(flights: Reference, others: Int[Any, "other"], row: int) -> float:
    return _same_motor(flights, others[flights.dry_mass[others] == flights.dry_mass[row]], row)


def carried_over(cd: Float[Array, "flight"], alpha: Float[Array, "flight"]) -> ForecastBy:
    """Mean Cd and alpha inferred for the same motor's other flights, in the paper's physics. [1]"""
    curves = paper.paper_burns()
    return carry_over(cd, alpha, lambda flights, cd, alpha: heights(flights, cd, alpha, curves))


def carry_over(
    cd: Float[Array, "flight"],
    alpha: Float[Array, "flight"],
    fly: Callable[[Reference, Float[Array, "flight"], Float[Array, "flight"]], Float[Array, "flight"]],
) -> ForecastBy:
    """Mean Cd and alpha inferred for the same motor's other flights, in any physics. [1]"""

    def forecast(flights: Reference, others: Int[Any, "other"], row: int) -> float:
        peers = others[flights.motor[others] == flights.motor[row]]
        if not len(peers):
            return np.nan
        one = flights.part(np.array([row]))
        return float(fly(one, np.array([cd[peers].mean()]), np.array([alpha[peers].mean()]))[0])

    return forecast


def _fixed(curves: Burns) -> ForecastBy:
    """Nominal Cd and certified thrust: no flight is used."""
    return lambda flights, others, row: _apogee(flights, row, NOMINAL_CD, 1.0, curves)


def _fitted(curves: Burns, *, cd_too: bool) -> ForecastBy:
    """One alpha, and one Cd if `cd_too`, for all flights, by least squares."""
    start, low, high = ([1.0, NOMINAL_CD], [0.3, 0.05], [2.0, 2.0])
    count = 2 if cd_too else 1

    def forecast(flights: Reference, others: Int[Any, "other"], row: int) -> float:
        from scipy.optimize import least_squares

        known = flights.part(others)

        def misses(fitted: Float[Array, "parameter"]) -> Float[Array, "flight"]:
            alpha, cd = (*fitted, NOMINAL_CD)[:2]
            return heights(known, np.full(len(known), cd), np.full(len(known), alpha), curves) - known.apogee

        best = least_squares(misses, start[:count], bounds=(low[:count], high[:count])).x
        alpha, cd = (*best, NOMINAL_CD)[:2]
        return _apogee(flights, row, cd, alpha, curves)

    return forecast


def _hierarchical(flights: Reference, curves: Burns) -> ForecastBy:
    """One Cd for the rocket, an alpha for each flight around a mean, and their scatter, on a grid.

    Priors: Cd normal 0.6 ± 0.17, mean alpha normal 1 ± 0.12 (the moments of the paper's prior), standard
    deviation of a flight's alpha uniform up to 0.2. The forecast is the posterior mean of the apogee.
    """
    cd, alpha = cells((0.1, 1.2), 60), cells((0.6, 1.4), 80)
    scatter = cells((0.0, 0.2), 20)[:, None, None, None]
    grid = height_grid(flights, cd, alpha, curves)
    variance = (np.gradient(grid, alpha, axis=2) * scatter) ** 2 + APOGEE_NOISE**2
    fit = -0.5 * ((grid - flights.apogee[:, None, None]) ** 2 / variance + np.log(variance))
    prior = -0.5 * (((cd[:, None] - 0.6) / 0.17) ** 2 + ((alpha - 1.0) / 0.12) ** 2)

    def forecast(_: Reference, others: Int[Any, "other"], row: int) -> float:
        evidence = fit[:, others].sum(axis=1) + prior
        weight = np.exp(evidence - evidence.max()).sum(axis=0)
        return float((weight * grid[row]).sum() / weight.sum())

    return forecast


def _apogee(flights: Reference, row: int, cd: float, alpha: float, curves: Burns) -> float:
    return float(heights(flights.part(np.array([row])), np.array([cd]), np.array([alpha]), curves)[0])


def rules(flights: Reference) -> list[ForecastRule]:
    """The rules that the report compares, starting with the best on the eight valid flights."""
    curves = certified()
    return [
        ForecastRule("motor_mean", "mean of the same motor's other flights", "no physics at all", _same_motor),
        ForecastRule(
            "motor_and_config_mean",
            "mean of the same motor and configuration",
            "only flights that have such a peer",
            _same_setup,
        ),
        ForecastRule(
            "alpha_certified",
            f"one alpha for all, Cd {NOMINAL_CD}, certified curves",
            "least squares",
            _fitted(curves, cd_too=False),
        ),
        ForecastRule(
            "hierarchical_certified",
            "hierarchical, certified curves",
            "Cd of the rocket 0.6 ± 0.17, alpha of a flight around a mean of 1 ± 0.12, scatter up to 0.2",
            _hierarchical(flights, curves),
        ),
        ForecastRule(
            "cd_and_alpha_certified",
            "one Cd and one alpha for all, certified",
            "least squares",
            _fitted(curves, cd_too=True),
        ),
        ForecastRule(
            "published_carried_over",
            "published parameters carried over",
            "mean Cd and alpha of the same motor's other flights, paper's physics",
            carried_over(flights.published_cd, flights.published_alpha),
        ),
        ForecastRule(
            "nominal_casing",
            "nominal Cd, certified curves and casing mass",
            f"Cd {NOMINAL_CD}, alpha 1",
            _fixed(certified(casing=True)),
        ),
        ForecastRule(
            "nominal_certified",
            "nominal Cd, certified curves",
            f"Cd {NOMINAL_CD}, alpha 1",
            _fixed(curves),
        ),
        ForecastRule(
            "nominal_paper",
            "nominal Cd, paper's physics",
            f"Cd {NOMINAL_CD}, alpha 1",
            _fixed(paper.paper_burns()),
        ),
    ]


def scatter(flights: Reference) -> dict[str, float]:
    """The pooled scatter of valid flights of one motor and configuration, and the resulting minimum error of any rule.

    `sd_m` has `degrees_of_freedom`. With normal scatter of this size, a perfect forecast of the mean has the mean
    absolute error `perfect_mae_m`, and the mean of two earlier flights `two_peers_mae_m`.
    """
    valid = flights.part(flights.valid)
    setups = np.stack([valid.motor, valid.dry_mass], axis=-1)
    groups = [valid.apogee[(setups == setup).all(axis=1)] for setup in np.unique(setups, axis=0)]
    freedom = sum(len(group) - 1 for group in groups)
    sd = np.sqrt(sum(((group - group.mean()) ** 2).sum() for group in groups) / freedom)
    mean_miss = sd * np.sqrt(2 / np.pi)
    return {
        "sd_m": float(sd),
        "degrees_of_freedom": freedom,
        "perfect_mae_m": float(mean_miss),
        "two_peers_mae_m": float(mean_miss * np.sqrt(1.5)),
    }
