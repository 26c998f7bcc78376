"""A single flight against the prior predictive distribution of its model: readouts that the rocket and its motor can
hardly produce, and parameters that the flight barely constrains.

Derivation: given the terms, the readouts of a flight are linear in them with normal errors, so without any data they
are jointly normal (Box, Sampling and Bayes' Inference in Scientific Modelling and Robustness, 1980). Each readout given
the others is normal too; with the precision P of the joint distribution and the misses m its standardized distance is
(P m)_i / sqrt(P_ii) (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, equation 5.12).
"""

from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from fieldkit.inference.evidence import term_posterior
from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.moments import Moments, moments
from fieldkit.inference.laplace.posterior import Solution, flight_evidence, normal_prior
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS
from fieldkit.model.rocket_model import Model

FALSE_ALARMS = 0.01
"""Probability that a flight from the prior has a readout that is called inconsistent. [1]"""


@dataclass(frozen=True, slots=True)
class InconsistentReadout:
    """A readout far from its prior predictive distribution given the flight's other readouts; value and the central 95%
    of that distribution, in SI. `alone` if there are no others."""

    name: str
    value: float
    low: float
    high: float
    alone: bool


def inconsistent_readout(linear: LinearFit) -> InconsistentReadout | None:
    """The readout of the first flight that agrees least with its others and with the prior; None if all are plausible.

    Rocket and device are taken to be usual ones: the scales of scatter and of reading errors are their prior medians.
    Without the worst readout the others agree best, because the squared distance of the whole flight falls by the
    square of the readout's own. The quantile of a normal error plus a Student t of reading and scatter is the root of
    their summed squares.
    """
    from scipy.special import stdtrit  # takes 0.1 s to import, and forecasts do not need it

    model, fit = _at_median_scales(linear.fit.model), linear.fit
    data = replace(fit.data, trust=np.ones_like(fit.data.trust))
    evidence = flight_evidence(model, data, fit.tangent)
    seen = np.flatnonzero((data.seen & np.isfinite(fit.tangent.values))[0, evidence.readouts])
    if not len(seen):
        return None
    slope, noise = evidence.slope[0, seen], evidence.noise()[0, 0][np.ix_(seen, seen)]
    precision = np.linalg.inv(slope @ normal_prior(model).covariance()[0] @ slope.T + noise)
    variance, own = 1 / np.diagonal(precision), np.diagonal(noise)
    away = precision @ evidence.miss[0, seen] * variance
    level = 1 - FALSE_ALARMS / (2 * len(seen))
    normal, tailed = NormalDist().inv_cdf(level), float(stdtrit(model.hyperprior.tail, level))
    limit = np.sqrt(np.maximum(variance - own, 0.0) * normal**2 + own * tailed**2)
    worst = int(np.argmax(np.abs(away) / limit))
    if abs(away[worst]) < limit[worst]:
        return None
    column = int(evidence.readouts[seen[worst]])
    value = float(data.values[0, column])
    half = NormalDist().inv_cdf(0.975) * float(np.sqrt(variance[worst]))
    figures = np.array([value, value - away[worst] - half, value - away[worst] + half])
    figures = np.exp(figures) if IS_LOGARITHMIC[column] else figures
    shown, low, high = figures.tolist()
    return InconsistentReadout(OBSERVED_READOUTS[column], shown, low, high, alone=len(seen) == 1)


def _at_median_scales(model: Model) -> Model:
    scales = (replace(one, grid=(one.median,)) for one in model.hyperprior.unknown_scales)
    return replace(model, hyperprior=model.hyperprior.with_scales(*scales))


def without_data(linear: LinearFit) -> Moments:
    """The forecasts of a linear fit's plans from the prior alone, at the same point of linearization."""
    fit = linear.fit
    means = np.array([term.mean for term in fit.model.terms])
    scales, terms = fit.mean.shape
    unchanged = term_posterior(
        np.zeros((scales, 0, 0)), np.zeros((scales, 0)), normal_prior(fit.model), np.zeros((0, terms))
    )
    solution = Solution(fit.evidence, np.broadcast_to(means, fit.mean.shape), unchanged)
    prior = replace(fit, solution=solution, log_weight=fit.model.hyperprior.scales()[2])
    return moments(replace(linear, fit=prior))
