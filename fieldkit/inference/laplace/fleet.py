"""What one rocket's flights say of the terms that all rockets of a flyer share, and what many say together.

Given the shared terms (those of the fleet, and of motor types) rockets are independent. Each one's fit, by itself, is
a normal posterior of the shared terms; divided by their prior it is the rocket's message, a likelihood. The prior times
the messages of other rockets is what a rocket starts from: exact for a linear model, belief propagation otherwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import Model, base_model, shared_names
from fieldkit.model.shared_prior import Message, SharedPrior, combined
from fieldkit.motors import Found
from fieldkit.shapes import Array

FlownFlights = Sequence[tuple[Flight, Found]]


@dataclass(frozen=True, slots=True, eq=False)
class RocketFit:
    """A rocket's fit by itself: its log evidence [nat], and its message to the rest of the fleet."""

    log_evidence: float
    message: Message
    prior: SharedPrior


def rocket_fit(flown: FlownFlights, hyperprior: Hyperprior) -> RocketFit:
    """Fit the clean flights of one rocket with nothing known of others."""
    flights, found = [flight for flight, _ in flown], [motor for _, motor in flown]
    model = replace(base_model(flights, found, hyperprior), coarse=True)
    result = fit_robustly(model, observe(flights, [flight.clean for flight in flights], hyperprior))
    return RocketFit(result.log_evidence, message_of(result), independent_prior([model]))


def message_of(result: Fit) -> Message:
    """The posterior of the shared terms over their prior.

    The mixture over scales is taken as the normal distribution of its moments. If scales disagree that may be wider
    in some direction than the prior; there the message says nothing.
    """
    names = shared_names(result.model)
    rows = [result.model.names.index(name) for name in names]
    weights, mean = result.weights, result.mean[:, rows]
    middle = weights @ mean
    covariance = np.einsum("s,sij->ij", weights, result.covariance[:, rows][:, :, rows])
    covariance += np.einsum("s,si,sj->ij", weights, mean - middle, mean - middle)
    prior_mean = np.array([result.model.terms[row].mean for row in rows])
    prior_sd = np.array([result.model.terms[row].sd for row in rows])
    # in units of the prior, where the message's precision is that of the posterior less one
    values, vectors = np.linalg.eigh(covariance / np.outer(prior_sd, prior_sd))
    gained = np.maximum(1 / np.maximum(values, 1e-9) - 1, 0.0)
    moved = vectors.T @ ((middle - prior_mean) / prior_sd)
    precision = (vectors * gained) @ vectors.T / np.outer(prior_sd, prior_sd)
    shift = (vectors @ ((gained + (gained > 0)) * moved)) / prior_sd
    return Message(tuple(names), _symmetric(precision), shift)


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T))


def independent_prior(models: Sequence[Model]) -> SharedPrior:
    """The prior of every shared term of some models, independent as the hyperprior has them."""
    terms = {term.name: term for model in models for term in model.terms if term.name in set(shared_names(model))}
    means, sds = (np.array([getattr(term, name) for term in terms.values()]) for name in ("mean", "sd"))
    return SharedPrior(tuple(terms), means, np.diag(sds**2))


def merged(priors: Sequence[SharedPrior]) -> SharedPrior:
    """Independent priors of terms that some have in common, as one."""
    found: dict[str, tuple[float, float]] = {}
    for prior in priors:
        variances = np.diag(prior.covariance)
        found |= {name: (prior.mean[i], variances[i]) for i, name in enumerate(prior.names)}
    values = np.array(list(found.values())).reshape(-1, 2)
    return SharedPrior(tuple(found), values[:, 0], np.diag(values[:, 1]))


def shared_prior(others: Sequence[RocketFit]) -> SharedPrior | None:
    """What other rockets together show of the shared terms; None without any."""
    if not others:
        return None
    return combined(merged([one.prior for one in others]), [one.message for one in others])


def joint_evidence(rockets: Sequence[RocketFit]) -> float:
    """Log marginal likelihood of all flights of a fleet, the shared terms integrated out. [nat]

    That of every rocket by itself, and how much more likely their messages are together than one by one.
    """
    prior = merged([one.prior for one in rockets])
    alone = sum(one.log_evidence - _log_mass(prior, [one.message]) for one in rockets)
    return float(alone + _log_mass(prior, [one.message for one in rockets]))


def _log_mass(prior: SharedPrior, messages: Sequence[Message]) -> float:
    """Logarithm of the integral of a normal prior times messages, each without its constant."""
    place = {name: i for i, name in enumerate(prior.names)}
    inverse = np.linalg.inv(prior.covariance)
    precision, shift = inverse.copy(), np.zeros(len(prior.names))
    for message in messages:
        rows = [place[name] for name in message.names]
        precision[np.ix_(rows, rows)] += message.precision
        shift[rows] += message.shift
    log_det = np.linalg.slogdet(inverse)[1] - np.linalg.slogdet(precision)[1]
    return float(0.5 * (log_det + shift @ np.linalg.solve(precision, shift)))
