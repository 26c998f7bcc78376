"""Information from each rocket's flights about the terms that a flyer's rockets share, and its combination.

Given the shared terms (for the fleet and for motor types), rockets are independent. The fit of one rocket gives a
normal posterior of the shared terms; divided by their prior it is the rocket's message, a likelihood. The prior of a
rocket is the common prior times the messages of the other rockets. This is exact for a linear model and belief
propagation otherwise.

Derivation: Bayes' rule for rockets that are independent given the shared terms; normal messages add their precisions.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.inference.laplace.scale_grids import flyer_scatter
from fieldkit.model.fleet_drift import Period
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import FlownFlights, Model, base_model, shared_names
from fieldkit.model.shared_prior import Message, SharedPrior, combined
from fieldkit.model.term_names import TermName
from fieldkit.physics.history import flown_and_planned


@dataclass(frozen=True, slots=True, eq=False)
class RocketFit:
    """The separate fit of one rocket: its log evidence [nat] and its message to the rest of the fleet. `scatter` is the
    log likelihood of the flyer's scale of scatter at its `nodes`. [nat]"""

    log_evidence: float
    message: Message
    prior: SharedPrior
    scatter: tuple[float, ...] = ()


def rocket_fit(flown: FlownFlights, hyperprior: Hyperprior, period: Period | None = None) -> RocketFit:
    """Fit the clean flights of one rocket without information from others; `period` is the fleet's, by default its own.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    history = flown_and_planned(flown)
    model = replace(base_model(history, hyperprior, period=period), coarse=True)
    result = fit_robustly(model, observe(history, hyperprior), causes=True)
    scatter = tuple(flyer_scatter(result).tolist())
    return RocketFit(result.log_evidence, message_of(result), independent_prior([model]), scatter)


def message_of(result: Fit, further: Sequence[TermName] = ()) -> Message:
    """The posterior of the shared terms divided by their prior; `further` names other terms that rockets share.

    The mixture over scales is approximated by a normal distribution with its moments. If scales disagree, this may be
    wider than the prior in some direction; the message then has no information in that direction.
    """
    names = [*shared_names(result.model), *further]
    rows = [result.model.names.index(name) for name in names]
    weights, mean = result.weights, result.mean[:, rows]
    middle = weights @ mean
    covariance = np.einsum("s,sij->ij", weights, result.covariance[:, rows][:, :, rows])
    covariance += np.einsum("s,si,sj->ij", weights, mean - middle, mean - middle)
    prior_mean = np.array([result.model.terms[row].mean for row in rows])
    prior_sd = np.array([result.model.terms[row].sd for row in rows])
    # in units of the prior, in which the message's precision is the posterior's minus one
    values, vectors = np.linalg.eigh(covariance / np.outer(prior_sd, prior_sd))
    gained = np.maximum(1 / np.maximum(values, 1e-9) - 1, 0.0)
    moved = vectors.T @ ((middle - prior_mean) / prior_sd)
    precision = (vectors * gained) @ vectors.T / np.outer(prior_sd, prior_sd)
    shift = (vectors @ ((gained + (gained > 0)) * moved)) / prior_sd
    return Message(tuple(names), np.asarray(0.5 * (precision + precision.T)), shift)


def independent_prior(models: Sequence[Model], further: Sequence[TermName] = ()) -> SharedPrior:
    """The independent priors of all shared terms of some models, from the hyperprior; `further` as in `message_of`."""
    shared = [{*shared_names(model), *further} for model in models]
    terms = {
        term.name: term for model, own in zip(models, shared, strict=True) for term in model.terms if term.name in own
    }
    means, sds = (np.array([getattr(term, name) for term in terms.values()]) for name in ("mean", "sd"))
    return SharedPrior(tuple(terms), means, np.diag(sds**2))


def merged(priors: Sequence[SharedPrior]) -> SharedPrior:
    """Independent priors with some common terms, merged into one."""
    found: dict[TermName, tuple[float, float]] = {}
    for prior in priors:
        variances = np.diag(prior.covariance)
        found |= {name: (prior.mean[i], variances[i]) for i, name in enumerate(prior.names)}
    values = np.array(list(found.values())).reshape(-1, 2)
    return SharedPrior(tuple(found), values[:, 0], np.diag(values[:, 1]))


def shared_prior(others: Sequence[RocketFit], period: Period | None = None) -> SharedPrior | None:
    """The combined information from other rockets about the shared terms; None if there are none. `period` is that of
    the whole fleet, for which they were fitted."""
    if not others:
        return None
    known = combined(merged([one.prior for one in others]), [one.message for one in others])
    scatter = (
        tuple(np.sum([one.scatter for one in others], axis=0).tolist()) if all(one.scatter for one in others) else ()
    )
    return replace(known, period=period, scatter=scatter)


def joint_evidence(rockets: Sequence[RocketFit], prior: SharedPrior | None = None) -> float:
    """Log marginal likelihood of all flights of a fleet, the shared terms integrated out over a prior, by default that
    of the separate fits. [nat]

    The sum over rockets, plus the log ratio of the joint likelihood of their messages to the product of separate ones.
    """
    own = merged([one.prior for one in rockets])
    alone = sum(one.log_evidence - _log_integral(own, [one.message]) for one in rockets)
    return float(alone + _log_integral(prior or own, [one.message for one in rockets]))


def _log_integral(prior: SharedPrior, messages: Sequence[Message]) -> float:
    """Logarithm of the integral of a normal prior times messages, without the constants of the messages."""
    known = combined(prior, messages)
    moved = known.mean - prior.mean
    log_det = np.linalg.slogdet(known.covariance)[1] - np.linalg.slogdet(prior.covariance)[1]
    return float(0.5 * (log_det + moved @ np.linalg.solve(known.covariance, moved)))
