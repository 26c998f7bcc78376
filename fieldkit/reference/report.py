"""The report of `fieldkit paper`, computed from the twelve flights and the shipped networks."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.inference.network.ensemble import Ensemble, load
from fieldkit.inference.network.posterior import Posterior, infer_paper
from fieldkit.inference.validation.score import score
from fieldkit.model.paper_prior_predictive import paper_draws
from fieldkit.motors import catalogue
from fieldkit.physics import paper
from fieldkit.reference.exact import bayes_limit, lowest, reconstructions
from fieldkit.reference.flights import (
    CERTIFIED_NAMES,
    STATED_FIGURES,
    Reference,
    certified,
    errors,
    heights,
    normalised,
    reference,
)
from fieldkit.reference.next_flight import ForecastRule, carried_over, leave_one_out, rules, scatter
from fieldkit.shapes import Array, Float

FRESH_FLIGHTS = 5000
FRESH_SEED = 20_000_000
"""Seed of the flights drawn for the report; training spawns its streams from another seed and never draws these."""


@dataclass(frozen=True, slots=True)
class HistoryForecast:
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


def history_forecasts(flights: Reference) -> list[HistoryForecast]:
    """Forecasts of every flight from all other valid flights, in the order flown."""
    flown = [(flight, catalogue().resolve(flight.motor)) for flight in flights.flights]
    found = []
    for row, (flight, motor) in enumerate(flown):
        others = [one for other, one in enumerate(flown) if flights.valid[other] and other != row]
        plan = flight.unflown(sd={}, source={}, tags=())
        forecast = forecast_at_once(others, (plan, motor))
        low, middle, high = (forecast.apogee_at(level) for level in (0.05, 0.5, 0.95))
        cd, alpha = (float(np.exp(mean)) for mean, _ in (forecast.log_cd, forecast.log_alpha))
        found.append(HistoryForecast(flight.flight_id, (low, middle, high), cd, alpha))
    return found


def history_errors(flights: Reference, found: list[HistoryForecast]) -> dict[str, float]:
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
    history_network: dict[str, float]
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
    by_history = history_forecasts(flights)
    return PaperReport(
        flights=_table(flights, found, rebuilt, left_out, by_history),
        reconstruction=_errors(flights, rebuilt),
        published={
            "stated": dict(STATED_FIGURES),
            "reconstruction": _errors(flights, flights.published_apogee),
            "parameters_reflown": _simulated_again(flights),
        },
        next_flight=_errors(flights, left_out),
        history_network=history_errors(flights, by_history),
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
    by_history: list[HistoryForecast],
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
            "history_network": by_history[row].json(),
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
