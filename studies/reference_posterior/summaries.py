"""Reference posteriors as a file: the flights, quantiles and some draws of each, and their comparison with the fit."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.flight import FIELDS, Flight
from fieldkit.model.hyperprior import Hyperprior, read_card
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.motors import Found, catalogue
from fieldkit.shapes import Array, Float
from studies.reference_posterior.sampler import FIGURES, Case, SampledPosterior, next_flight, quantiles, summary_of_fit

LEVELS = (0.05, 0.5, 0.95)
STORED_DRAWS = 200
"""Number of stored draws of each posterior."""
DIGITS = 4
"""Decimals of stored logarithms."""


@dataclass(frozen=True, slots=True)
class ReferencePosterior:
    """A case, quantiles of `FIGURES` from the exact sampler and from a sampler of the linear model, and some exact
    draws.

    `excess_crps` is that of the fit's forecast of the apogee at the time of sampling [1].
    """

    name: str
    case: Case
    quantiles: Float[Array, "level figure"]
    linear: Float[Array, "level figure"]
    draws: Float[Array, "draw figure"]
    r_hat: float
    effective: float
    excess_crps: float


def summarized(
    name: str, case: Case, exact: SampledPosterior, linear: SampledPosterior, seed: int
) -> ReferencePosterior:
    """The stored summary of a case."""
    figures = next_flight(case, exact.terms, exact.scales, seed)
    thin = figures[np.linspace(0, len(figures) - 1, STORED_DRAWS).astype(int)]
    by_linear = quantiles(next_flight(case, linear.terms, linear.scales, seed), LEVELS)
    forecast = summary_of_fit(case, len(figures), seed)
    excess = excess_crps(np.exp(forecast[:, 0]), np.exp(figures[:, 0]))
    return ReferencePosterior(
        name, case, quantiles(figures, LEVELS), by_linear, thin, exact.r_hat, exact.effective, excess
    )


def off(
    forecast: Float[Array, "level figure"], reference: Float[Array, "level figure"]
) -> Float[Array, "level figure"]:
    """Differences of quantiles from the reference's, as fractions of its 90% interval. [1]"""
    return np.asarray((forecast - reference) / (reference[-1] - reference[0]))


def excess_crps(forecast: Float[Array, "draw"], exact: Float[Array, "draw"]) -> float:
    """Relative excess of a forecast's expected CRPS over the exact forecast's. [1]

    With the truth drawn from the exact forecast, the difference is the integral of the squared difference of their
    distribution functions, and the exact forecast's CRPS is the integral of F (1 - F).
    """
    grid = np.sort(np.concatenate([forecast, exact]))
    by = [np.searchsorted(np.sort(draws), grid[:-1], side="right") / len(draws) for draws in (forecast, exact)]
    width = np.diff(grid)
    return float(((by[0] - by[1]) ** 2 @ width) / ((by[1] * (1 - by[1])) @ width))


def write(path: Path, references: list[ReferencePosterior], about: Mapping[str, Any]) -> None:
    """Save references as JSON, one case per line."""
    lines = [json.dumps(_kept(one), separators=(",", ":")) for one in references]
    head = json.dumps({**about, "hyperprior": references[0].case.hyperprior.json()}, indent=1)[:-2]
    path.write_text(head + ',\n "cases": [\n' + ",\n".join(lines) + "\n]}\n", encoding="utf-8")


def read(path: Path) -> list[ReferencePosterior]:
    """The references in a file."""
    kept = json.loads(path.read_text("utf-8"))
    hyperprior = read_card(json.dumps(kept["hyperprior"]), path.name)
    return [_read(one, hyperprior) for one in kept["cases"]]


def _kept(one: ReferencePosterior) -> dict[str, Any]:
    case = one.case
    return {
        "name": one.name,
        "figures": list(FIGURES),
        "flights": [_flight(flight, found) for flight, found in case.flown],
        "plan": _flight(*case.plan),
        "shared": _shared(case.shared) if case.shared else None,
        "r_hat": round(one.r_hat, 3),
        "effective": round(one.effective),
        "excess_crps": round(one.excess_crps, DIGITS),
        **{name: np.round(getattr(one, name), DIGITS).tolist() for name in ("quantiles", "linear", "draws")},
    }


def _read(kept: Mapping[str, Any], hyperprior: Hyperprior) -> ReferencePosterior:
    shared = kept["shared"]
    prior = (
        SharedPrior(
            tuple(TermName(*name) for name in shared["names"]), np.array(shared["mean"]), np.array(shared["covariance"])
        )
        if shared
        else None
    )
    case = Case(tuple(map(_flown, kept["flights"])), _flown(kept["plan"]), hyperprior, prior)
    by_exact, by_linear, draws = (np.array(kept[name]) for name in ("quantiles", "linear", "draws"))
    return ReferencePosterior(
        kept["name"], case, by_exact, by_linear, draws, kept["r_hat"], kept["effective"], kept["excess_crps"]
    )


def _flight(flight: Flight, found: Found) -> dict[str, Any]:
    """A flight's recorded fields, numbers to six digits."""
    values = {name: getattr(flight, name) for name in FIELDS if getattr(flight, name) not in (None, "", (), {})}
    short = {name: float(f"{x:.6g}") if isinstance(x, float) else x for name, x in values.items()}
    when = flight.date_time.isoformat() if flight.date_time else None
    return short | {"date_time": when, "maker": found.motor.maker}


def _flown(kept: Mapping[str, Any]) -> tuple[Flight, Found]:
    fields = {name: value for name, value in kept.items() if name != "maker"}
    when = datetime.fromisoformat(fields["date_time"]) if fields["date_time"] else None
    flight = Flight(**{**fields, "tags": tuple(fields.get("tags", ())), "date_time": when})
    return flight, catalogue().resolve(flight.motor, kept["maker"])


def stored(case: Case) -> Case:
    """The case after a round trip through JSON, so that the sampled case is the stored one."""
    hyperprior = read_card(json.dumps(case.hyperprior.json()), "the case")
    flown = tuple(_flown(json.loads(json.dumps(_flight(*one)))) for one in case.flown)
    plan = _flown(json.loads(json.dumps(_flight(*case.plan))))
    return replace(case, flown=flown, plan=plan, hyperprior=hyperprior)


def _shared(prior: SharedPrior) -> dict[str, Any]:
    return {"names": list(prior.names), "mean": prior.mean.tolist(), "covariance": prior.covariance.tolist()}
