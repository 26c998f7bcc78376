"""The report of `fieldkit paper`, computed from the twelve flights and the paper's network.

Leave-one-out forecasts of a flight, by rules from the simplest to a hierarchical fit.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.inference.network.ensemble import Ensemble, load
from fieldkit.inference.network.posterior import Posterior, infer_paper
from fieldkit.inference.validation.score import score
from fieldkit.model.paper_prior_predictive import APOGEE_NOISE, paper_draws
from fieldkit.motors import catalogue
from fieldkit.physics import paper
from fieldkit.physics.thrust_steps import Burns
from fieldkit.reference.exact import bayes_limit, cells, lowest, reconstructions
from fieldkit.reference.flights import (
    CERTIFIED_NAMES,
    NOMINAL_CD,
    STATED_FIGURES,
    Reference,
    certified,
    errors,
    height_grid,
    heights,
    normalised,
    reference,
)
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
        ForecastRule("nominal_certified", "nominal Cd, certified curves", f"Cd {NOMINAL_CD}, alpha 1", _fixed(curves)),
        ForecastRule(
            "nominal_paper", "nominal Cd, paper's physics", f"Cd {NOMINAL_CD}, alpha 1", _fixed(paper.paper_burns())
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


FRESH_FLIGHTS = 5000
FRESH_SEED = 20_000_000
"""Seed of the flights drawn for the report; training spawns its streams from another seed and never draws these."""


@dataclass(frozen=True, slots=True)
class PassForecast:
    """The network's leave-one-out forecast of one flight: apogee at 5, 50 and 95% [m], and the median Cd and alpha
    [1]."""

    flight_id: str
    apogee: tuple[float, float, float]
    cd: float
    alpha: float

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        low, middle, high = self.apogee
        return {
            "flight_id": self.flight_id,
            "apogee_m": {"p05": low, "p50": middle, "p95": high},
            "cd": self.cd,
            "alpha": self.alpha,
        }


def pass_forecasts(flights: Reference) -> list[PassForecast]:
    """Forecasts of every flight from all other valid flights, in the order flown."""
    flown = [(flight, catalogue().resolve(flight.motor)) for flight in flights.flights]
    found = []
    for row, (flight, motor) in enumerate(flown):
        others = [one for other, one in enumerate(flown) if flights.valid[other] and other != row]
        plan = flight.unflown(sd={}, source={}, tags=())
        forecast = forecast_at_once(others, (plan, motor))
        low, middle, high = (forecast.apogee_at(level) for level in (0.05, 0.5, 0.95))
        cd, alpha = (float(np.exp(mean)) for mean, _ in (forecast.log_cd, forecast.log_alpha))
        found.append(PassForecast(flight.flight_id, (low, middle, high), cd, alpha))
    return found


def pass_errors(flights: Reference, found: list[PassForecast]) -> dict[str, float]:
    """Errors of the medians over the valid flights [m], and the fraction of these in their 90% intervals. [1]"""
    low, middle, high = np.array([one.apogee for one in found])[flights.valid].T
    flown = flights.apogee[flights.valid]
    return {**errors(middle, flown), "coverage90": float(((low <= flown) & (flown <= high)).mean())}


@dataclass(frozen=True, slots=True)
class PaperReport:
    """The parts of the report; the keys of each are those of `fieldkit paper --json`."""

    flights: list[dict[str, Any]]
    reconstruction: dict[str, float]
    published: dict[str, dict[str, float]]
    next_flight: dict[str, float]
    linear_pass: dict[str, float]
    synthetic: dict[str, Any]
    bayes_limit: dict[str, float]
    openrocket: dict[str, float]
    thrust_profile: dict[str, Any]
    rules: list[dict[str, Any]]
    scatter: dict[str, float]
    model: str

    def document(self) -> dict[str, Any]:
        """The report as JSON: the errors of the eight valid flights first, at the top."""
        parts = asdict(self)
        flights, reconstruction = parts.pop("flights"), parts.pop("reconstruction")
        return {"flights": flights, **reconstruction, **parts}


def report(ensemble: Ensemble | None = None) -> PaperReport:
    """Compute the whole report, by default with the shipped ensemble."""
    ensemble = ensemble or load("paper")
    flights = reference()
    found = infer_paper(flights.flights, ensemble)
    curves = paper.paper_burns()
    rebuilt = heights(flights, found.cd, found.alpha, curves)
    left_out = leave_one_out(flights, carried_over(found.cd, found.alpha), np.arange(len(flights)))
    by_pass = pass_forecasts(flights)
    return PaperReport(
        flights=_table(flights, found, rebuilt, left_out, by_pass),
        reconstruction=_errors(flights, rebuilt),
        published={
            "stated": dict(STATED_FIGURES),
            "reconstruction": _errors(flights, flights.published_apogee),
            "parameters_reflown": _simulated_again(flights),
        },
        next_flight=_errors(flights, left_out),
        linear_pass=pass_errors(flights, by_pass),
        synthetic=_synthetic(ensemble),
        bayes_limit=bayes_limit(),
        openrocket=_errors(flights, flights.published_openrocket),
        thrust_profile=_thrust_profile(flights),
        rules=[_judged(flights, rule) for rule in rules(flights)],
        scatter=scatter(flights),
        model=ensemble.name,
    )


def _errors(flights: Reference, forecast: Float[Array, "flight"]) -> dict[str, float]:
    """Errors over the valid flights. [m]"""
    return errors(forecast[flights.valid], flights.apogee[flights.valid])


def _simulated_again(flights: Reference) -> dict[str, float]:
    """Differences between apogees simulated here from the published parameters and the published apogees. [m]"""
    here = heights(flights, flights.published_cd, flights.published_alpha, paper.paper_burns())
    return {"largest_difference_m": float(np.abs(here - flights.published_apogee).max())}


def _table(
    flights: Reference,
    found: Posterior,
    rebuilt: Float[Array, "flight"],
    left_out: Float[Array, "flight"],
    by_pass: list[PassForecast],
) -> list[dict[str, Any]]:
    return [
        {
            "flight_id": flight.flight_id,
            "config": flight.config,
            "motor": flight.motor,
            "tags": list(flight.tags),
            "valid": bool(flights.valid[row]),
            "apogee_m": float(flights.apogee[row]),
            "cd": float(found.cd[row]),
            "cd_sd": float(found.cd_sd[row]),
            "alpha": float(found.alpha[row]),
            "alpha_sd": float(found.alpha_sd[row]),
            "reconstructed_m": float(rebuilt[row]),
            "next_flight_m": float(left_out[row]),
            "linear_pass": by_pass[row].json(),
            "published_cd": float(flights.published_cd[row]),
            "published_alpha": float(flights.published_alpha[row]),
            "published_apogee_m": float(flights.published_apogee[row]),
            "published_openrocket_m": float(flights.published_openrocket[row]),
        }
        for row, flight in enumerate(flights.flights)
    ]


def _synthetic(ensemble: Ensemble) -> dict[str, Any]:
    """Errors and coverage on new flights drawn from the paper's prior."""
    fresh = paper_draws(np.random.default_rng(FRESH_SEED), FRESH_FLIGHTS)
    found = score(ensemble, fresh.features, fresh.truth)
    return {
        "n": FRESH_FLIGHTS,
        "cd_mae": found["cd"]["mae"],
        "alpha_mae": found["alpha"]["mae"],
        "cd_standard_error": found["cd"]["standard_error"],
        "alpha_standard_error": found["alpha"]["standard_error"],
        "cd_coverage_one_sd": found["cd"]["coverage"]["one_sd"],
        "alpha_coverage_one_sd": found["alpha"]["coverage"]["one_sd"],
    }


