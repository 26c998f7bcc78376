"""Random rockets with their models, drawn from the hyperprior for effects or from that for forecasts.

Derivation: what other rockets of the flyer remove from the variance of a parameter is the variance of its mean given
them (law of total variance).
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.inference.history.drawn_rockets import DrawnRocket, Stock, draw_rocket
from fieldkit.inference.history.linear_fit import declared_terms
from fieldkit.inference.history.placed_effects import Candidates, PlacedEffect
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import Model, Term, base_model, shared_names, usual_terms
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.history import history_of

SELECTION_WORLD = 0.55
"""Fraction of rockets drawn from the hyperprior for effects; the others come from the hyperprior for forecasts. [1]"""
SD_SPREAD = 0.25
"""Standard deviation of the logarithm of every standard deviation around the hyperprior's. [1]"""


@dataclass(frozen=True, slots=True)
class ModeledRocket:
    """A drawn rocket with its model, the effects that its model always has, and the candidates for it."""

    rocket: DrawnRocket
    model: Model
    selects: bool
    shared: SharedPrior | None
    always: tuple[Term, ...]
    candidates: dict[str, list[PlacedEffect]]


def modeled_rocket(
    rng: np.random.Generator, choice: Stock, candidates_of: Candidates, flights: int | None
) -> ModeledRocket:
    """A random rocket with `flights` flights, by default a random number. Raises ImpossibleFlight for a flight without
    a dry mass, BadValue for a recovery figure or rail direction that cannot be read, and DamagedModel if the hyperprior
    cannot be read.
    """
    rocket = draw_rocket(rng, choice, flights)
    selects = bool(rng.uniform() < SELECTION_WORLD)
    hyperprior = CERTIFIED_PRIOR if selects else learned()
    sds = {name: sd * float(np.exp(SD_SPREAD * rng.normal())) for name, sd in hyperprior.sds.items()}
    hyperprior = replace(hyperprior, sds=sds)
    used, measured = rocket.used_in_fit, _measured(rocket)
    history = history_of(measured, rocket.found, len(used), used_in_fit=used)
    model = base_model(history, hyperprior)
    shared = None
    if not selects and rng.uniform() < 0.4:
        shared = _others(rng, model)
        model = base_model(history, hyperprior, shared)
    always = usual_terms(model) if selects else declared_terms(measured)
    acting = {term.name.quantity for term in always if term.name.level == "effect"}
    families: dict[str, list[PlacedEffect]] = {}
    for candidate in candidates_of(model):
        if candidate.effect and candidate.effect not in acting:
            families.setdefault(candidate.effect, []).append(candidate)
    return ModeledRocket(rocket, model, selects, shared, tuple(always), families)


def _measured(rocket: DrawnRocket) -> tuple[Flight, ...]:
    """A rocket's flights with a placeholder for each readout, because the biases in the model depend on their
    sources."""
    flown = [
        flight.with_changes(**dict.fromkeys(names, 1.0), source=dict.fromkeys(names, rocket.source))
        for flight, names in zip(rocket.flights, rocket.shows, strict=False)
    ]
    return (*flown, rocket.flights[-1])


def _others(rng: np.random.Generator, model: Model) -> SharedPrior:
    """Information from other rockets of the flyer: other means than the hyperprior's, and smaller standard
    deviations."""
    names = shared_names(model)
    terms = [next(term for term in model.terms if term.name == name) for name in names]
    left = rng.uniform(0.25, 1.0, len(names))
    sds = np.array([term.sd for term in terms])
    mean = np.array([term.mean for term in terms]) + sds * np.sqrt(1 - left**2) * rng.normal(size=len(names))
    return SharedPrior(tuple(names), mean, np.diag((sds * left) ** 2))