def _thrust_profile(flights: Reference) -> dict[str, Any]:
    """The impulse of the published profile, and the exact reconstructions with it and without."""
    published = paper.paper_burns()
    valid = flights.part(flights.valid)
    curves = {
        "published": published,
        "impulse_normalised": normalised(),
        "certified": certified(),
        "certified_with_casing": certified(casing=True),
    }
    return {
        "motors": [
            {
                "motor": declared.name,
                "certified_as": name,
                "certified_ns": catalogue().find(name).motor.total_impulse,
                "declared_ns": declared.total_impulse,
                "delivered_ns": declared.delivered_impulse,
            }
            for declared, name in zip(paper.MOTORS, CERTIFIED_NAMES, strict=True)
        ],
        "below_lowest_apogee_of_prior": {
            name: int((valid.apogee < lowest(valid, one)).sum()) for name, one in curves.items()
        },
        "exact_posterior_bias_m": {
            name: float((reconstructions(valid, one) - valid.apogee).mean()) for name, one in curves.items()
        },
    }


def _judged(flights: Reference, rule: ForecastRule) -> dict[str, Any]:
    valid = np.flatnonzero(flights.valid)
    forecast = leave_one_out(flights, rule.forecast, valid)
    known = np.isfinite(forecast)
    judged = errors(forecast[known], flights.apogee[valid[known]])
    return {"rule": rule.key, "title": rule.title, "how": rule.how, **judged}
